"""Where corrected faces and outlines belong in a photo of another size, and that the networks see them there."""

from dataclasses import astuple, replace

import pytest
from corrected_photo import BOXES, CROPPED, HALF, HALF_STROKES, LARGE, SMALL, STROKES, corrected, held
from fake_relighter import answered

from app.document.document import Document, PhotoRef
from app.engine.resized import at_size, size_note
from app.engine.sources import LightSource, PhotoSource, Request
from app.ui.state import EditorState
from relight_core.face.find import FaceBox
from relight_core.pipeline.per_photo.brush import BrushStroke


@pytest.mark.parametrize("kind", [PhotoRef, PhotoSource])
def test_boxes_and_strokes_are_scaled_to_a_photo_of_the_same_proportions(photos, kind):
    portrait = kind(photos[0], 1, BOXES, strokes=STROKES, size=LARGE)
    assert held(at_size(portrait, SMALL)) == (1, HALF, HALF_STROKES, SMALL)
    assert held(at_size(at_size(portrait, SMALL), LARGE)) == (1, BOXES, STROKES, LARGE)
    note = "was 80 by 60 pixels when it was worked on and is 40 by 30 now; scaled to that: "
    assert size_note(portrait, SMALL) == note + "boxes of faces, strokes of the outline"


def test_in_a_photo_of_other_proportions_nobody_knows_where_faces_and_outlines_belong(photos):
    assert held(at_size(corrected(photos[0]), CROPPED)) == (None, None, (), CROPPED)
    note = "was 80 by 60 pixels when it was worked on and is 60 by 60 now; left out: "
    assert size_note(corrected(photos[0]), CROPPED) == (
        note + "boxes of faces, strokes of the outline, the choice of one face"
    )
    assert size_note(PhotoRef(photos[0], size=LARGE), CROPPED) is None


@pytest.mark.parametrize(
    ("size", "other", "alike"),
    [
        ((6000, 4000), (1024, 683), True),
        ((6000, 4000), (1024, 682), True),
        ((6000, 4000), (1024, 684), False),
        ((101, 67), (6000, 4000), True),
        ((6000, 4000), (4000, 6000), False),
        ((4000, 6000), (683, 1024), True),
        ((4000, 6000), (685, 1024), False),
        ((6000, 4000), (6000, 4001), True),
        ((6000, 4000), (6000, 4002), False),
    ],
)
def test_proportions_are_the_same_to_within_a_pixel_of_the_smaller_photo(photos, size, other, alike):
    for one, two in ((size, other), (other, size)):
        boxes = at_size(PhotoRef(photos[0], None, (FaceBox(0.0, 0.0, *one),), size=one), two).boxes
        corners = boxes and astuple(boxes[0])[:4]
        assert corners == (pytest.approx((0.0, 0.0, *two)) if alike else None)


def test_what_is_scaled_stays_within_what_a_session_may_hold(photos):
    stroke = BrushStroke(((90_000.0, -90_000.0),), 9000.0, False)
    portrait = PhotoRef(photos[0], None, (FaceBox(0.0, 0.0, 2.0, 4.0),), strokes=(stroke,), size=(100, 100))
    assert at_size(portrait, (200, 200)).strokes == (BrushStroke(((100_000.0, -100_000.0),), 10_000.0, False),)
    tiny = at_size(replace(portrait, strokes=(BrushStroke(((1.0, 1.0),), 0.2, True),)), (10, 10))
    assert tiny.boxes == (FaceBox(-0.4, -0.3, 0.6, 0.7),)
    assert tiny.strokes[0].radius_px == 0.1


def test_the_networks_see_faces_and_outline_where_they_are_in_the_photo_that_is_read(engine, relighter, photo_path):
    boxes, strokes = (FaceBox(16.0, 8.0, 48.0, 40.0),), (BrushStroke(((8.0, 4.0),), 6.0, True),)
    seen, painted = (FaceBox(32.0, 16.0, 96.0, 80.0),), (BrushStroke(((16.0, 8.0),), 12.0, True),)
    state = EditorState()
    state.open_session(Document(PhotoRef(photo_path, 0, boxes, strokes=strokes, size=(64, 48))), None)
    for _ in range(2):
        state.accept(answered(engine, state.request()))
        assert relighter.portraits[-1][1:] == (0, seen)
        assert relighter.strokes == painted
    assert state.snapshot.opened.source is state.photo
    assert held(state.document().photo) == (0, seen, painted, (128, 96))
    assert not state.snapshot.picture.is_stale


def test_the_portrait_that_a_lender_of_light_has_replaced_comes_back_with_its_faces_where_they_are(
    engine, relighter, photo_path
):
    wish = PhotoSource(photo_path, 0, (FaceBox(16.0, 8.0, 48.0, 40.0),), size=(64, 48))
    answered(engine, Request(photo=wish, light=LightSource("rig", "ring")))
    answered(engine, Request(photo=wish, light=LightSource("portrait", str(photo_path))))
    faces = [portrait[2] for portrait in relighter.portraits]
    assert len(faces) == 3
    assert faces[-1] == faces[0] == (FaceBox(32.0, 16.0, 96.0, 80.0),)
