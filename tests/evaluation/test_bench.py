"""The bench: what it compares, how it ranks and what it writes, with tiny networks."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from synthetic_heads import write_balls, write_lights

from relight_core.evaluation import bench_configurations, bench_timing
from relight_core.evaluation.bench_accuracy import Accuracy, HeldOutData, against_final, against_truth
from relight_core.evaluation.bench_configurations import Configuration, configurations
from relight_core.evaluation.bench_machine import Demand, Peaks, demands, describe_machine, measure_peaks
from relight_core.evaluation.bench_report import (
    BenchResult,
    Row,
    as_full_record,
    as_markdown,
    as_record,
    pareto,
    plot,
)
from relight_core.evaluation.bench_session import Savings, recorded_session, replay, visits
from relight_core.evaluation.bench_session import as_markdown as session_words
from relight_core.evaluation.bench_timing import Spread, Timing, time_configurations
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment
from relight_core.lighting.rigs import load_rig
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.pipeline import quality
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_photo import choosing_faces
from relight_core.pipeline.quality import Tier
from relight_core.pipeline.relighter import Relighter

SMALL = Tier(32, 32, 32, 8, False)
TIERS = {"draft": replace(SMALL, shadow_network=False), "live": SMALL, "final": replace(SMALL, mirrored=True)}
SETTINGS = [Configuration(name, tier, name, True) for name, tier in TIERS.items()]


@pytest.fixture(autouse=True)
def _small_tiers(monkeypatch):
    monkeypatch.setattr(quality, "TIERS", TIERS)
    monkeypatch.setattr(choosing_faces, "find_faces", lambda photo, *judge: [FaceBox(8, 8, 24, 28)])


@pytest.fixture
def photo():
    return Photo(np.random.default_rng(0).random((40, 36, 3), np.float32))


def some_light(seed=0):
    return Environment.from_radiance(np.random.default_rng(seed).gamma(0.5, 1, (16, 32, 3)), f"light {seed}")


def some_sky():
    rows = np.random.default_rng(1).random((16, 1, 3))
    return Environment.from_radiance(np.repeat(rows, 32, axis=1), "sky")


def test_the_tiers_come_first_and_no_setting_twice():
    found = configurations()
    assert [setting.name for setting in found[:3]] == ["draft", "live", "final"]
    assert len({setting.tier for setting in found}) == len(found)
    assert all(setting.tier.network_size <= setting.tier.delight_size for setting in found)
    assert len(configurations(quick=True)) < len(found)


def test_sizes_follow_the_tier_table(monkeypatch):
    monkeypatch.setitem(bench_configurations.TIERS, "live", Tier(512, 512, 256, 64, False))
    sizes = {setting.tier.network_size for setting in configurations() if setting.tier_name == "live"}
    assert sizes == {256, 128, 192, 384}


def test_the_front_is_what_nothing_beats():
    points = [(10.0, 0.5), (20.0, 0.2), (25.0, 0.3), (30.0, 0.2), (5.0, 0.9), (20.0, 0.2)]
    assert pareto(points) == [True, True, False, False, True, True]


def test_peaks_and_limits_are_positive_and_follow_the_size():
    peaks = measure_peaks()
    assert min(*peaks.gflops.values(), peaks.bandwidth_gb_s) > 0
    bundle = NetworkBundle(BundleConfig.tiny()).for_inference()
    small = demands(bundle, SMALL)
    large = demands(bundle, replace(SMALL, delight_size=64, network_size=64))
    assert set(small) == {"delight", "specular_shadow", "compose"}
    for name in ("specular_shadow", "compose"):
        # The light's modulations do not grow with the picture.
        assert 2 < large[name].gflop / small[name].gflop <= 4.01
    assert set(demands(bundle, replace(SMALL, shadow_network=False, correction=False))) == {"delight"}


def test_the_limit_is_the_slower_of_arithmetic_and_traffic():
    peaks = Peaks({"fp32": 100.0, "bf16": 200.0}, 10.0)
    assert Demand(2.0, 1.0).least_ms(peaks, "bf16") == pytest.approx(10.0)
    assert Demand(0.001, 50.0).least_ms(peaks, "bf16") == pytest.approx(5.0)
    assert Demand(2.0, 1.0).least_ms(Peaks({"fp32": 100.0}, 10.0), "bf16") == pytest.approx(20.0)


def test_every_setting_is_timed_in_every_action(weights, photo):
    relighter, shown = Relighter(weights), []
    timing = time_configurations(relighter, [photo], some_light(), SETTINGS, rounds=2, display=shown.append)
    assert set(timing) == {"draft", "live", "final"}
    for found in timing.values():
        assert set(found.actions) == {"delight", "rotation", "slider"}
        assert all(spread.p95 >= spread.median > 0 for spread in found.actions.values())
        assert {"delight", "compose", "specular_shadow", "detail", "recipe", "display"} <= set(found.stages)
        assert "matte" not in found.stages
    assert len(shown) == 3 * 2 * (2 + 2)


def test_what_runs_once_a_photo_is_no_cost_of_a_light_on_a_first_visit_either(weights, photo, monkeypatch):
    seen = time_configurations(Relighter(weights), [photo], some_light(), SETTINGS, rounds=1)
    monkeypatch.setattr(bench_timing, "_WARM_UPS", 0)
    unseen = time_configurations(Relighter(weights), [photo], some_light(), SETTINGS, rounds=1)
    assert {name: set(found.stages) for name, found in unseen.items()} == {
        name: set(found.stages) for name, found in seen.items()
    }


def test_all_photos_are_timed(weights, photo):
    wide, shown, done = Photo(np.concatenate([photo.linear, photo.linear], axis=1)), [], []

    def display(relit):
        shown.append(relit.recipe.size)

    time_configurations(
        Relighter(weights),
        [photo, wide],
        some_light(),
        SETTINGS[:1],
        rounds=3,
        display=display,
        report=lambda *at: done.append(at),
    )
    assert shown == [(40, 36)] * 8 + [(40, 72)] * 8
    assert done[-1] == (8, 8)


def test_the_final_tier_does_not_differ_from_itself(weights, photo):
    errors = against_final(Relighter(weights), [photo], [some_light(), some_light(1)], SETTINGS)
    assert errors["final"] == 0
    assert errors["draft"] > 0


def test_errors_against_the_truth(tmp_path):
    write_balls(tmp_path / "heads", 2_000_000, 1, size=16)
    write_lights(tmp_path / "lights.npz", 3)
    bundle = NetworkBundle(BundleConfig.tiny()).for_inference()
    data = HeldOutData(tmp_path / "heads", tmp_path / "lights.npz", 1, 2)
    accuracy = against_truth(bundle, data, SETTINGS[:2])
    assert set(accuracy) == {"draft", "live"}
    for found in accuracy.values():
        assert 0 < found.rmse < 1
        assert math.isfinite(found.psnr)


def result():
    spread = Spread(2.0, 3.0)
    timing = Timing(dict.fromkeys(("delight", "rotation", "slider"), spread), {"compose": spread}, 100.0)
    rows = [
        Row(setting, timing, Accuracy(0.1, 20.0, index / 100), {"compose": Demand(1.0, 2.0)})
        for index, setting in enumerate(SETTINGS)
    ]
    return BenchResult(describe_machine(), Peaks({"fp32": 50.0}, 8.0), rows)


def test_the_record_has_the_agreed_shape():
    record = json.loads(json.dumps(as_record(result()), allow_nan=False))
    assert set(record) == {"machine", "configurations"}
    entry = record["configurations"][1]
    assert entry == {
        "name": "live",
        "tier": "live",
        "ms": {name: {"median": 2.0, "p95": 3.0} for name in ("delight", "rotation", "slider")},
        "error": {"rmse": 0.1, "psnr": 20.0, "against_final": 0.01},
        "memory_mib": 100.0,
    }


def test_the_full_record_tells_stages_and_limits():
    entry = as_full_record(result())["configurations"][0]
    assert entry["stages"]["compose"] == {"median": 2.0, "p95": 3.0}
    assert entry["networks"]["compose"]["least_ms"] == 20.0
    assert entry["settings"]["network_size"] == 32


def test_tables_and_plot_are_made_with_and_without_truth(tmp_path):
    whole = result()
    without = replace(whole, rows=[replace(row, accuracy=Accuracy()) for row in whole.rows])
    for number, found in enumerate((whole, without)):
        page = as_markdown(found)
        assert "**live**" in page
        assert "compose" in page
        plot(found, tmp_path / f"{number}.part")
        assert (tmp_path / f"{number}.part").read_bytes().startswith(b"\x89PNG")


def test_a_session_saves_work_and_errs_by_no_more_than_it_says(weights, photo):
    session = recorded_session([some_light(), some_sky()], turns=3)
    assert len(session) == 2 * (1 + 3 + 20 + 20 + 1)
    savings = Savings()
    replay(Relighter(weights), Relighter(weights), photo, session[:12] + session[45:50], savings, compare_every=3)
    assert savings.updates == 17
    assert 0 < savings.avoided < savings.runs
    assert savings.ms < savings.ms_of_everything
    assert savings.compared >= 5
    assert savings.broken == []
    assert "stage runs avoided" in session_words(savings)
    assert 0 < json.loads(json.dumps(savings.as_record()))["share_avoided"] < 1


def test_what_a_light_brings_is_worked_out_anew_to_compare_with(weights, photo, monkeypatch):
    thorough, told = Relighter(weights), []
    original = thorough.relight
    monkeypatch.setattr(thorough, "relight", lambda *given: told.append(original(*given)) or told[-1])
    step = load_rig("hard-side"), Edit(quality="live")
    replay(Relighter(weights), thorough, photo, [step, step], Savings(), compare_every=1)
    for stage in ("irradiance", "hard_shadow", "fine_edges"):
        assert [relit.stages[stage].state for relit in told] == ["computed", "computed"], stage
    reused = {name for name, stage in told[1].stages.items() if stage.state == "reused"}
    assert reused <= {name for name, stage in told[0].stages.items() if stage.is_of_photo}


def test_a_picture_out_of_bounds_is_told(weights, photo, monkeypatch):
    relighter = Relighter(weights)
    original = relighter.relight
    monkeypatch.setattr(
        relighter, "relight", lambda light, edit: replace(original(light, edit), image=photo.linear * 0.5)
    )
    savings = Savings()
    replay(relighter, Relighter(weights), photo, recorded_session([some_light()], 2)[:1], savings)
    assert len(savings.broken) == 1
    assert "OUT OF BOUNDS" in session_words(savings)


@pytest.mark.parametrize("turns", [1, 7, 12, 24, 35])
def test_visits_of_enough_lights_come_to_every_stop_of_the_circle(turns):
    lights = [some_light(number) for number in range((turns + 1) // 2)]
    yaws_deg = {edit.yaw_deg for light, edit in visits(lights, turns) if light in lights and edit.quality == "live"}
    assert sorted(yaws_deg) == pytest.approx([360 * stop / turns for stop in range(turns)])


def test_visits_try_every_rule_under_every_light(weights, photo):
    lights = [some_light(), some_sky()]
    steps = visits(lights, turns=24)
    assert len(steps) == 2 * 6 + 1
    assert len({edit.yaw_deg for light, edit in steps if light in lights and edit.channels == ()}) == 4
    savings = Savings()
    replay(Relighter(weights), Relighter(weights), photo, [*steps[:6], steps[-1]], savings, compare_every=1)
    assert savings.compared == 7
    assert savings.broken == []
    rules = {(effect, why): rule for (effect, _, why), rule in savings.rules.items()}
    assert rules["shadow", "the light is black"].compared == 1
    at_rest = next(rule for (effect, why), rule in rules.items() if effect == "sliders" and "change nothing" in why)
    assert at_rest.largest_error <= 1 / 255
    assert rules["relief", "nothing it reads has changed"].times > 0
    assert "| the light is black |" in session_words(savings)
