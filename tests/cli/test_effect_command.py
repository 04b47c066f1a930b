"""relight dataset effect: bad input in one line before anything is trained, and what is told of its photos."""

import cv2
import numpy as np
import pytest
from PIL import Image
from refusals import refused
from synthetic_heads import write_balls, write_lights

from relight_core.evaluation import dataset_effect


@pytest.fixture
def data(tmp_path):
    write_lights(tmp_path / "lights.npz", 32)
    write_balls(tmp_path / "heads", 0, 1, size=32)
    return tmp_path


def test_effect_refuses(run, data):
    words = ["dataset", "effect", "--shards", data / "heads", "--lights", data / "lights.npz", "-o", data / "s.png"]
    refused(run(*words, "--bare", data / "heads", "--photos", data, "--size", 65), "multiple")
    refused(run(*words, "--bare", data / "heads", "--photos", data, "--size", 64), "no size of 64", "dataset effect")
    words += ["--size", 32]
    refused(run(*words, "--bare", data / "heads", "--photos", data / "gone"), "gone")
    refused(run(*words, "--bare", data / "none", "--photos", data), "none")
    refused(run(*words, "--bare", data / "heads", "--photos", data), "no photos in this folder")


def test_effect_tells_of_a_photo_it_can_t_read_before_it_trains(run, data, tmp_path, monkeypatch):
    monkeypatch.setattr(dataset_effect, "trained", lambda *_, **__: pytest.fail("trained in vain"))
    (tmp_path / "torn.jpg").write_bytes(b"torn")
    words = ["dataset", "effect", "--shards", data / "heads", "--lights", data / "lights.npz", "-o", data / "s.png"]
    words += ["--size", 32]
    refused(run(*words, "--bare", data / "heads", "--photos", tmp_path), "torn.jpg")


def test_effect_tells_of_photos_of_nobody_before_it_trains(run, data, tmp_path, monkeypatch):
    monkeypatch.setattr(dataset_effect, "trained", lambda *_, **__: pytest.fail("trained in vain"))
    Image.new("RGB", (64, 64), "grey").save(tmp_path / "wall.png")
    words = ["dataset", "effect", "--shards", data / "heads", "--lights", data / "lights.npz", "-o", data / "s.jpg"]
    words += ["--size", 32]
    refused(run(*words, "--bare", data / "heads", "--photos", tmp_path / "wall.png"), "wall.png: no face")
    Image.new("RGB", (64, 64), "grey").save(tmp_path / "door.png")
    refused(run(*words, "--bare", data / "heads", "--photos", tmp_path), f"{tmp_path}: no face")


def test_effect_keeps_its_photos_and_what_is_no_folder(run, data, tmp_path, monkeypatch):
    monkeypatch.setattr(dataset_effect, "trained", lambda *_, **__: pytest.fail("trained in vain"))
    photo = tmp_path / "a.png"
    Image.new("RGB", (8, 8)).save(photo)
    words = ["dataset", "effect", "--shards", data / "heads", "--lights", data / "lights.npz"]
    words += ["--bare", data / "heads", "--photos", tmp_path, "--size", 32]
    refused(run(*words, "-o", photo), "a.png", "input")
    refused(run(*words, "-o", tmp_path / "s.png", "--work", photo), "a.png")


def test_effect_shows_a_dash_for_what_no_photo_tells(run, data, tmp_path, monkeypatch):
    figures = dataset_effect.DatasetFigures(detail=0.5, spread=0.25, light_left=np.nan)
    found = dataset_effect.Comparison({"plain": figures}, [("photo", np.zeros((32, 32, 3), np.float32))], 1)
    monkeypatch.setattr(dataset_effect, "trained", lambda *_, **__: None)
    monkeypatch.setattr(dataset_effect, "photos_of_people", lambda paths: paths)
    monkeypatch.setattr(dataset_effect, "compare_photos", lambda *_: found)
    cv2.imwrite(str(tmp_path / "one.png"), np.zeros((8, 8, 3), np.uint8))
    words = ["dataset", "effect", "--shards", data / "heads", "--bare", data / "heads", "--lights", data / "lights.npz"]
    code, out, _ = run(*words, "--photos", tmp_path, "--size", 32, "-o", data / "s.png")
    assert code == 0
    assert "| plain | 0.500 | 0.250 | – | 1 |" in out
