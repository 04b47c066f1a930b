"""What the bench asks for its errors and times, and what it makes of the answers."""

from types import SimpleNamespace

import numpy as np
import pytest
from synthetic_heads import write_balls, write_lights

from relight_core.evaluation import bench_accuracy, bench_timing
from relight_core.evaluation.bench_accuracy import HeldOutData, against_final, against_truth
from relight_core.evaluation.bench_configurations import Configuration
from relight_core.evaluation.bench_timing import Spread, time_configurations
from relight_core.evaluation.held_out import held_out_lights
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.pipeline.quality import Tier

FAST, SLOW = Tier(32, 32, 32, 8, False), Tier(32, 32, 32, 8, True)
SETTINGS = [Configuration("fast", FAST, "live", False), Configuration("slow", SLOW, "final", False)]


def some_lights(count):
    return [Environment.from_radiance(np.ones((16, 32, 3), np.float32), f"light {n}") for n in range(count)]


class OffBy:
    """In place of a relighter: black in the face at final quality, else off by so much; wrong wherever no face is."""

    def __init__(self, errors):
        self.errors, self.asked = errors, []

    def set_portrait(self, photo):
        self.photo = photo

    def relight(self, light, edit):
        self.asked.append((light.name, edit.quality, edit.yaw_deg))
        image = np.full(self.photo.linear.shape, 0.0 if edit.quality == "final" else 1.0, np.float32)
        image[4:14, 30:40] = 0.0 if edit.quality == "final" else self.errors[edit.quality, light.name]
        return SimpleNamespace(image=image, faces=[FaceBox(31.0, 4.0, 39.0, 14.0)])


def test_errors_against_the_final_tier_are_of_the_face_as_it_is_shown_pooled_over_pictures():
    # Below 0.0031308 what is displayed is 12.92 times as much.
    errors = {(FAST, "light 0"): 0.001, (FAST, "light 1"): 0.003, (SLOW, "light 0"): 0.0, (SLOW, "light 1"): 0.002}
    relighter, told = OffBy(errors), []
    photo = Photo(np.full((20, 60, 3), 0.2, np.float32))
    found = against_final(relighter, [photo], some_lights(2), SETTINGS, lambda *at: told.append(at))
    assert found["fast"] == pytest.approx(12.92 * np.sqrt((0.001**2 + 0.003**2) / 2), rel=1e-4)
    assert found["slow"] == pytest.approx(12.92 * 0.002 / np.sqrt(2), rel=1e-4)
    assert [(light, quality) for light, quality, _ in relighter.asked] == [
        (light, quality) for light in ("light 0", "light 1") for quality in ("final", FAST, SLOW)
    ]
    yaws_deg = [yaw for *_, yaw in relighter.asked]
    assert yaws_deg[:3] == yaws_deg[:1] * 3
    assert yaws_deg[3:] == yaws_deg[3:4] * 3
    assert yaws_deg[0] != yaws_deg[3]
    assert told == [(1, 2), (2, 2)]


def test_errors_against_the_truth_are_means_over_panoramas_of_every_setting_s_own_tier(tmp_path, monkeypatch):
    write_balls(tmp_path / "heads", 2_000_000, 3, size=16)
    write_lights(tmp_path / "lights.npz", 3)
    lights, asked = held_out_lights(tmp_path / "lights.npz", "test"), []

    class Told:
        def __init__(self, editor, head, lights, photos):
            assert photos == "clean"
            self.name, self.mirrored = head.name, editor.tier.mirrored

        def score(self, case):
            asked.append((self.name, self.mirrored, case))
            figures = {"relit.rmse": 0.1 + 0.2 * self.mirrored, "relit.psnr": float(len(asked) % 2)}
            return {"panoramas": figures, "face": {"relit.rmse": 9.0, "relit.psnr": 9.0}}

    monkeypatch.setattr(bench_accuracy, "Bench", Told)
    bundle, told = NetworkBundle(BundleConfig.tiny()), []
    data = HeldOutData(tmp_path / "heads", tmp_path / "lights.npz", 2, 2)
    found = against_truth(bundle, data, SETTINGS, lambda *at: told.append(at))
    assert (found["fast"].rmse, found["slow"].rmse) == (pytest.approx(0.1), pytest.approx(0.3))
    assert (found["fast"].psnr, found["slow"].psnr) == (0.5, 0.5)
    assert found["fast"].against_final is None
    assert told == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert {name for name, *_ in asked} == {"head-2000000", "head-2000001"}
    # Of three panoramas the first and the last, by every setting and for each head.
    assert [case.source for *_, case in asked] == [0, 2] * 4
    assert not any(lights[case.target].lamp for *_, case in asked)


class Timed:
    """In place of a relighter: de-lighting takes longer from run to run, and a slider's stages less than a turn's."""

    def __init__(self):
        self.edits, self.forgotten = [], []

    def set_portrait(self, photo):
        pass

    def forget(self, name):
        self.forgotten.append(name)

    def relight(self, light, edit, screen_px, for_shader):
        self.edits.append(edit)
        turned = len(self.edits) % 3 == 1
        stages = {
            "delight": SimpleNamespace(ms=10.0 * len(self.forgotten), state="computed", is_of_photo=True),
            "compose": SimpleNamespace(ms=3.0 if turned else 7.0, state="computed", is_of_photo=False),
            "matte": SimpleNamespace(ms=0.0, state="reused", is_of_photo=False),
        }
        if not turned:
            return SimpleNamespace(stages=stages)
        return SimpleNamespace(stages={name: stages[name] for name in ("compose", "matte")})


def test_times_are_of_what_is_done_after_the_warm_ups_and_the_most_memory_of_them(monkeypatch):
    memory = iter([900.0, 900.0, 100.0, 300.0, 200.0, 100.0])
    monkeypatch.setattr(bench_timing, "peak_memory_mib", lambda device: next(memory))
    relighter = Timed()
    found = time_configurations(relighter, ["a photo"], some_lights(1)[0], SETTINGS[:1], rounds=4)["fast"]
    # Six runs, of which the first two warm up: 30, 40, 50 and 60 ms.
    assert found.actions["delight"] == found.stages["delight"] == Spread(45.0, pytest.approx(58.5))
    assert found.stages["compose"] == Spread(3.0, 3.0)
    assert set(found.stages) == {"delight", "compose", "display"}
    assert found.memory_mib == 300.0
    assert relighter.forgotten == ["delight"] * 6
    assert {edit.quality for edit in relighter.edits} == {FAST}
    for turned, opened, moved in zip(*(relighter.edits[at::3] for at in range(3)), strict=True):
        assert turned.yaw_deg == opened.yaw_deg == moved.yaw_deg
        assert (turned.shadow, opened.shadow) == (1, 1)
        assert 0 < moved.shadow < 1
    assert len({edit.yaw_deg for edit in relighter.edits}) == 6


def test_an_update_is_timed_up_to_the_viewport_and_without_what_a_photo_costs_once(monkeypatch):
    """De-lighting was forgotten, so that the next turn finds it anew: that is no part of what a turn takes."""
    now_ms, relighter = [0.0], Timed()

    def relight(light, edit, screen_px, for_shader):
        again = relighter.forgotten and len(relighter.edits) % 3 == 0
        relit = Timed.relight(relighter, light, edit, screen_px, for_shader)
        compose_ms = relit.stages["compose"].ms
        once = SimpleNamespace(ms=500.0 * bool(again), state="computed", is_of_photo=True)
        now_ms[0] += compose_ms + once.ms
        return SimpleNamespace(stages={"compose": relit.stages["compose"], "delight": once})

    def display(relit):
        now_ms[0] += 2.0

    monkeypatch.setattr(relighter, "relight", relight)
    monkeypatch.setattr(bench_timing, "perf_counter", lambda: now_ms[0] / 1e3)
    light = some_lights(1)[0]
    found = time_configurations(relighter, ["a photo"], light, SETTINGS[:1], rounds=4, display=display)["fast"]
    assert found.actions["rotation"].median == pytest.approx(5.0)
    assert found.actions["slider"].median == pytest.approx(9.0)
    assert found.stages["display"].median == pytest.approx(2.0)
