"""Faces and strokes of the brush that are read of a session, and what a wish for a photo keeps of them."""

import json

import numpy as np
import pytest

from app.document.brush_strokes import brush_strokes_content
from app.document.document import Document, PhotoRef
from app.document.session_file import read_session, write_session
from app.engine.sources import PhotoSource
from relight_core.errors import InputError
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.pipeline.per_photo.brush import BrushStroke

BOX = {"x0": 1.0, "y0": 2.0, "x1": 30.0, "y1": 40.0, "roll_deg": -30.0}
STROKE = {"adds": True, "radius_px": 3.0, "points": "1,2"}
STROKES = (BrushStroke(((1.0, 2.0),), 3.0, True),)


@pytest.fixture
def session(tmp_path):
    """What is read of a session with such entries."""
    photo, path = tmp_path / "me.jpg", tmp_path / "me.relight.json"
    photo.write_bytes(b"pixels")
    write_session(path, Document(PhotoRef(photo)))

    def read(**entries):
        path.write_text(json.dumps(json.loads(path.read_text()) | entries))
        return read_session(path)

    return read


@pytest.mark.parametrize("change", [{"y1": 2.9}, {"x1": 1.9}, {"x0": 40.0}, {"y0": 50.0}])
def test_a_face_is_at_least_a_pixel_wide_and_high(session, change):
    with pytest.raises(InputError, match="the box of a face is empty"):
        session(face_boxes=[BOX | change])


def test_a_face_and_a_stroke_of_a_large_photo_or_beyond_its_edge_stay_where_they_are(session):
    box, place = BOX | {"x0": -900.0, "x1": 40_000.5, "y1": 30_000.25}, (12_345.625, -98_765.5)
    read = session(face_boxes=[box], brush_strokes=[STROKE | {"points": "12345.625,-98765.5"}])
    assert read.document.photo.boxes == (FaceBox(-900.0, 2.0, 40_000.5, 30_000.25, -30.0),)
    assert read.document.photo.strokes == (BrushStroke((place,), 3.0, True),)
    assert brush_strokes_content(read.document.photo.strokes)[0]["points"] == "12345.625,-98765.5"
    assert read.notes == ()


def test_there_are_no_more_faces_and_strokes_than_a_photo_may_have(session):
    read = session(face_boxes=[BOX] * 33, brush_strokes=[STROKE] * 401)
    assert read.document.photo.boxes == (FaceBox(1.0, 2.0, 30.0, 40.0, -30.0),) * 32
    assert read.document.photo.strokes == STROKES * 400
    assert read.notes == (
        "only the first 32 of 33 face_boxes were read",
        "only the first 400 of 401 brush_strokes were read",
    )


def test_what_is_unknown_of_a_face_or_a_stroke_is_noted(session):
    read = session(face_boxes=[BOX | {"smile": 1}], brush_strokes=[STROKE | {"colour": "red"}])
    assert read.notes == ("unknown setting smile was left out", "unknown setting colour was left out")


def test_a_stroke_with_no_width_gets_the_thinnest_and_is_noted(session):
    read = session(brush_strokes=[{"adds": False, "points": "1,2 3,4"}])
    assert read.document.photo.strokes == (BrushStroke(((1.0, 2.0), (3.0, 4.0)), 0.1, False),)
    assert read.notes == ("radius_px 0 is out of range and became 0.1",)


@pytest.mark.parametrize(
    "size",
    [{}, {"width": 40}, {"width": 0, "height": 30}, {"width": 40, "height": 30.5}, {"width": -40, "height": 30}],
)
def test_a_size_of_the_photo_that_is_none_is_refused(session, size):
    with pytest.raises(InputError, match="the photo's size is none; mend the file or delete its photo_size"):
        session(photo_size=size)


@pytest.mark.parametrize("boxes", [None, (), (FaceBox(1.0, 2.0, 30.0, 40.0),)])
def test_a_wish_for_a_photo_keeps_who_is_relit_where_and_what_was_painted(tmp_path, boxes):
    source = PhotoSource(tmp_path / "me.jpg", 1, boxes, STROKES)
    found = (FaceBox(0.0, 0.0, 9.0, 9.0),)
    named = PhotoRef.of(source, tmp_path / "me.jpg", found)
    assert named.faces == (found if boxes is None else boxes)
    read = Photo(np.zeros((4, 4, 3), np.float32))
    assert named.wish().place == tmp_path / "me.jpg"
    assert named.wish(read).place is read
    for wish in (named.wish(), named.wish(read)):
        assert (wish.face_index, wish.boxes, wish.strokes) == (1, boxes, STROKES)
