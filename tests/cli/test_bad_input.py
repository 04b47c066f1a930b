"""Bad input: one clear line on stderr, exit code 2, nothing written, inputs as they were."""

import io
import os

import numpy as np
import pytest
from PIL import Image

from app.document.document import Document, LightRef, PhotoRef
from app.document.light_file import SavedLight, write_light
from app.document.session_file import write_session
from relight_core.imaging.write import write_image


def _jpeg():
    pixels = np.random.default_rng(2).integers(0, 255, (64, 64, 3), dtype=np.uint8)
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, "JPEG")
    return buffer.getvalue()


BAD_PHOTOS = {
    "missing.jpg": None,
    "empty.jpg": b"",
    "truncated.jpg": _jpeg()[:700],
    "headless.png": _jpeg()[300:],
    "text.jpg": b"This is not a photo, whatever its name says.\n" * 20,
}


def refused(done, *names):
    """One line, naming what is at fault; no traceback, nothing on stdout."""
    assert done.code == 2
    assert done.err.count("\n") == 1
    assert done.err.startswith("relight")
    assert "Traceback" not in done.err
    assert done.out == ""
    for name in names:
        assert name in done.err
    return True


@pytest.mark.parametrize("name", BAD_PHOTOS)
@pytest.mark.parametrize("as_json", [[], ["--json"]])
def test_a_file_that_is_no_photo(relight, tmp_path, name, as_json):
    path, out = tmp_path / name, tmp_path / "out.png"
    if BAD_PHOTOS[name] is not None:
        path.write_bytes(BAD_PHOTOS[name])
    assert refused(relight("render", path, "--light", "ring", *as_json, "-o", out), name)
    assert not out.exists()


def test_a_session_in_the_photos_place_is_told_where_it_belongs(relight, tmp_path):
    session = tmp_path / "me.relight.json"
    session.write_text("{}")
    done = relight("render", session, "--light", "ring", "-o", tmp_path / "out.png")
    assert refused(done, "me.relight.json: no photo; name the photo itself, and a session or light after --light")


@pytest.mark.parametrize("command", ["render", "channels", "turntable"])
def test_a_folder_is_no_photo(relight, tmp_path, command):
    (tmp_path / "album").mkdir()
    out = tmp_path / "out.png"
    assert refused(relight(command, tmp_path / "album", "--light", "ring", "-o", out), "album")
    assert not out.exists()


@pytest.mark.parametrize("command", [["render"], ["channels"], ["turntable"], []])
def test_an_empty_name_is_not_the_current_folder(relight, photo, monkeypatch, command):
    """A script whose variable is not set would else relight whatever lies where it runs."""
    monkeypatch.chdir(photo.parent)
    rest = ["--light", "ring", *(["-o", "out/"] if command else [])]
    assert refused(relight(*command, "", *rest), "an empty name")
    assert os.listdir() == ["photo.png"]


@pytest.mark.parametrize("option", ["--light", "-o"])
def test_an_empty_light_or_output_is_told_as_what_it_is(relight, photo, tmp_path, option):
    options = {"--light": "ring", "-o": str(tmp_path / "out.png")} | {option: ""}
    words = [word for pair in options.items() for word in pair]
    assert refused(relight("render", photo, *words), option, "an empty name")


@pytest.mark.parametrize("command", ["render", "channels", "turntable"])
def test_a_photo_without_a_face(relight, tmp_path, command):
    blank, out = tmp_path / "blank.png", tmp_path / "out.png"
    Image.new("RGB", (32, 32), (90, 90, 90)).save(blank)
    done = relight(command, blank, "--light", "ring", "--json", "-o", out)
    assert done.code == 2
    assert done.out == ""
    assert "blank.png: no face" in done.err
    assert not out.exists()


def test_a_light_of_the_wrong_shape(relight, photo, tmp_path):
    square = tmp_path / "square.exr"
    write_image(square, np.ones((8, 8, 3), np.float32))
    assert refused(relight("render", photo, "--light", square, "-o", tmp_path / "out.png"), "square.exr")
    assert not (tmp_path / "out.png").exists()


@pytest.mark.parametrize("name", ["broken.exr", "broken.hdr", "broken.jpg"])
def test_a_light_that_is_no_picture(relight, photo, tmp_path, name):
    (tmp_path / name).write_bytes(b"nothing of use")
    assert refused(relight("render", photo, "--light", tmp_path / name, "-o", tmp_path / "out.png"), name)


def test_an_unknown_light_tells_which_there_are(relight, photo, tmp_path):
    done = relight("render", photo, "--light", "Rembrant", "-o", tmp_path / "out.png")
    assert refused(done, "Rembrant", "mean rembrandt", "golden-hour", "ring", "soft-window")


@pytest.mark.parametrize("option", ["--yaw", "--exposure", "--specular", "--shadow"])
@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "1e999", "much", ""])
def test_numbers_that_are_none(relight, photo, tmp_path, option, value):
    done = relight("render", photo, "--light", "ring", f"{option}={value}", "-o", tmp_path / "out.png")
    assert refused(done, option)


@pytest.mark.parametrize(
    "words",
    [
        ("--specular", "2.01"),
        ("--shadow", "-0.1"),
        ("--specular-tint", "1.1"),
        ("--shadow-softness", "-0.1"),
        ("--strength", "1.1"),
        ("--exposure", "17"),
        ("--background", "#12345"),
        ("--background", "beige"),
        ("--face", "-1"),
        ("--quality", "best"),
        ("--bits", "12"),
        ("--yaww", "3"),
    ],
)
def test_settings_out_of_range(relight, photo, tmp_path, words):
    assert refused(relight("render", photo, "--light", "ring", *words, "-o", tmp_path / "out.png"), words[0])
    assert not (tmp_path / "out.png").exists()


@pytest.mark.parametrize("name", ["out.gif", "out", "out.png.part"])
def test_an_output_of_unknown_kind(relight, photo, tmp_path, name):
    assert refused(relight("render", photo, "--light", "ring", "-o", tmp_path / name), name)


def test_a_name_without_an_end_is_told_as_what_it_is(relight, photo, tmp_path):
    done = relight("render", photo, "--light", "ring", "-o", tmp_path / "out")
    assert refused(done, "out: the end of the name doesn't say which kind of file; name a .png")


def test_a_turntable_names_its_film_beside_its_pictures(relight, photo, tmp_path):
    done = relight("turntable", photo, "--light", "ring", "-o", tmp_path / "turn.avi")
    assert refused(done, "can't write '.avi' files; name a .png, .jpg, .tif or .exr file, or an .mp4 for a film")


def test_transparency_in_a_jpeg(relight, photo, tmp_path):
    words = ("--background", "transparent", "-o", tmp_path / "out.jpg")
    assert refused(relight("render", photo, "--light", "ring", *words), "out.jpg")


@pytest.mark.parametrize("command", ["render", "turntable"])
def test_an_output_in_a_missing_folder(relight, relighter, photo, tmp_path, command):
    out = tmp_path / "nowhere" / "out.png"
    assert refused(relight(command, photo, "--light", "ring", "-o", out), "nowhere")
    assert relighter.edits == []


@pytest.mark.parametrize("command", ["render", "channels", "turntable"])
def test_an_output_below_a_file(relight, relighter, photo, tmp_path, command):
    (tmp_path / "note").write_text("kept")
    out = f"{tmp_path}/note/out.png" + ("/" if command == "render" else "")
    assert refused(relight(command, photo, "--light", "ring", "-o", out), "note")
    assert (tmp_path / "note").read_text() == "kept"
    assert relighter.edits == []


def test_an_output_that_is_no_regular_file(relight, photo, tmp_path):
    os.mkfifo(tmp_path / "pipe.png")
    assert refused(relight("render", photo, "--light", "ring", "-o", tmp_path / "pipe.png"), "pipe.png")


@pytest.mark.parametrize("alias", ["same", "detour", "symlink", "hardlink", "dangling detour"])
@pytest.mark.parametrize("command", ["render", "turntable"])
def test_an_output_that_is_the_input(relight, photo, tmp_path, alias, command):
    before = photo.read_bytes()
    out = tmp_path / "alias.png"
    if alias == "same":
        out = photo
    elif alias == "detour":
        (tmp_path / "folder").mkdir()
        out = tmp_path / "folder" / ".." / "photo.png"
    elif alias == "symlink":
        out.symlink_to(photo)
    elif alias == "hardlink":
        os.link(photo, out)
    else:
        (tmp_path / "here").symlink_to(tmp_path)
        out = tmp_path / "here" / "photo.png"
    assert refused(relight(command, photo, "--light", "ring", "-o", out), "input")
    assert photo.read_bytes() == before


def test_an_output_that_is_the_light_or_another_photo(relight, photo, another_photo, tmp_path):
    before = another_photo.read_bytes()
    assert refused(relight("render", photo, "--light", another_photo, "-o", another_photo), "another.png")
    assert refused(relight("render", photo, another_photo, "--light", "ring", "-o", tmp_path), "photo.png")
    assert another_photo.read_bytes() == before


@pytest.mark.parametrize("kind", ["light", "session"])
@pytest.mark.parametrize("command", ["render", "turntable"])
def test_an_output_that_is_the_picture_a_saved_light_names(relight, photo, another_photo, tmp_path, command, kind):
    saved, before = tmp_path / f"mine.{kind}.json", another_photo.read_bytes()
    light = LightRef("portrait", str(another_photo))
    if kind == "light":
        write_light(saved, SavedLight(light))
    else:
        write_session(saved, Document(PhotoRef(photo), light))
    assert refused(relight(command, photo, "--light", saved, "-o", another_photo), "another.png", "input")
    assert another_photo.read_bytes() == before


def test_a_channel_that_would_replace_the_input(relight, tmp_path):
    album = tmp_path / "album"
    album.mkdir()
    pixels = np.random.default_rng(3).integers(0, 255, (16, 24, 3), dtype=np.uint8)
    Image.fromarray(pixels).save(album / "albedo.png")
    before = (album / "albedo.png").read_bytes()
    done = relight("channels", album / "albedo.png", "--light", "ring", "-o", album)
    assert refused(done, "albedo.png")
    assert [path.name for path in album.iterdir()] == ["albedo.png"]
    assert (album / "albedo.png").read_bytes() == before


def test_a_channel_that_would_replace_the_light(relight, photo, tmp_path):
    light = tmp_path / "all" / "target_light.exr"
    light.parent.mkdir()
    write_image(light, np.full((8, 16, 3), 2.0, np.float32))
    before = light.read_bytes()
    assert refused(relight("channels", photo, "--light", light, "-o", light.parent), "target_light.exr", "input")
    assert [path.name for path in light.parent.iterdir()] == ["target_light.exr"]
    assert light.read_bytes() == before


def test_a_mistyped_command_or_photo(relight, tmp_path):
    assert refused(relight("rendr"), "rendr", "relight render")
    assert refused(relight(tmp_path / "nobody.jpg"), "nobody.jpg")
    assert refused(relight("render"), "PHOTO")
    assert refused(relight("rigs", "extra"), "extra")


@pytest.mark.parametrize("command", ["render", "channels", "turntable"])
def test_names_that_are_too_long_for_any_file(relight, photo, tmp_path, command):
    long = tmp_path / f"{'x' * 300}.png"
    assert refused(relight(command, long, "--light", "ring", "-o", tmp_path / "out.png"), "too long")
    if command != "channels":
        assert relight(command, photo, "--light", "ring", "-o", long).code == 2
    assert relight(command, photo, "--light", "ring", "-o", f"{tmp_path}/{'x' * 300}/").code == 2


def test_odd_file_names_stay_on_one_line(relight, tmp_path):
    assert refused(relight("render", tmp_path / "two\nlines.jpg", "--light", "ring", "-o", tmp_path / "out.png"))
    assert refused(relight("render", tmp_path / "\udcff.jpg", "--light", "ring", "-o", tmp_path / "out.png"))
