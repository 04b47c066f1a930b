"""What painting over the outline does to the editor's state, without a window."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from opened_things import refuse_photo

from app.document.document import Document, PhotoRef
from app.engine.snapshot import OpenPhoto, Snapshot
from app.ui import brush_edits, face_edits, light_edits
from app.ui.photo_works import portrait_of
from app.ui.state import EditorState
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.pipeline.per_photo.brush import BrushStroke, checked_strokes

ONE = FaceBox(0, 0, 20, 20)
PLACE = Path("/photos/us.jpg")
OLD = BrushStroke(((5.0, 5.0),), 3.0, True)


@dataclass(eq=False)
class SomePicture:
    """Stands for a relit picture, of which nothing is read here."""

    opened: OpenPhoto


def open_photo(alpha=None):
    state = EditorState()
    state.open_photo(PLACE)
    photo = Photo(np.zeros((40, 80, 3), np.float32), alpha, path=PLACE)
    opened = OpenPhoto(state.photo, photo, np.zeros((40, 80, 3), np.float16))
    state.accept(Snapshot(opened=opened, faces=(ONE,), picture=SomePicture(opened)))
    brush_edits.show(state)
    return state


@pytest.fixture
def state():
    return open_photo()


def paint(state, *points, radius_px=4.0, adds=True):
    brush_edits.begin(state, points[0], radius_px, adds)
    for point in points[1:]:
        brush_edits.move(state, point)
    brush_edits.lift(state)


def test_strokes_come_after_those_before_and_the_photo_is_not_read_again(state):
    paint(state, (10, 10), (20, 10))
    paint(state, (30.04, 5.06), adds=False)
    first, second = state.photo.strokes
    assert (first.points, first.adds) == (((10, 10), (20, 10)), True)
    assert second == BrushStroke(((30.0, 5.1),), 4.0, False)
    assert state.photo.place is state.snapshot.opened.photo
    assert state.document().photo.strokes == (first, second)
    assert portrait_of(state, PLACE).strokes == (first, second)


def test_nothing_counts_before_the_brush_is_lifted(state):
    brush_edits.begin(state, (10, 10), 4.0, True)
    brush_edits.move(state, (20, 20))
    assert state.photo.strokes == ()
    brush_edits.cancel(state)
    assert state.photo.strokes == ()
    assert state.brush.is_open
    assert state.brush.painting is None


def test_undo_while_a_stroke_is_painted_forgets_that_stroke_alone(state):
    paint(state, (10, 10))
    kept = state.photo.strokes
    brush_edits.begin(state, (30, 30), 4.0, True)
    assert light_edits.can_undo(state)
    light_edits.undo(state)
    assert state.brush.painting is None
    assert state.photo.strokes == kept


def test_escape_takes_back_what_was_painted_since_the_brush_was_taken_up(state):
    paint(state, (10, 10))
    brush_edits.done(state)
    kept = state.photo.strokes
    brush_edits.show(state)
    paint(state, (30, 30))
    brush_edits.cancel(state)
    assert state.photo.strokes == kept
    assert not state.brush.is_open
    wish = state.photo
    brush_edits.show(state)
    brush_edits.cancel(state)
    assert state.photo is wish, "nothing was painted, so nothing is asked for"


def test_points_too_near_to_be_seen_are_left_out_and_a_long_stroke_becomes_several(state):
    paint(state, (10, 10), (10.1, 10), (10.2, 10), radius_px=4.0)
    assert len(state.photo.strokes[0].points) == 1
    paint(state, (10, 10), (10, 12), (12, 12), radius_px=4.0)
    assert len(state.photo.strokes[1].points) == 3, "downward is as far as across"
    way = [(float(x % 80), float(x % 37)) for x in range(1000)]
    paint(state, *way, radius_px=1.0)
    _, _, *parts = state.photo.strokes
    assert len(parts) == 4
    paint(state, *way[:256], radius_px=1.0)
    assert len(state.photo.strokes) == 7, "as many points as one may have are one"
    checked_strokes(parts)
    for before, after in zip(parts, parts[1:], strict=False):
        assert before.points[-1] == after.points[0]
    assert [*parts[0].points, *(point for part in parts[1:] for point in part.points[1:])] == way


def test_whatever_the_hand_does_the_strokes_can_be_used_and_saved(state):
    paint(state, (1e9, -1e9), (float(10**6), 3.0), radius_px=1e9)
    paint(state, (1, 1), radius_px=1e-9)
    assert checked_strokes(state.photo.strokes) == state.photo.strokes


def test_there_are_only_so_many_strokes(state):
    state.photo = type(state.photo)(state.photo.place, None, None, (OLD,) * 399)
    opened = replace(state.snapshot.opened, source=state.photo)
    state.accept(Snapshot(opened=opened, faces=(ONE,), picture=SomePicture(opened)))
    paint(state, (10, 10))
    assert len(state.photo.strokes) == 400
    assert not state.asking.notices
    paint(state, (20, 10))
    assert len(state.photo.strokes) == 400
    assert state.asking.notices[0][1]


def test_corrected_faces_keep_the_outline_and_another_choice_of_them_too(state):
    paint(state, (10, 10))
    strokes = state.photo.strokes
    state.choose_face(0)
    assert (state.photo.face_index, state.photo.strokes) == (0, strokes)
    face_edits.find_again(state)
    assert state.photo.strokes == strokes


def test_a_stroke_that_ends_when_another_photo_is_on_its_way_is_not_painted_on_either(state):
    brush_edits.begin(state, (10, 10), 4.0, True)
    state.open_photo(Path("/photos/other.jpg"))
    wish = state.photo
    brush_edits.lift(state)
    assert state.photo is wish
    assert wish.strokes == ()


def test_there_is_no_brush_before_a_picture_or_while_another_photo_is_on_its_way(state):
    brush_edits.done(state)
    picture, state.snapshot = state.snapshot.picture, replace(state.snapshot, picture=None)
    brush_edits.show(state)
    assert not state.brush.is_open
    state.snapshot = replace(state.snapshot, picture=picture)
    state.open_photo(Path("/photos/other.jpg"))
    brush_edits.show(state)
    assert not state.brush.is_open


def test_as_found_forgets_all_strokes(state):
    paint(state, (10, 10))
    brush_edits.begin(state, (30, 30), 4.0, True)
    brush_edits.forget(state)
    assert (state.photo.strokes, state.brush.painting) == ((), None)
    assert state.brush.is_open


def test_one_tool_at_a_time(state):
    face_edits.show(state)
    assert (state.faces.is_open, state.brush.is_open) == (True, False)
    brush_edits.show(state)
    assert (state.faces.is_open, state.brush.is_open) == (False, True)
    for show in (brush_edits.show, face_edits.show):
        show(state)
        light_edits.switch_aim(state, "bright")
        assert (state.faces.is_open, state.brush.is_open, state.aim.target) == (False, False, "bright")
    light_edits.switch_aim(state, "highlight")
    assert state.aim.target == "highlight"
    light_edits.switch_aim(state, "highlight")
    assert state.aim.target == ""


def test_a_photo_that_is_cut_out_has_its_outline():
    state = open_photo(np.zeros((40, 80), np.float32))
    assert not state.brush.is_open
    assert "transparency" in state.asking.notices[-1][0]


def test_the_brush_stays_within_sizes_that_can_be_used(state):
    for _ in range(100):
        brush_edits.resize(state, 1)
    assert state.brush.radius_em == 12.0
    for _ in range(100):
        brush_edits.resize(state, -1)
    assert state.brush.radius_em == 0.2


def drop_a_session(state):
    state.open_session(Document(PhotoRef(Path("/photos/broken.jpg"))), None)


def test_strokes_outlast_a_session_that_can_not_be_opened(state):
    paint(state, (10, 10))
    drop_a_session(state)
    refuse_photo(state)
    assert (state.photo.path, len(state.photo.strokes)) == (PLACE, 1)


def test_strokes_after_another_photo_was_taken_back_outlast_a_session_that_can_not_be_opened(state):
    paint(state, (10, 10))
    before = state.document()
    state.open_photo(Path("/photos/other.jpg"))
    state.restore(before)
    paint(state, (30, 30))
    drop_a_session(state)
    refuse_photo(state)
    assert len(state.photo.strokes) == 2


def test_choosing_a_face_while_another_photo_is_on_its_way_keeps_the_strokes(state):
    paint(state, (10, 10))
    state.open_photo(Path("/photos/other.jpg"))
    state.choose_face(0)
    assert (state.photo.path, state.photo.face_index, len(state.photo.strokes)) == (PLACE, 0, 1)


def test_a_brush_that_is_put_away_paints_no_more(state):
    brush_edits.begin(state, (10, 10), 4.0, True)
    brush_edits.done(state)
    assert (state.brush.painting, state.photo.strokes) == (None, ())


def test_the_brush_adds_whenever_it_is_taken_up(state):
    for adds in (False, True, False):
        brush_edits.turn_over(state)
        assert state.brush.adds is adds
    for _ in range(2):
        brush_edits.switch(state)
    assert (state.brush.is_open, state.brush.adds) == (True, True)


def test_the_brush_stays_as_large_from_one_photo_to_the_next(state):
    brush_edits.resize(state, 2)
    radius_em = state.brush.radius_em
    state.open_photo(Path("/photos/other.jpg"))
    opened = OpenPhoto(state.photo, Photo(np.zeros((40, 80, 3), np.float32)), np.zeros((4, 8, 3), np.float16))
    state.accept(replace(state.snapshot, opened=opened))
    assert state.brush.radius_em == radius_em
    assert not state.brush.is_open
