"""relight without a subcommand: the editor, or files where nothing can be shown."""

import sys
from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest
from PIL import Image

from app.cli import edit
from app.document.document import Document, LightRef, PhotoRef
from app.document.light_file import SavedLight, write_light
from app.document.session_file import write_session
from relight_core.face.find import FaceBox
from relight_core.imaging.write import write_image
from relight_core.lighting.light_edit import LightEdit, edit_light
from relight_core.lighting.rigs import load_rig
from relight_core.lighting.soft_box import SoftBox
from relight_core.pipeline.edit import Edit

EDIT = Edit(yaw_deg=30.0, shadow=0.5)
CHANGED = LightEdit(warmth=0.5, base=0.5, boxes=(SoftBox(azimuth_deg=40.0),))


@pytest.fixture
def opened(monkeypatch):
    """What the editor was opened with."""
    calls = []
    window = ModuleType("app.window.run")
    for name in ("NoDisplayError", "GraphicsLostError"):
        setattr(window, name, type(name, (RuntimeError,), {}))
    window.run_editor = lambda photos, light: calls.append((photos, light)) or 0
    monkeypatch.setitem(sys.modules, "app.window.run", window)
    return calls


def test_without_a_display_pictures_are_written(relight, relighter, photo, tmp_path, monkeypatch):
    monkeypatch.setattr(edit, "has_display", lambda: False)
    monkeypatch.chdir(tmp_path)
    done = relight(photo)
    assert done.code == 0
    assert "no display" in done.out
    for name in (
        "relit-rembrandt.png",
        "relit-soft-window.png",
        "relit-golden-hour.png",
        "channels/albedo.png",
    ):
        assert Image.open(tmp_path / "out" / name).size
        assert name.partition("/")[0] in done.out
    assert Image.open(tmp_path / "out" / "turntable.png").width > 1000
    assert np.array_equal(relighter.lights[-1].shape, load_rig("hard-side").shape)


def test_without_a_display_a_panorama_is_metered_as_in_the_window(relight, relighter, photo, tmp_path, monkeypatch):
    monkeypatch.setattr(edit, "has_display", lambda: False)
    monkeypatch.chdir(tmp_path)
    write_image(tmp_path / "sky.exr", np.full((8, 16, 3), 6.0, np.float32))
    assert relight(photo, "--light", "sky.exr").code == 0
    assert [light.level for light in relighter.lights] == pytest.approx([1.5] * len(relighter.lights))


def test_without_a_display_the_sample_portrait_is_used(relight, relighter, tmp_path, monkeypatch):
    monkeypatch.setattr(edit, "has_display", lambda: False)
    monkeypatch.chdir(tmp_path)
    assert relight("--light", "split").code == 0
    assert Image.open(tmp_path / "out" / "relit-split.png").size == (512, 512)


@pytest.mark.parametrize("name", ["relit-ring.png", "channels/albedo.png", "turntable.png"])
def test_without_a_display_no_picture_is_written_over_the_photo(relight, photo, tmp_path, monkeypatch, name):
    monkeypatch.setattr(edit, "has_display", lambda: False)
    monkeypatch.chdir(tmp_path)
    place = tmp_path / "out" / name
    place.parent.mkdir(parents=True)
    photo.rename(place)
    before = place.read_bytes()
    done = relight(place, "--light", "ring")
    assert (done.code, place.read_bytes()) == (2, before)
    assert "that is the input" in done.err


@pytest.mark.parametrize("kind", ["light", "photo of a session"])
def test_without_a_display_nothing_else_that_is_read_is_written_over(
    relight, photo, another_photo, tmp_path, monkeypatch, kind
):
    monkeypatch.setattr(edit, "has_display", lambda: False)
    monkeypatch.chdir(tmp_path)
    place = tmp_path / "out" / "turntable.png"
    place.parent.mkdir()
    before = another_photo.rename(place).read_bytes()
    write_session(tmp_path / "me.relight.json", Document(PhotoRef(place), LightRef("rig", "ring")))
    done = relight(photo, "--light", place) if kind == "light" else relight("me.relight.json")
    assert (done.code, place.read_bytes()) == (2, before)
    assert "that is the input" in done.err


def test_without_a_display_a_bad_photo_is_still_bad_input(relight, tmp_path, monkeypatch):
    monkeypatch.setattr(edit, "has_display", lambda: False)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text.jpg").write_text("no photo")
    done = relight("text.jpg")
    assert done.code == 2
    assert done.err.count("\n") == 1


@pytest.mark.parametrize(("words", "name"), [([], "relit-me.relight.png"), (["--light", "split"], "relit-split.png")])
def test_without_a_display_a_session_is_relit_as_it_was_saved(
    relight, relighter, photo, tmp_path, monkeypatch, words, name
):
    monkeypatch.setattr(edit, "has_display", lambda: False)
    monkeypatch.chdir(tmp_path)
    boxes = (FaceBox(1.0, 2.0, 9.0, 10.0), FaceBox(12.0, 2.0, 20.0, 10.0))
    made = Edit(yaw_deg=30.0, shadow=0.5, exposure_ev=1.0)
    work = Document(PhotoRef(photo, 1, boxes), LightRef("rig", "ring"), edit=made)
    write_session(tmp_path / "me.relight.json", work)
    assert relight("me.relight.json", *words).code == 0
    # Half the light, and a stop more of exposure.
    np.testing.assert_allclose(Image.open(tmp_path / "out" / name), Image.open(photo), atol=1)
    assert (relighter.boxes, relighter.face_index) == (boxes, 1)
    assert (relighter.edits[0].shadow, relighter.edits[0].yaw_deg) == (0.5, 30.0)


@pytest.mark.parametrize("light", ["ring", "own"])
def test_without_a_display_the_face_that_was_chosen_in_a_photo_before_it_was_cropped_is_not_another_s(
    relight, relighter, photo, tmp_path, monkeypatch, light
):
    monkeypatch.setattr(edit, "has_display", lambda: False)
    monkeypatch.chdir(tmp_path)
    boxes = (FaceBox(1.0, 2.0, 9.0, 10.0), FaceBox(12.0, 2.0, 20.0, 10.0))
    ref = LightRef("own") if light == "own" else LightRef("rig", light)
    write_session(tmp_path / "me.relight.json", Document(PhotoRef(photo, 1, boxes, size=(300, 10)), ref))
    done = relight("me.relight.json")
    assert (done.code, relighter.boxes, relighter.face_index) == (0, None, None)
    assert done.err.count("left out: boxes of faces, the choice of one face") == 1


@pytest.fixture
def saved(photo, tmp_path, monkeypatch):
    """Saves work on the photo as me.relight.json, where there is no display."""
    monkeypatch.setattr(edit, "has_display", lambda: False)
    monkeypatch.chdir(tmp_path)

    def save(light, changed=CHANGED, quality="auto"):
        write_session(tmp_path / "me.relight.json", Document(PhotoRef(photo), light, changed, EDIT, quality))

    return save


def test_without_a_display_a_session_is_shown_under_its_original_light(relight, relighter, saved):
    saved(LightRef("own"), LightEdit(level_ev=2.0))
    assert relight("me.relight.json").code == 0
    assert relighter.lights[0].level == pytest.approx(4 * relighter.estimated_light("final").level)
    assert relighter.edits[0].shadow == EDIT.shadow


@pytest.mark.parametrize(("light", "changed"), [("ring", CHANGED), ("split", replace(CHANGED, warmth=0.0))])
def test_without_a_display_soft_boxes_and_room_stay_under_another_light(relight, relighter, saved, light, changed):
    saved(LightRef("rig", "ring"))
    assert relight("me.relight.json", "--light", light).code == 0
    assert np.array_equal(relighter.lights[0].shape, edit_light(load_rig(light), changed).shape)
    assert relighter.edits[0].yaw_deg == EDIT.yaw_deg


@pytest.mark.parametrize("name", ["photo.png", "me.relight.json"])
def test_without_a_display_a_saved_light_is_turned_as_it_was_and_a_session_s_own_turn_goes(
    relight, relighter, saved, tmp_path, name
):
    saved(LightRef("rig", "ring"))
    write_light(tmp_path / "mine.light.json", SavedLight(LightRef("rig", "split"), LightEdit(), 33.3))
    assert relight(name, "--light", "mine.light.json").code == 0
    assert relighter.edits[0].yaw_deg == pytest.approx(33.3)
    assert relighter.edits[0].shadow == (0.5 if name == "me.relight.json" else 1.0)


def test_without_a_display_a_person_of_a_session_is_cut_out_as_in_the_window(relight, photo, tmp_path, monkeypatch):
    monkeypatch.setattr(edit, "has_display", lambda: False)
    monkeypatch.chdir(tmp_path)
    cut_out = Document(PhotoRef(photo), LightRef("rig", "ring"), edit=Edit(background="transparent"))
    write_session(tmp_path / "me.relight.json", cut_out)
    assert relight("me.relight.json").code == 0
    written = Image.open(tmp_path / "out" / "relit-me.relight.png")
    assert written.mode == "RGBA"
    assert written.getchannel("A").getextrema() == (128, 128)


@pytest.mark.parametrize(("chosen", "quality"), [("draft", "draft"), ("auto", "final")])
def test_without_a_display_a_session_is_relit_at_its_quality(relight, relighter, saved, chosen, quality):
    saved(LightRef("rig", "ring"), quality=chosen)
    assert relight("me.relight.json").code == 0
    assert {edit.quality for edit in relighter.edits} == {quality}


def test_without_a_display_what_a_session_was_mended_of_is_told(relight, saved, tmp_path):
    saved(LightRef("rig", "ring"))
    path = tmp_path / "me.relight.json"
    path.write_text(path.read_text().replace('"shadow": 0.5', '"shadow": 7'))
    assert "shadow 7" in relight("me.relight.json").err


@pytest.mark.parametrize("name", ["gone.relight.json", "mine.light.json"])
def test_without_a_display_what_is_no_session_is_told_in_a_line(relight, tmp_path, monkeypatch, name):
    monkeypatch.setattr(edit, "has_display", lambda: False)
    monkeypatch.chdir(tmp_path)
    write_light(tmp_path / "mine.light.json", SavedLight(LightRef("rig", "ring")))
    (tmp_path / "gone.relight.json").write_text('{"relight": "session", "version": 2, "photo": "gone.jpg"}')
    done = relight(name)
    assert done.code == 2
    assert done.err.count("\n") == 1
    assert name in done.err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("words", "light"), [([], None), (["--light", "ring"], "ring")])
def test_with_a_display_the_editor_opens(relight, opened, photo, monkeypatch, words, light):
    monkeypatch.setattr(edit, "has_display", lambda: True)
    assert relight(photo, *words).code == 0
    assert opened == [([photo], light)]


def test_several_photos_open_together_and_without_a_display_are_pointed_to_render(
    relight, opened, photo, tmp_path, monkeypatch
):
    monkeypatch.setattr(edit, "has_display", lambda: True)
    assert relight(photo, photo.parent, "--light", "ring").code == 0
    assert opened == [([photo, photo.parent], "ring")]
    monkeypatch.setattr(edit, "has_display", lambda: False)
    for several in ([photo, photo], [photo.parent]):
        done = relight(*several)
        assert (done.code, done.err.count("\n")) == (2, 1)
        assert "relight render" in done.err


def test_options_may_stand_between_photos(relight, opened, photo, tmp_path, monkeypatch):
    monkeypatch.setattr(edit, "has_display", lambda: True)
    (tmp_path / "-b.png").write_bytes(photo.read_bytes())
    monkeypatch.chdir(tmp_path)
    assert relight(photo, "--light", "rim", "./-b.png").code == 0
    assert relight("--light", "rim", "--", "-b.png", photo).code == 0
    between, behind = opened
    assert [path.name for path in between[0]] == [photo.name, "-b.png"]
    assert [path.name for path in behind[0]] == ["-b.png", photo.name]
    assert between[1] == behind[1] == "rim"


def test_a_tilde_that_no_shell_has_expanded_is_the_home_folder(relight, opened, photo, tmp_path, monkeypatch):
    monkeypatch.setattr(edit, "has_display", lambda: True)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    assert relight("~/photo.png").code == 0
    assert opened == [([photo], None)]
    assert relight("render", "~/photo.png", "--light", "ring", "-o", tmp_path / "out.png").code == 0


def test_a_display_that_fails_is_as_none(relight, opened, photo, tmp_path, monkeypatch):
    window = sys.modules["app.window.run"]

    def fail(_photos, _light):
        raise window.NoDisplayError("the display has no OpenGL")

    monkeypatch.setattr(window, "run_editor", fail)
    monkeypatch.setattr(edit, "has_display", lambda: True)
    monkeypatch.chdir(tmp_path)
    done = relight(photo, "--light", "ring")
    assert done.code == 0
    assert "the display has no OpenGL" in done.out
    assert (tmp_path / "out" / "relit-ring.png").is_file()


def test_graphics_that_are_lost_for_good_end_the_editor_with_one_line(relight, opened, photo, monkeypatch):
    window = sys.modules["app.window.run"]

    def fail(_photos, _light):
        raise window.GraphicsLostError("the graphics driver failed; unsaved work is kept")

    monkeypatch.setattr(window, "run_editor", fail)
    monkeypatch.setattr(edit, "has_display", lambda: True)
    done = relight(photo)
    assert done.code == 1
    assert done.err == "relight: the graphics driver failed; unsaved work is kept\n"


def test_an_unknown_light_is_told_before_anything_opens(relight, opened, photo, monkeypatch):
    monkeypatch.setattr(edit, "has_display", lambda: True)
    done = relight(photo, "--light", "rembrant")
    assert done.code == 2
    assert "rembrandt" in done.err
    assert opened == []


def test_the_editor_opens_on_the_sample_portrait(relight, opened, monkeypatch):
    monkeypatch.setattr(edit, "has_display", lambda: True)
    assert relight().code == 0
    (([photo], _light),) = opened
    assert Image.open(photo).size == (512, 512)


@pytest.mark.skipif(sys.platform in ("darwin", "win32"), reason="these always have a display")
@pytest.mark.parametrize(
    ("variables", "expected"),
    [
        ({}, False),
        ({"DISPLAY": ":0"}, True),
        ({"WAYLAND_DISPLAY": "wayland-0"}, True),
        ({"DISPLAY": ""}, False),
    ],
)
def test_displays_are_recognised(monkeypatch, variables, expected):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert edit.has_display() is expected
