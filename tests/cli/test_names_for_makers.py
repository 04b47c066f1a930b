"""relight dataset, train, evaluate, bench and measure: files are named as for the commands that relight photos."""

import os

import cv2
import numpy as np
import pytest
from PIL import Image
from refusals import refused

from app.cli import bench

BAKE = ["dataset", "bake", "--heads", "h.npz", "--wardrobe", "w", "--out", "heads", "--count", "1"]
SKINS = ["dataset", "skins", "--heads", "h.npz", "--wardrobe", "w", "--out", "heads"]
CHECK = ["dataset", "check", "--heads", "h.npz", "--wardrobe", "w", "--lights", "l.npz"]
PREVIEW = ["dataset", "preview", "--shards", "heads", "--lights", "l.npz", "-o", "sheet.png"]
EFFECT = ["dataset", "effect", "--shards", "heads", "--lights", "l.npz", "--bare", "bare", "--photos", "photos"]
TRAIN = [
    "train",
    "--recipe",
    "paper",
    "--heads",
    "heads",
    "--lights",
    "l.npz",
    "--start",
    "s",
    "--places",
    "p",
    "-o",
    "o",
]
EVALUATE = [
    "evaluate",
    "peers",
    "--heads",
    "h",
    "--lights",
    "l",
    "--weights",
    "w",
    "--sun",
    "s",
    "--dpr",
    "d",
    "-o",
    "o",
]
BENCH = ["bench", "--photos", "photos", "--heads", "heads", "--lights", "l.npz", "--weights", "w", "-o", "out"]


def every_name_left_empty():
    """Each command, once for each of its names, without that name, as a script's variable that is not set leaves it."""
    for words in (
        BAKE,
        SKINS,
        ["dataset", "lights", "-o", "l.npz", "folder"],
        CHECK,
        PREVIEW,
        [*EFFECT, "--work", "kept", "-o", "sheet.png"],
        TRAIN,
        ["train", "--join", "other", "--start", "w", "-o", "both"],
        EVALUATE,
        BENCH,
        ["measure", "photo.png", "-o", "speed.json"],
    ):
        for place, option in enumerate(words):
            if option.startswith("-") and option not in ("--count", "--recipe"):
                name = f"{words[0]} {words[1]} {option}"
                yield pytest.param([*words[: place + 1], "", *words[place + 2 :]], id=name)
    yield pytest.param(["dataset", "lights", "-o", "l.npz", ""], id="dataset lights folder")


@pytest.mark.parametrize("words", [*every_name_left_empty()])
def test_a_name_left_empty_is_not_the_current_folder(run, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    refused(run(*words), "an empty name")
    assert os.listdir() == []


def test_the_home_folder_s_sign_counts_where_no_shell_has_seen_it(run, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    (tmp_path / "panoramas").mkdir()
    cv2.imwrite(str(tmp_path / "panoramas" / "yard.hdr"), np.ones((8, 16, 3), np.float32))
    assert run("dataset", "lights", "~/panoramas", "--output=~/l.npz").code == 0
    assert (tmp_path / "l.npz").is_file()


def test_photos_to_measure_are_those_of_a_folder_that_is_relit(relight, tmp_path, monkeypatch):
    """A Mac leaves a hidden file beside each photo that it copies, under the photo's name and of no picture."""
    photos = tmp_path / "photos"
    (photos / "album.jpg").mkdir(parents=True)
    for name in ("me.bmp", "you.jpg", "you-relit.jpg"):
        Image.new("RGB", (4, 4)).save(photos / name)
    (photos / "._you.jpg").write_bytes(b"Mac OS X")
    measured = []
    monkeypatch.setattr(bench, "_session", lambda _, photos, __: measured.extend(photos) or 0)
    assert relight("bench", "--session", "--photos", photos, "-o", tmp_path / "out").code == 0
    assert [photo.path.name for photo in measured] == ["me.bmp", "you.jpg"]
