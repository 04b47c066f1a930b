"""relight channels and relight turntable."""

import json
import sys

import av
import numpy as np
import OpenEXR
import pytest
from PIL import Image

from app.cli.channels import write_channels
from app.cli.report import counting, effect_record
from app.cli.turntable import _around, _fine_enough, _on_canvas
from relight_core.face.find import FaceBox
from relight_core.imaging import contact_sheet
from relight_core.imaging.contact_sheet import on_ground
from relight_core.imaging.files import KnownFiles
from relight_core.imaging.formats.exr import read_exr
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_photo.person import Canvas
from relight_core.pipeline.plan import Effect
from relight_core.pipeline.results import layers
from relight_core.pipeline.results.relit import Relit

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
    done = relight("channels", photo, "--light", "ring", "--yaw", 15, "--json", "-o", folder)
    assert done.code == 0
    pictures = [f"{name}.png" for name in CHANNELS]
    exrs = ["channels.exr", "source_light.exr", "target_light.exr"]
    assert sorted(path.name for path in folder.iterdir()) == sorted(pictures + exrs)
    assert json.loads(done.out)["files"] == sorted(str(folder / name) for name in pictures + exrs)
    for name in pictures:
        assert Image.open(folder / name).mode == "RGB"
    # sRGB 137 of 255 is a quarter of white's light; what faces the camera is light blue.
    assert np.abs(np.asarray(Image.open(folder / "albedo.png"), int) - 137).max() <= 1
    assert np.abs(np.asarray(Image.open(folder / "normal.png"), int) - (128, 128, 255)).max() <= 1
    file = OpenEXR.File(str(folder / "channels.exr"))
    layers = file.channels()
    assert file.header()["relightYawDeg"] == 15.0
    assert {"RGB", "albedo", "normal", "specular", "shadow", "parsing"} <= set(layers)
    assert np.all(layers["RGB"].pixels == 0.25)
    assert np.all(layers["parsing"].pixels == 1.0)
    assert np.all(layers["normal"].pixels == [0.0, 0.0, 1.0])


def test_of_several_faces_the_channels_of_all_are_written_beside_those_of_one(
    relight, relighter, photo, tmp_path, monkeypatch
):
    grey = np.full((6, 9, 3), 0.5, np.float32)
    monkeypatch.setattr(layers, "photo_layers", lambda relit, names: {"RGB": grey} | dict.fromkeys(names, grey))
    said, written = [], []
    for relighter.face_count in (1, 2):
        folder = tmp_path / str(relighter.face_count)
        said.append(relight("channels", photo, "--light", "ring", "-o", folder).out)
        written.append({path.name for path in folder.iterdir()})
    assert written[1] - written[0] == {"layers.exr"}
    assert "all 2 faces" in said[1]
    assert "--face N" in said[1]
    assert "--face" not in said[0]
    channels = OpenEXR.File(str(folder / "layers.exr")).channels()
    assert {"RGB", *layers.LAYERS} <= set(channels)
    assert channels["albedo"].pixels.shape[:2] == (6, 9)


def test_a_light_s_file_holds_more_than_halves_can(tmp_path):
    light = np.full((16, 32, 3), 3000.0, np.float32)
    light[4, 12] = 2e6
    channels = {"photo": np.zeros((8, 8, 3), np.float32), "source_light": light, "target_light": light}
    relit = Relit(None, None, channels, [])
    write_channels(relit, Edit(), tmp_path, KnownFiles([]))
    for name in ("source_light", "target_light"):
        np.testing.assert_array_equal(read_exr(tmp_path / f"{name}.exr")[0], light)


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


def test_the_turntable_s_labels_go_round_with_the_light(relight, photo, tmp_path, monkeypatch):
    labels, draw = [], contact_sheet.contact_sheet
    monkeypatch.setattr(
        contact_sheet, "contact_sheet", lambda pictures, *sizes: labels.extend(pictures) or draw(pictures, *sizes)
    )
    assert relight("turntable", photo, "--light", "ring", "--yaw", 285, "-o", tmp_path / "sheet.png").code == 0
    degrees = (285, 315, 345, 15, 45, 75, 105, 135, 165, 195, 225, 255)
    assert [label for label, _ in labels] == [f"yaw {angle}°" for angle in degrees]


def test_a_turntable_s_film_goes_round_once_frame_by_frame(relight, relighter, photo, tmp_path):
    film = tmp_path / "turn.MP4"
    done = relight("turntable", photo, "--light", "ring", "--yaw", 15, "--json", "-o", film)
    assert done.code == 0
    yaws_deg = [edit.yaw_deg for edit in relighter.edits]
    assert yaws_deg[:120] == pytest.approx([15 + 3 * frame for frame in range(120)])
    with av.open(str(film)) as opened:
        assert opened.streams.video[0].frames == 120
    record = json.loads(done.out)
    assert (record["output"], record["size"]) == (str(film), list(Image.open(photo).size))


def test_a_film_that_is_interrupted_leaves_nothing(relight, relighter, photo, tmp_path, monkeypatch):
    def interrupted(*asked, **named):
        raise KeyboardInterrupt

    monkeypatch.setattr(relighter, "relight", interrupted)
    assert relight("turntable", photo, "--light", "ring", "-o", tmp_path / "turn.mp4").code == 130
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [photo.suffix]


@pytest.mark.parametrize(("command", "output"), [("channels", "all"), ("turntable", "sheet.png")])
def test_the_whole_picture_is_not_made_for_files_that_have_none_of_it(
    relight, relighter, photo, tmp_path, command, output
):
    assert relight(command, photo, "--light", "ring", "-o", tmp_path / output).code == 0
    assert set(relighter.longest_sides_px) == {0}


@pytest.mark.parametrize(("share", "is_ground"), [(0.0, True), (1.0, False)])
def test_the_sheet_s_ground_is_where_the_background_was_taken_away(
    relight, relighter, photo, tmp_path, share, is_ground
):
    relighter.share, sheet = share, tmp_path / "sheet.png"
    words = ("turntable", photo, "--light", "ring", "--background", "transparent", "--exposure", 3, "-o", sheet)
    assert relight(*words).code == 0
    first_cell = np.asarray(Image.open(sheet))[8:328, 8:328]
    assert (first_cell == (24, 24, 26)).all() == is_ground


def test_the_sheet_is_as_bright_as_was_asked_for(relight, photo, tmp_path):
    means = []
    for stops in (-3, 0):
        sheet = tmp_path / f"sheet{stops}.png"
        assert relight("turntable", photo, "--light", "ring", f"--exposure={stops}", "-o", sheet).code == 0
        means.append(np.asarray(Image.open(sheet))[8:328, 8:328].max(axis=2).mean())
    assert means[0] < 0.7 * means[1]


def test_the_sheet_shows_what_lies_around_the_face_as_far_as_the_photo_goes():
    box = FaceBox(300.0, 100.0, 400.0, 220.0)
    assert _around(box, (1000, 2000)) == (218, 28, 482, 292)
    assert _around(box, (200, 450)) == (218, 28, 450, 200)
    assert _around(FaceBox(0.0, 0.0, 100.0, 100.0), (200, 450)) == (0, 0, 160, 160)


@pytest.mark.parametrize(
    ("size", "window", "expected"),
    [
        ((250, 400), (218, 28, 482, 292), (44, 7, 96, 73)),
        ((2, 3), (0, 0, 10, 10), (0, 0, 1, 1)),
        ((2, 3), (1990, 990, 2000, 1000), (2, 1, 3, 2)),
    ],
)
def test_a_window_is_at_its_place_of_a_smaller_copy_which_has_a_pixel_of_it(size, window, expected):
    assert _on_canvas(window, Canvas(np.zeros((*size, 3), np.float32), None, (1000, 2000))) == expected


def test_half_of_a_picture_before_the_ground_is_half_of_its_light():
    white, half = np.ones((1, 1, 3), np.float32), np.full((1, 1), 0.5)
    # sRGB 24 and 26 of 255 are 0.0091 and 0.0103 of white's light; half of both is 0.505 and encodes to 0.739.
    assert on_ground(white, half) == pytest.approx(0.739, abs=2e-3)


def test_hidden_colours_of_a_cut_out_stay_hidden_on_the_sheet():
    linear, alpha = np.full((900, 900, 3), 0.25, np.float32), np.ones((900, 900), np.float32)
    linear[:, 451:], alpha[:, 451:] = (1.0, 0.0, 1.0), 0.0
    small = _fine_enough(Canvas(linear, alpha, (900, 900)), (0, 0, 900, 900))
    assert small.size == (640, 640)
    edge = (small.alpha > 0.0) & (small.alpha < 1.0)
    assert edge.any()
    assert np.allclose(small.linear[small.alpha > 0.01], 0.25, atol=1e-3)


@pytest.mark.parametrize(
    "words",
    [
        ("--exposure", "2"),
        ("--background", "light"),
        ("--background-fov", "40"),
        ("--background-blur", "3"),
        ("--force", "channels=off"),
    ],
)
def test_what_would_change_no_channel_or_leave_none_is_refused(relight, photo, tmp_path, words):
    done = relight("channels", photo, "--light", "ring", *words, "-o", tmp_path / "all")
    assert done.code == 2
    assert done.err.count("\n") == 1
    assert words[0] in done.err
    assert not (tmp_path / "all").exists()


@pytest.mark.parametrize(("bound", "saved_ms"), [(None, None), (0.0, 0.0)])
def test_what_no_rule_answers_for_is_null_to_programs_and_what_errs_by_nothing_is_0(bound, saved_ms):
    record = effect_record(Effect("relief", "skipped", "no need", bound, saved_ms=saved_ms))
    assert (record["bound"], record["saved_ms"]) == (bound, saved_ms)


def test_how_far_a_film_is_is_told_to_people_only(capsys, monkeypatch):
    with counting("relighting") as step:
        step(1, 2)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    with counting("relighting") as step:
        step(1, 2)
        assert capsys.readouterr().err.endswith("relighting 1 of 2")
    assert "\x1b[K" in capsys.readouterr().err
