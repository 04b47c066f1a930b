"""relight channels and relight turntable."""

import json

import numpy as np
import OpenEXR
import pytest
from PIL import Image

CHANNELS = [
    "albedo",
    "composition",
    "normal",
    "parsing",
    "photo",
    "shadow",
    "source_light",
    "specular",
    "target_light",
]


def test_every_channel_is_a_picture_and_a_layer(relight, photo, tmp_path):
    folder = tmp_path / "new" / "channels"
    done = relight("channels", photo, "--light", "ring", "--json", "-o", folder)
    assert done.code == 0
    pictures = [f"{name}.png" for name in CHANNELS]
    exrs = ["channels.exr", "source_light.exr", "target_light.exr"]
    assert sorted(path.name for path in folder.iterdir()) == sorted(pictures + exrs)
    assert json.loads(done.out)["files"] == sorted(str(folder / name) for name in pictures + exrs)
    for name in pictures:
        assert Image.open(folder / name).mode == "RGB"
    layers = OpenEXR.File(str(folder / "channels.exr")).channels()
    assert {"RGB", "albedo", "normal", "specular", "shadow", "parsing"} <= set(layers)
    assert np.all(layers["RGB"].pixels == 0.25)
    assert np.all(layers["parsing"].pixels == 1.0)
    assert np.all(layers["normal"].pixels == [0.0, 0.0, 1.0])


def test_other_files_in_the_folder_stay(relight, photo, tmp_path):
    folder = tmp_path / "channels"
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    assert relight("channels", photo, "--light", "ring", "-o", folder).code == 0
    assert (folder / "notes.txt").read_text() == "mine"
    assert (folder / "albedo.png").is_file()


def test_the_turntable_goes_round_once(relight, relighter, photo, tmp_path):
    sheet = tmp_path / "sheet.png"
    assert relight("turntable", photo, "--light", "ring", "--yaw", 15, "-o", sheet).code == 0
    assert [edit.yaw_deg for edit in relighter.edits] == pytest.approx([15 + 30 * step for step in range(12)])
    width, height = Image.open(sheet).size
    assert width > height > 600
