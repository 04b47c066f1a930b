"""Sessions at the ends of what may be set, with notes about more than one thing, and of photos that have moved."""

import json
import sys

import pytest

from app.document.document import Document, LightRef, PhotoRef
from app.document.session_file import free_session_path, read_session, saved_session, write_session
from relight_core.face.find import FaceBox
from relight_core.pipeline.edit import Edit

STRONGEST = {"yaw_deg": 180.0, "exposure_ev": 16.0, "specular": 2.0, "shadow": 2.0, "specular_tint": 1.0}
STRONGEST |= {"shadow_softness": 1.0, "strength": 1.0, "background_fov_deg": 170.0, "background_blur_deg": 20.0}
FAINTEST = {"yaw_deg": -180.0, "exposure_ev": -16.0, "specular": 0.0, "shadow": 0.0, "specular_tint": -1.0}
FAINTEST |= {"shadow_softness": 0.0, "strength": 0.0, "background_fov_deg": 5.0, "background_blur_deg": 0.0}


@pytest.fixture
def photo(tmp_path):
    folder = tmp_path / "shoot"
    folder.mkdir()
    (folder / "me.jpg").write_bytes(b"pixels")
    return folder / "me.jpg"


def written(photo, **fields):
    path = photo.with_name("me.relight.json")
    write_session(path, Document(PhotoRef(photo), **fields))
    return path


@pytest.mark.parametrize("settings", [STRONGEST, FAINTEST])
def test_sliders_at_their_ends_come_back(photo, settings):
    edit = Edit(**settings, quality="final", forced_on=frozenset({"detail", "shadow"}))
    session = read_session(written(photo, edit=edit))
    assert (session.document.edit, session.notes) == (edit, ())


def test_a_background_that_is_nothing_wide_becomes_one_that_can_be_seen(photo):
    path = written(photo)
    content = json.loads(path.read_text())
    content["edit"]["background_fov_deg"] = 0
    path.write_text(json.dumps(content))
    assert read_session(path).document.edit.background_fov_deg == 5.0


def test_a_note_about_a_light_that_is_gone_matters_only_where_that_light_follows(photo, tmp_path):
    sky = tmp_path / "sky.hdr"
    sky.write_bytes(b"pixels")
    path = written(photo, light=LightRef("panorama", str(sky)))
    content = json.loads(path.read_text()) | {"face_boxes": [{"x0": 1, "y0": 1, "x1": 9, "y1": 9, "roll_deg": 720}]}
    path.write_text(json.dumps(content))
    sky.unlink()
    session = read_session(path)
    about_box, about_light = session.notes
    assert "roll_deg 720" in about_box
    assert "sky.hdr is not there" in about_light
    assert session.lost_light == about_light
    assert session.told(light_follows=False) == [about_box, about_light]
    assert session.told(light_follows=True) == [about_box]
    assert session.document == Document(PhotoRef(photo, boxes=(FaceBox(1, 1, 9, 9, 0.0),)))


def test_a_session_beside_a_photo_is_found_where_its_exports_go_elsewhere_by_now(photo, tmp_path, monkeypatch):
    path = written(photo)
    monkeypatch.setattr(sys, "prefix", str(photo.parent))
    monkeypatch.chdir(tmp_path)
    assert saved_session(photo) == path


def test_a_session_s_ending_is_known_in_large_letters(photo):
    taken = photo.with_name("Mine.RELIGHT.JSON")
    taken.touch()
    assert free_session_path(taken, photo).name == "Mine.relight.json"


def test_a_light_that_a_portrait_beside_the_photo_lends_moves_with_both(photo, tmp_path):
    friend = photo.with_name("friend.jpg")
    friend.write_bytes(b"pixels")
    path = written(photo, light=LightRef("portrait", str(friend)))
    moved = photo.parent.rename(tmp_path / "moved")
    assert read_session(moved / path.name).document.light == LightRef("portrait", str(moved / "friend.jpg"))


def test_the_photo_s_own_light_has_no_name_and_no_light_more_boxes_than_can_be_drawn(photo):
    path = written(photo, light=LightRef("own"))
    content = json.loads(path.read_text())
    content["light"] |= {"name": "anything", "boxes": [{}] * 17}
    path.write_text(json.dumps(content))
    session = read_session(path)
    assert session.document.light == LightRef("own")
    assert len(session.document.light_edit.boxes) == 16
    assert session.notes == ("only the first 16 of 17 boxes were read",)
