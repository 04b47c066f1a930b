"""Files as each version of the editor has written them, written out: they open as what they were."""

import json
from dataclasses import replace

import pytest

from app.document.document import Document, LightRef, PhotoRef
from app.document.light_file import SavedLight, read_light, write_light
from app.document.session_file import read_session, write_session
from relight_core.face.find import FaceBox
from relight_core.lighting.light_edit import LightEdit
from relight_core.lighting.soft_box import SoftBox
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_photo.brush import BrushStroke

SQUARE = {"azimuth_deg": -60.0, "elevation_deg": 20.0, "width_deg": 44.0, "height_deg": 12.0, "softness": 0.1}
SQUARE |= {"kelvin": 3200.0, "colour": None, "intensity": 1.7}
LAMP = SQUARE | {"colour": [0.9, 0.1, 0.2], "form": "disc", "hole": 0.5, "off": True, "name": "ring"}
LIGHT = {"kind": "rig", "name": "ring", "level_ev": 1.5, "base": 0.4, "saturation": 0.7, "warmth": 0.2, "tint": -0.1}
LIGHT |= {"blur_deg": 12.0, "metered": True}
EDIT = {"yaw_deg": -35.5, "exposure_ev": 0.25, "specular": 1.5, "shadow": 0.5, "specular_tint": -0.5}
EDIT |= {"shadow_softness": 0.75, "background_fov_deg": 70.0, "background_blur_deg": 3.0, "background": "#30343a"}
EDIT |= {"forced_on": ["detail"], "forced_off": ["shadow"]}
FIRST = {"relight": "session", "version": 1, "photo": "me.jpg", "face": 1, "quality": "draft", "edit": EDIT}
FIRST |= {"light": LIGHT | {"boxes": [SQUARE]}}
SECOND = FIRST | {"version": 2, "face_boxes": [{"x0": -3.5, "y0": 10.25, "x1": 50.0, "y1": 63.75, "roll_deg": 12.5}]}
STROKES = [{"adds": True, "radius_px": 20.5, "points": "12.5,-3 40.1,99999.9"}]
THIRD = SECOND | {"version": 3, "brush_strokes": STROKES}
FOURTH = THIRD | {"version": 4, "light": LIGHT | {"boxes": [SQUARE, LAMP], "apart": True}}
FIFTH = FOURTH | {"version": 5, "edit": EDIT | {"strength": 0.4}}
SIXTH = FIFTH | {"version": 6, "photo_size": {"width": 6000, "height": 4000}}

LIKE_ALL_BEFORE = {"form": "rectangle", "hole": 0.0, "off": False, "name": ""}

A_BOX = SoftBox(-60.0, 20.0, 44.0, 12.0, 0.1, 3200.0, None, 1.7)
A_LAMP = replace(A_BOX, colour=(0.9, 0.1, 0.2), form="disc", hole=0.5, off=True, name="ring")
PLAIN = LightEdit(1.5, 0.4, 0.7, 0.2, -0.1, 12.0, (A_BOX,), True)
APART = replace(PLAIN, boxes=(A_BOX, A_LAMP), apart=True)
FACE = (FaceBox(-3.5, 10.25, 50.0, 63.75, 12.5),)
STROKE = (BrushStroke(((12.5, -3.0), (40.1, 99999.9)), 20.5, True),)
SET = Edit(-35.5, 0.25, 1.5, 0.5, "#30343a", 70.0, 3.0, "final", specular_tint=-0.5, shadow_softness=0.75)
SET = replace(SET, forced_on=frozenset({"detail"}), forced_off=frozenset({"shadow"}))


@pytest.fixture
def photo(tmp_path):
    (tmp_path / "me.jpg").write_bytes(b"pixels")
    return tmp_path / "me.jpg"


def document(photo, boxes=None, strokes=(), light_edit=PLAIN, strength=1.0, size=None):
    edit, portrait = replace(SET, strength=strength), PhotoRef(photo, 1, boxes, strokes=strokes, size=size)
    return Document(portrait, LightRef("rig", "ring"), light_edit, edit, "draft")


@pytest.mark.parametrize(
    ("content", "held"),
    [
        (FIRST, {}),
        (SECOND, {"boxes": FACE}),
        (THIRD, {"boxes": FACE, "strokes": STROKE}),
        (FOURTH, {"boxes": FACE, "strokes": STROKE, "light_edit": APART}),
        (FIFTH, {"boxes": FACE, "strokes": STROKE, "light_edit": APART, "strength": 0.4}),
        (SIXTH, {"boxes": FACE, "strokes": STROKE, "light_edit": APART, "strength": 0.4, "size": (6000, 4000)}),
    ],
)
def test_a_session_of_every_version_opens(photo, content, held):
    path = photo.with_name("me.relight.json")
    path.write_text(json.dumps(content))
    session = read_session(path)
    assert session.document == document(photo, **held)
    assert session.document.photo.size == held.get("size")
    assert session.notes == ()


@pytest.mark.parametrize(
    ("version", "light", "held"),
    [(1, {"boxes": [SQUARE]}, PLAIN), (2, {"boxes": [SQUARE, LAMP], "apart": True}, APART)],
)
def test_a_light_of_every_version_opens(tmp_path, version, light, held):
    path = tmp_path / "my.light.json"
    content = {"relight": "light", "version": version, "yaw_deg": 120.0, "light": LIGHT | light}
    path.write_text(json.dumps(content))
    assert read_light(path) == SavedLight(LightRef("rig", "ring"), held, 120.0)


def test_what_is_saved_is_what_the_newest_version_reads(photo):
    path, light = photo.with_name("me.relight.json"), photo.with_name("my.light.json")
    write_session(path, document(photo, FACE, STROKE, APART, 0.4, (6000, 4000)))
    boxes = [SQUARE | LIKE_ALL_BEFORE, LAMP]
    assert json.loads(path.read_text()) == SIXTH | {"light": SIXTH["light"] | {"boxes": boxes}}
    write_light(light, SavedLight(LightRef("rig", "ring"), APART, 120.0))
    assert json.loads(light.read_text())["version"] == 2
