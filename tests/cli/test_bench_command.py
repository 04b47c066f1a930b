"""relight bench: what it refuses before anything slow starts."""

import cv2
import numpy as np
import pytest
import torch

from app.cli import bench
from relight_core.errors import InputError


def refused_in_one_line(done, told):
    assert done.code == 2
    assert told in done.err
    assert done.err.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--photos", "nowhere"], "no such folder"),
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
