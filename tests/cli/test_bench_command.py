"""relight bench: what it refuses before anything slow starts, and how long it measures."""

import argparse
import itertools
import subprocess
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
import torch

from app.cli import bench
from relight_core.errors import InputError
from relight_core.evaluation import bench_accuracy, bench_configurations, bench_machine, bench_session, bench_timing
from relight_core.evaluation.bench_configurations import configurations
from relight_core.lighting.rigs import rig_names
from relight_core.networks.bundle import BundleConfig
from relight_core.pipeline import relighter


def refused_in_one_line(done, told):
    assert done.code == 2
    assert told in done.err
    assert done.err.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--photos", "nowhere"], "no such photo or folder"),
        (["--heads", "heads"], "--lights"),
        (["--rounds", "0"], "whole number"),
    ],
)
def test_bad_input_is_one_line(relight, tmp_path, monkeypatch, words, told):
    monkeypatch.chdir(tmp_path)
    refused_in_one_line(relight("bench", *words), told)


def test_a_folder_without_photos(relight, tmp_path):
    done = relight("bench", "--photos", tmp_path, "-o", tmp_path / "out")
    assert done.code == 2
    assert "no photos" in done.err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--files", "--session"], "--session"),
        (["--stability", "--files"], "--files"),
        (["--files", "--weights", "w.safetensors"], "--weights"),
        (["--files", "--device", "cuda"], "--device"),
        (["--session", "--heads", "heads", "--lights", "l.npz"], "--heads"),
        (["--stability", "--rounds", "3"], "--rounds"),
        (["--stability", "--count", "8"], "--count"),
        (["--files", "--turns", "24"], "--turns"),
        (["--session", "--count", "3"], "--count"),
        (["--session", "--quick", "--lights", "l.npz"], "--lights"),
        (["--session", "--quick", "--turns", "3"], "--turns"),
        (["--turns", "3"], "--turns"),
        (["--lights", "l.npz"], "--lights"),
        (["--count", "3"], "--count"),
        (["--quick", "--heads", "heads", "--lights", "l.npz", "--count", "3"], "--count"),
    ],
)
def test_what_would_be_ignored_is_refused(relight, tmp_path, monkeypatch, words, told):
    monkeypatch.chdir(tmp_path)
    refused_in_one_line(relight("bench", *words), told)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("wish", ["--files", "--stability"])
def test_photos_beyond_the_one_that_is_measured_are_refused(relight, tmp_path, wish):
    for name in ("a.png", "b.png"):
        (tmp_path / name).touch()
    refused_in_one_line(relight("bench", wish, "--photos", tmp_path, "-o", tmp_path / "out"), "one photo")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("words", [[], ["--session"], ["--files"], ["--stability"]])
def test_one_photo_is_measured_as_a_folder_with_it_alone_is(relight, tmp_path, monkeypatch, words):
    read = []
    measures = {"_bench": list, "_session": list, "_files": lambda photo: [photo], "_stability": lambda photo: [photo]}
    for name, photos_of in measures.items():
        monkeypatch.setattr(bench, name, lambda _, photos, __, of=photos_of: read.append(of(photos)) or 0)
    cv2.imwrite(str(tmp_path / "me.png"), np.full((8, 8, 3), 90, np.uint8))
    for place in (tmp_path / "me.png", tmp_path):
        assert relight("bench", *words, "--photos", place, "-o", tmp_path / "out").code == 0
    assert [[photo.path for photo in photos] for photos in read] == [[tmp_path / "me.png"]] * 2


def test_a_file_after_photos_that_is_none_is_refused_in_one_line(relight, tmp_path):
    (tmp_path / "notes.txt").write_text("no pixels")
    refused_in_one_line(relight("bench", "--photos", tmp_path / "notes.txt", "-o", tmp_path / "out"), "notes.txt: not")


@pytest.fixture
def measured(monkeypatch, weights):
    """What `bench --quick` is told of every setting, made up, and what it makes of that."""
    names = [setting.name for setting in configurations(quick=True)]
    errors = {name: 0.01 * number for number, name in enumerate(names)}
    times = {name: f"times of {name}" for name in names}
    monkeypatch.setattr(bench, "_first_picture_s", lambda starts: starts)
    monkeypatch.setattr(bench, "_timed", lambda *_: times)
    monkeypatch.setattr(bench_accuracy, "against_final", lambda *_: errors)
    for name in ("describe_machine", "measure_peaks"):
        monkeypatch.setattr(bench_machine, name, lambda *_: {})
    monkeypatch.setattr(bench_machine, "demands", lambda bundle, tier, device: tier)
    monkeypatch.setattr(relighter, "Relighter", lambda *given: given == (weights, "cpu") or pytest.fail(str(given)))
    return errors, times, lambda *words: list(bench._measured(parsed("--weights", str(weights), *words), []))


def test_errors_against_the_final_tier_are_told_with_the_times_of_the_same_setting(measured):
    errors, times, results = measured
    (result,) = results("--quick")
    assert result.machine == {"first_picture_s": 1}
    found = {row.configuration.name: (row.timing, row.accuracy.against_final) for row in result.rows}
    assert found == {name: (times[name], errors[name]) for name in times}
    assert all(row.demands == row.configuration.tier for row in result.rows)


@pytest.mark.parametrize(
    ("words", "heads", "cases"), [(("--quick",), 1, 3), ((), 8, 20), (("--count", "5"), 5, 20)], ids=str
)
def test_errors_against_the_truth_are_told_beside_those_against_the_final_tier(
    measured, monkeypatch, words, heads, cases
):
    errors, _, results = measured
    asked = []

    def against_truth(bundle, data, settings, *_):
        assert bundle.config == BundleConfig.tiny(), "other weights than those that were given"
        asked.append((str(data.heads), str(data.lights), data.count, data.cases))
        return {setting.name: bench_accuracy.Accuracy(rmse=len(setting.name), psnr=1.0) for setting in settings}

    monkeypatch.setattr(bench_accuracy, "against_truth", against_truth)
    monkeypatch.setattr(bench_configurations, "configurations", lambda quick: configurations(quick=True))
    before, after = results("--heads", "heads", "--lights", "lights", *words)
    assert asked == [("heads", "lights", heads, cases)]
    for result, rmse in ((before, None), (after, len)):
        found = {row.configuration.name: (row.accuracy.rmse, row.accuracy.against_final) for row in result.rows}
        assert found == {name: (rmse and rmse(name), error) for name, error in errors.items()}


@pytest.mark.parametrize("words", [[], ["--session"]])
def test_a_device_that_is_not_there(relight, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    done = relight("bench", "--device", "cuda", *words)
    refused_in_one_line(done, "--device cuda")
    assert "fault of ours" not in done.err


def test_a_folder_of_panoramas_is_visited(tmp_path):
    for name, level in (("dusk", 0.5), ("noon", 4.0)):
        cv2.imwrite(str(tmp_path / f"{name}.hdr"), np.full((8, 16, 3), level, np.float32))
    lights = bench._visited_lights(tmp_path)
    assert [light.name for light in lights] == ["dusk", "noon"]
    assert [light.level for light in lights] == pytest.approx([0.5, 4.0], rel=1e-2)


def test_a_library_without_places_is_refused_before_it_is_visited(tmp_path):
    path = tmp_path / "lights.npz"
    np.savez(path, env64=np.ones((2, 64, 128, 3), np.float16), names=["dusk", "noon"])
    with pytest.raises(InputError, match="group"):
        bench._visited_lights(path)


def parsed(*words):
    parser = argparse.ArgumentParser()
    bench.add_arguments(parser)
    return parser.parse_args(words)


@pytest.mark.parametrize(
    ("words", "rounds"), [((), 30), (("--quick",), 5), (("--rounds", "7"), 7), (("--quick", "--rounds", "2"), 2)]
)
def test_every_setting_has_its_turn_as_often_as_was_asked_for(monkeypatch, words, rounds):
    asked = []
    monkeypatch.setattr(bench_timing, "time_configurations", lambda *given, **named: asked.append((given, named)))
    bench._timed(parsed(*words, "--device", "cuda"), "a relighter", ["a photo"], ["a setting"])
    ((given, named),) = asked
    assert (given[0], given[1], given[2].name, given[3]) == ("a relighter", ["a photo"], "rembrandt", ["a setting"])
    assert (named["rounds"], named["device"]) == (rounds, "cuda")
    # What the window's shader draws a picture from is made with the picture.
    assert named["display"](SimpleNamespace(recipe="a recipe")) == "a recipe"


def test_the_first_picture_is_as_quick_as_the_quickest_start_and_unknown_where_none_comes(monkeypatch):
    codes = []
    monkeypatch.setattr(bench.subprocess, "run", lambda *_, **__: subprocess.CompletedProcess([], codes.pop()))
    monkeypatch.setattr(bench.time, "perf_counter", itertools.chain([0, 3, 10, 12, 20, 24], itertools.count()).__next__)
    codes.extend([0, 0, 0])
    assert bench._first_picture_s(3) == 2
    codes.extend([2, 0])
    assert bench._first_picture_s(3) is None


@pytest.mark.parametrize(("words", "turns"), [((), 24), (("--quick",), 12), (("--turns", "5"), 5)])
def test_a_session_is_replayed_on_every_photo_with_the_weights_that_are_measured(monkeypatch, words, turns):
    made, played = [], []
    monkeypatch.setattr(relighter, "Relighter", lambda *given: made.append(given) or f"relighter {len(made)}")
    monkeypatch.setattr(bench_machine, "describe_machine", lambda device: {})
    monkeypatch.setattr(bench_session, "replay", lambda *given, report: played.append(given))
    monkeypatch.setattr(bench_session, "as_markdown", lambda savings: "a table")
    monkeypatch.setattr(bench_session.Savings, "as_record", lambda savings: {})
    monkeypatch.setattr(bench_session, "recorded_session", lambda lights, turns: [(lights[0], turns)] * 4)
    monkeypatch.setattr(bench_session, "visits", lambda lights, turns: [(light, turns) for light in lights])
    pages = list(bench._replayed(parsed("--weights", "w.safetensors", *words), ["one", "two"]))
    assert [str(weights) for weights, _ in made] == ["w.safetensors"] * 2
    assert {given[:2] for given in played} == {("relighter 1", "relighter 2")}
    assert [given[2] for given in played] == ["one", "one", "two", "two"]
    assert {turned for given in played for _, turned in given[3]} == {turns}
    # Both photos' sessions are counted together, and their visits apart from those.
    (one, visited), (other, visited_again) = ([given[4] for given in played[at : at + 2]] for at in (0, 2))
    assert one is other
    assert visited is visited_again
    assert visited is not one
    assert [record["photos"] for _, record in pages] == [1, 2]
    visited = 3 if "--quick" in words else len(rig_names())
    assert (pages[0][1]["session"]["lights"], pages[0][1]["visits"]["lights"]) == (1, visited)
    assert f"visits: 2 photos, {visited} lights" in pages[1][0]


@pytest.mark.parametrize(
    ("words", "name"),
    [([], "bench.png"), (["--session"], "session.json"), (["--files"], "files.md"), (["--stability"], "stability.png")],
)
def test_a_photo_called_as_what_is_written_is_not_written_over(relight, tmp_path, monkeypatch, words, name):
    for measure in ("_bench", "_session", "_files", "_stability"):
        monkeypatch.setattr(bench, measure, lambda *_: pytest.fail("it was measured"))
    photo = tmp_path / name
    photo.write_bytes(cv2.imencode(".png", np.full((8, 8, 3), 90, np.uint8))[1].tobytes())
    before = photo.read_bytes()
    refused_in_one_line(relight("bench", *words, "--photos", photo, "-o", tmp_path), f"{photo}: that is the input")
    assert photo.read_bytes() == before


@pytest.mark.parametrize("broken", ["session", "visits", None])
def test_a_session_s_picture_that_exceeds_its_bound_is_told_by_the_exit_code_and_all_is_written(
    relight, tmp_path, monkeypatch, broken
):
    def record(photos):
        plays = {name: {"broken": ["ring at 30 degrees"] if name == broken else []} for name in ("session", "visits")}
        return {"machine": {}, "photos": photos, **plays}

    monkeypatch.setattr(bench, "_replayed", lambda *_: iter([("one photo", record(1)), ("two photos", record(2))]))
    assert relight("bench", "--session", "-o", tmp_path).code == (0 if broken is None else 1)
    assert (tmp_path / "session.md").read_text() == "two photos"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["session.json", "session.md"]
