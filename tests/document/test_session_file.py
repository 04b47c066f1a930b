"""Sessions and light files: what was saved comes back; what nobody should trust is refused or mended aloud."""

import json
import os
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from app.document.document import Document, LightRef, PhotoRef
from app.document.json_fields import is_place_for
from app.document.light_file import SavedLight, read_light, write_light
from app.document.session_file import (
    read_session,
    saved_session,
    session_path,
    write_session,
)
from relight_core.errors import InputError
from relight_core.face.find import FaceBox
from relight_core.lighting.light_edit import LightEdit
from relight_core.lighting.soft_box import SoftBox
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_photo.brush import BrushStroke

STROKES = (
    BrushStroke(((12.5, -3.0), (40.1, 99999.9)), 20.5, True),
    BrushStroke(((0.0, 0.1),), 0.1, False),
)
BOXES = (
    SoftBox(-60.0, 20.0, 44.0, 12.0, 0.1, 3200.0, None, 1.7),
    SoftBox(colour=(0.9, 0.1, 0.2)),
    SoftBox(form="disc", hole=0.6, off=True, name="ring"),
)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "shoot").mkdir()
    for name in ("shoot/me.jpg", "studio.hdr"):
        (tmp_path / name).write_bytes(b"pixels")
    return tmp_path / "shoot"


@pytest.fixture
def document(folder):
    return Document(
        PhotoRef(
            folder / "me.jpg",
            1,
            (FaceBox(-3.5, 10.25, 50.0, 63.75, 12.5), FaceBox(80.1, 2.0, 90.1, 12.0)),
            strokes=STROKES,
        ),
        LightRef("panorama", str(folder.parent / "studio.hdr")),
        LightEdit(1.5, 0.4, 0.7, 0.2, -0.1, 12.0, BOXES, True),
        Edit(-35.5, 0.25, 1.5, 0.5, "#30343a", 70.0, 3.0, "final", forced_off=frozenset({"shadow"})),
    )


def saved(folder, document):
    path = session_path(folder / "me.jpg")
    write_session(path, document)
    return path


def tampered(path, **changes):
    content = json.loads(path.read_text())
    for key, value in changes.items():
        *groups, last = key.split("__")
        place = content
        for group in groups:
            place = place[group]
        place[last] = value
    path.write_text(json.dumps(content))
    return path


def test_a_session_comes_back_as_it_was(folder, document):
    path = saved(folder, document)
    assert path.name == "me.relight.json"
    session = read_session(path)
    assert session.document == document
    assert session.notes == ()


def test_a_session_from_before_there_were_boxes_and_strokes_opens(folder, document):
    path = tampered(saved(folder, document), version=1)
    content = json.loads(path.read_text())
    del content["face_boxes"], content["brush_strokes"]
    path.write_text(json.dumps(content))
    session = read_session(path)
    assert session.document == replace(document, photo=replace(document.photo, boxes=None, strokes=()))
    assert session.notes == ()


@pytest.mark.parametrize("boxes", [None, ()])
def test_a_session_tells_no_boxes_from_no_faces(folder, document, boxes):
    document = replace(document, photo=replace(document.photo, boxes=boxes))
    assert read_session(saved(folder, document)).document == document


def test_a_session_names_files_relative_to_itself_and_moves_with_them(folder, document, tmp_path):
    path = saved(folder, document)
    content = json.loads(path.read_text())
    assert (content["photo"], content["light"]["name"]) == ("me.jpg", "../studio.hdr")
    assert str(tmp_path) not in path.read_text()
    moved = tmp_path.parent / f"{tmp_path.name}-moved"
    tmp_path.rename(moved)
    assert read_session(moved / "shoot" / path.name).document.photo.path == moved / "shoot" / "me.jpg"
    moved.rename(tmp_path)


@pytest.mark.parametrize("apart", [False, True])
def test_a_light_file_carries_the_light_its_turn_and_whether_its_lamps_were_taken_out(tmp_path, apart):
    light = SavedLight(LightRef("rig", "ring"), LightEdit(boxes=BOXES, warmth=-1.0, apart=apart), 120.0)
    write_light(tmp_path / "my.light.json", light)
    assert read_light(tmp_path / "my.light.json") == light


def test_a_light_file_moves_with_its_panorama(tmp_path):
    (tmp_path / "lights").mkdir()
    sky = tmp_path / "lights" / "sky.hdr"
    sky.write_bytes(b"light")
    write_light(sky.with_name("my.light.json"), SavedLight(LightRef("panorama", str(sky))))
    moved = (tmp_path / "lights").rename(tmp_path / "moved")
    assert read_light(moved / "my.light.json").light == LightRef("panorama", str(moved / "sky.hdr"))


def test_as_much_as_may_be_painted_can_be_saved_and_opened_again(folder, document):
    points = tuple((round(1000.1 + 7.3 * at, 1), round(99999.9 - 3.7 * at, 1)) for at in range(256))
    strokes = (BrushStroke(points, 1234.5, True),) * 400
    document = replace(document, photo=replace(document.photo, strokes=strokes))
    path = saved(folder, document)
    assert read_session(path).document == document
    assert is_place_for(path, "session")
    assert saved_session(folder / "me.jpg") == path


def test_a_lamp_of_an_odd_shape_or_name_becomes_one_that_can_be_drawn(folder, document):
    odd = {"form": "star", "hole": 1.0, "name": "key\nlight" + "x" * 99}
    session = read_session(tampered(saved(folder, document), light__boxes=[odd]))
    (box,) = session.document.light_edit.boxes
    assert (box.form, box.hole) == ("rectangle", 0.9)
    assert box.name == "keylight" + "x" * 32
    assert sorted(session.notes) == ["hole 1 is out of range and became 0.9", "unknown form star became rectangle"]


def test_the_light_of_an_open_photo_is_not_one_to_file(tmp_path):
    with pytest.raises(InputError, match="session"):
        write_light(tmp_path / "own.light.json", SavedLight(LightRef("own")))
    assert list(tmp_path.iterdir()) == []


def test_angles_come_round_by_whole_turns_and_elevations_stop_at_the_zenith(folder, document):
    lamps = [{"azimuth_deg": azimuth, "elevation_deg": 100} for azimuth in (-180, 180, 200, -541)]
    session = read_session(tampered(saved(folder, document), edit__yaw_deg=810, light__boxes=lamps))
    assert session.document.edit.yaw_deg == 90.0
    assert [box.azimuth_deg for box in session.document.light_edit.boxes] == [-180.0, 180.0, -160.0, 179.0]
    assert {box.elevation_deg for box in session.document.light_edit.boxes} == {90.0}


def test_values_out_of_range_are_moved_in_and_noted(folder, document):
    path = tampered(saved(folder, document), edit__shadow=7, light__boxes=[{"width_deg": 900}], light__level_ev=-99)
    session = read_session(path)
    assert session.document.edit.shadow == 2.0
    assert session.document.light_edit.boxes[0].width_deg == 150.0
    assert session.document.light_edit.level_ev == -10.0
    assert len(session.notes) == 3
    assert "shadow 7 is out of range and became 2" in session.notes


def test_unknown_settings_are_left_out_and_noted(folder, document):
    session = read_session(tampered(saved(folder, document), edit__sparkle=3, surprise=[1]))
    assert session.document == document
    assert sorted(session.notes) == ["unknown setting sparkle was left out", "unknown setting surprise was left out"]


NO_POINTS = ("", "1", "1,2,3", "1,nan", "1,inf", "1,1e9", "a,b", [1, 2], "1,2 " * 257)
WRONG = [
    {"edit__shadow": "1"},
    {"edit__shadow": None},
    {"edit__shadow": True},
    {"edit__yaw_deg": 10**400},
    {"edit": [1]},
    {"edit__background": "red"},
    {"edit__forced_on": "shadow"},
    {"light__boxes": {"0": 1}},
    {"light__boxes": [3]},
    {"light__boxes": [{"colour": [1, 2]}]},
    {"light__kind": "spell"},
    {"light__kind": "rig"},
    {"face": -1},
    {"face": 1.5},
    {"face_boxes": {"x0": 1}},
    {"face_boxes": [4]},
    {"face_boxes": [{"x0": 1, "y0": 2, "x1": "9", "y1": 9}]},
    {"face_boxes": [{"x0": 9, "y0": 9, "x1": 9, "y1": 20}]},
    {"brush_strokes": {"adds": True}},
    {"brush_strokes": [7]},
    {"brush_strokes": [{"adds": 1, "radius_px": 3, "points": "1,2"}]},
    {"brush_strokes": [{"adds": True, "radius_px": "3", "points": "1,2"}]},
    {"brush_strokes": [{"adds": True, "radius_px": 3}]},
    *({"brush_strokes": [{"adds": True, "radius_px": 3, "points": points}]} for points in NO_POINTS),
    {"version": 7},
    {"version": None},
    {"relight": "light"},
    {"photo": None},
    {"photo": "me\0.jpg"},
]


@pytest.mark.parametrize("changes", WRONG, ids=str)
def test_wrong_values_are_refused_in_one_line_that_names_the_file(folder, document, changes):
    path = tampered(saved(folder, document), **changes)
    with pytest.raises(InputError) as refusal:
        read_session(path)
    assert str(path) in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "null", "NaN", '{"relight": "session", "version": 1}', "\x80", "[" * 99999]
)
def test_what_is_no_session_is_refused(tmp_path, text):
    path = tmp_path / "x.relight.json"
    path.write_text(text, encoding="latin-1")
    with pytest.raises(InputError):
        read_session(path)


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999"])
def test_numbers_that_are_none_are_refused(folder, document, number):
    path = saved(folder, document)
    path.write_text(path.read_text().replace('"shadow": 0.5', f'"shadow": {number}'))
    assert number in path.read_text()
    with pytest.raises(InputError):
        read_session(path)


ESCAPES = ["/etc/passwd", "../../../../etc/passwd", "//host/share/me.jpg", "\\\\host\\share\\me.jpg", "~/me.jpg"]
ESCAPES += ["https://host/me.jpg", "C:\\me.jpg", ".", "", "missing.jpg", "pipe.jpg", "/dev/zero", "folder.jpg"]


@pytest.mark.parametrize("name", ESCAPES)
def test_a_session_can_only_name_pictures(folder, document, name):
    os.mkfifo(folder / "pipe.jpg")
    (folder / "folder.jpg").mkdir()
    path = tampered(saved(folder, document), photo=name)
    with pytest.raises(InputError):
        read_session(path)


def test_a_session_replaces_only_a_session(folder, document):
    path = session_path(folder / "me.jpg")
    assert is_place_for(path, "session")
    write_session(path, document)
    assert is_place_for(path, "session")
    assert not is_place_for(folder / "me.jpg", "session")
    path.write_text("my notes")
    assert not is_place_for(path, "session")


def test_there_is_no_session_without_a_photo(tmp_path):
    with pytest.raises(InputError, match="photo"):
        write_session(tmp_path / "x.relight.json", Document())


def test_a_too_large_file_is_not_read(tmp_path):
    path = tmp_path / "x.relight.json"
    path.write_bytes(b" " * 4_000_001)
    with pytest.raises(InputError, match="too large"):
        read_session(path)


def test_the_quality_that_was_chosen_comes_back(folder, document):
    path = saved(folder, replace(document, quality="draft"))
    assert read_session(path).document.quality == "draft"
    assert read_session(saved(folder, document)).document.quality == "auto"


def test_an_unknown_quality_becomes_auto_and_is_noted(folder, document):
    session = read_session(tampered(saved(folder, document), quality="best"))
    assert session.document.quality == "auto"
    assert any("quality" in note for note in session.notes)


def test_the_quality_of_a_saved_edit_is_final(folder, document):
    hasty = replace(document, edit=replace(document.edit, quality="live"))
    assert read_session(saved(folder, hasty)).document == document
    assert Path(document.photo.path).exists()


def test_a_light_from_before_there_was_a_meter_has_its_own_level(folder, document):
    path = saved(folder, document)
    content = json.loads(path.read_text())
    assert content["light"].pop("metered") is True
    path.write_text(json.dumps(content))
    session = read_session(path)
    assert session.document == replace(document, light_edit=replace(document.light_edit, metered=False))
    assert session.notes == ()


@pytest.mark.parametrize("value", [1, "true", None, []])
def test_whether_a_light_is_metered_is_yes_or_no(folder, document, value):
    with pytest.raises(InputError, match="metered"):
        read_session(tampered(saved(folder, document), light__metered=value))


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """A photo among the program's own files, and a current folder elsewhere."""
    for name in ("program", "here"):
        (tmp_path / name).mkdir()
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "program"))
    monkeypatch.chdir(tmp_path / "here")
    photo = tmp_path / "program" / "sample.png"
    photo.write_bytes(b"pixels")
    return photo


def test_a_session_of_an_installed_photo_lies_in_the_current_folder_and_is_found_there(installed, tmp_path):
    path = tmp_path / "here" / "sample.relight.json"
    assert session_path(installed) == path
    assert saved_session(installed) is None
    write_session(path, Document(PhotoRef(installed)))
    assert saved_session(installed) == path
    assert read_session(path).document.photo.path == installed


def test_a_session_in_the_current_folder_is_no_other_photo_s(installed, tmp_path):
    other = tmp_path / "here" / "sample.png"
    other.write_bytes(b"pixels")
    write_session(session_path(other), Document(PhotoRef(other)))
    assert saved_session(other) == session_path(other)
    assert saved_session(installed) is None
    session_path(other).write_text('{"relight": "session"}')
    assert saved_session(installed) is None
