"""A session or a light file whose light is put on another photo."""

import json

import pytest

from app.document.document import Document, LightRef, PhotoRef
from app.document.light_file import SavedLight, write_light
from app.document.session_file import read_lent_light, write_session
from relight_core.errors import InputError
from relight_core.face.find import FaceBox
from relight_core.lighting.light_edit import LightEdit
from relight_core.lighting.soft_box import SoftBox
from relight_core.pipeline.edit import Edit

CHANGED = LightEdit(level_ev=1.5, base=0.5, boxes=(SoftBox(azimuth_deg=40.0),))


@pytest.fixture
def photo(tmp_path):
    (tmp_path / "me.jpg").write_bytes(b"pixels")
    return PhotoRef(tmp_path / "me.jpg", None, (FaceBox(1.0, 2.0, 9.0, 10.0),))


@pytest.fixture
def session(tmp_path, photo):
    """Writes me.relight.json of a light, and of edits as they stand in the file."""

    def write(light, **edits):
        path = tmp_path / "me.relight.json"
        write_session(path, Document(photo, light, CHANGED, Edit(yaw_deg=30.0)))
        content = json.loads(path.read_text())
        content["edit"] |= edits
        path.write_text(json.dumps(content))
        return path

    return write


def test_a_session_lends_its_light_with_its_turn(session, photo):
    lent = read_lent_light(session(LightRef("rig", "ring")))
    assert lent.saved == SavedLight(LightRef("rig", "ring"), CHANGED, 30.0)
    assert lent.photo == photo


def test_the_original_light_of_a_session_is_borrowed_from_its_photo(session, photo):
    lent = read_lent_light(session(LightRef("own")))
    assert lent.saved == SavedLight(LightRef("portrait", str(photo.path)), CHANGED, 30.0)
    assert lent.photo == photo


def test_a_light_needs_no_photo_unless_it_is_that_photos_own(session, photo):
    rig, own = session(LightRef("rig", "ring")).read_text(), session(LightRef("own"))
    photo.path.unlink()
    with pytest.raises(InputError, match=r"me\.jpg"):
        read_lent_light(own)
    own.write_text(rig)
    lent = read_lent_light(own)
    assert lent.saved.light == LightRef("rig", "ring")
    assert lent.photo is None


def test_only_what_belongs_to_the_light_is_read_and_noted(session):
    path = session(LightRef("rig", "ring"), shadow="damaged", specular=9.0, yaw_deg=270.0)
    saved = read_lent_light(path).saved
    assert saved.yaw_deg == -90.0
    assert saved.notes == ("yaw_deg 270 is out of range and became -90",)


def test_a_light_file_names_no_photo_whose_light_it_could_be(tmp_path):
    path = tmp_path / "my.light.json"
    write_light(path, SavedLight(LightRef("rig", "ring")))
    path.write_text(path.read_text().replace('"rig"', '"own"'))
    with pytest.raises(InputError, match="photo"):
        read_lent_light(path)
