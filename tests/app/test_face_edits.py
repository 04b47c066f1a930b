"""What correcting the faces does to the editor's state, without a window."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.engine.snapshot import OpenPhoto, Snapshot
from app.ui import face_edits
from app.ui.actions.setting_actions import setting_actions
from app.ui.photo_works import portrait_of
from app.ui.state import EditorState
from app.ui.viewport.face_boxes import FaceGrab
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo

ONE, TWO, THREE = FaceBox(0, 0, 20, 20), FaceBox(30, 0, 45, 15), FaceBox(50, 20, 60, 30)
PLACE = Path("/photos/us.jpg")


def answered(state, found):
    """The engine has done what was asked for; the finder would see `found`."""
    source = state.photo
    seen = state.snapshot.opened
    photo = seen.photo if seen and seen.shows(source) else Photo(np.zeros((40, 80, 3), np.float32), path=source.path)
    opened = OpenPhoto(source, photo, np.zeros((40, 80, 3), np.float16))
    state.accept(Snapshot(opened=opened, faces=found if source.boxes is None else source.boxes))


@pytest.fixture
def state():
    state = EditorState()
    state.open_photo(PLACE)
    answered(state, (ONE, TWO))
    return state


def drop(state, boxes):
    """The end of a drag that led to these boxes."""
    state.faces.held, state.faces.moving = FaceGrab("move", 0, ONE), boxes
    face_edits.finish_drag(state)


def test_boxes_are_as_found_until_they_are_moved(state):
    assert face_edits.wished_boxes(state) == (ONE, TWO)
    drop(state, (THREE, TWO))
    assert face_edits.wished_boxes(state) == (THREE, TWO)
    assert state.faces.held is None
    assert state.photo.place is state.snapshot.opened.photo, "it is not read again"
    assert state.document().photo.boxes == (THREE, TWO)


def test_nothing_is_wished_before_the_hand_lets_go(state):
    wish = state.photo
    state.faces.moving = (THREE, TWO)
    assert face_edits.wished_boxes(state) == (ONE, TWO)
    assert state.photo is wish
    state.faces.moving = None
    state.faces.held = FaceGrab("move", 0, ONE)
    face_edits.finish_drag(state)
    assert state.photo is wish, "a click moves nothing"


def test_escape_forgets_the_drag_first_then_all_that_was_changed(state):
    face_edits.show(state)
    drop(state, (THREE, TWO))
    answered(state, (ONE, TWO))
    state.faces.held, state.faces.moving = FaceGrab("move", 1, TWO), (THREE, THREE)
    face_edits.cancel(state)
    assert state.faces.is_open
    assert state.faces.moving is None
    face_edits.cancel(state)
    assert not state.faces.is_open
    assert state.photo.boxes is None
    answered(state, (ONE, TWO))
    wish = state.photo
    face_edits.show(state)
    face_edits.cancel(state)
    assert state.photo is wish, "nothing was changed, so nothing is asked for"


def test_escape_brings_back_who_was_relit_alone(state):
    state.choose_face(1)
    answered(state, (ONE, TWO))
    face_edits.show(state)
    state.faces.selected = 1
    state.faces.held, state.faces.moving = FaceGrab("move", 1, TWO), (ONE, THREE)
    face_edits.remove(state)
    assert (state.photo.face_index, state.photo.boxes) == (None, (ONE,))
    face_edits.finish_drag(state)
    assert state.photo.boxes == (ONE,), "what was dragged went with its box"
    face_edits.cancel(state)
    assert (state.photo.face_index, state.photo.boxes) == (1, None)
    face_edits.show(state)
    state.choose_face(0)
    face_edits.cancel(state)
    assert state.photo.face_index == 1, "also where no box was touched"


def test_done_keeps_what_was_changed(state):
    face_edits.show(state)
    drop(state, (THREE, TWO))
    face_edits.done(state)
    assert state.photo.boxes == (THREE, TWO)
    assert not state.faces.is_open


@pytest.mark.parametrize(
    ("relit", "removed", "then"), [(None, 0, None), (0, 0, None), (1, 0, 0), (0, 1, 0), (1, 1, None)]
)
def test_who_is_relit_alone_stays_so_when_another_is_removed(state, relit, removed, then):
    state.choose_face(relit)
    answered(state, (ONE, TWO))
    face_edits.show(state)
    state.faces.selected = removed
    face_edits.remove(state)
    assert state.photo.face_index == then
    assert state.photo.boxes == ((TWO,) if removed == 0 else (ONE,))
    assert state.faces.selected == -1


def test_only_a_box_that_is_selected_is_removed_and_the_only_one_is_from_the_first(state):
    face_edits.show(state)
    wish = state.photo
    face_edits.remove(state)
    assert state.photo is wish
    face_edits.done(state)
    drop(state, (ONE,))
    answered(state, ())
    face_edits.show(state)
    face_edits.remove(state)
    assert state.photo.boxes == ()


def test_boxes_are_neither_shown_nor_wished_for_of_a_photo_that_is_on_its_way(state):
    state.open_photo(Path("/photos/other.jpg"))
    assert face_edits.is_searching(state)
    assert face_edits.wished_boxes(state) == ()
    face_edits.show(state)
    assert not state.faces.is_open


def test_a_face_that_is_drawn_is_relit_and_selected(state):
    state.choose_face(1)
    answered(state, (ONE, TWO))
    face_edits.show(state)
    drop(state, (ONE, TWO, THREE))
    assert state.photo.face_index is None
    assert state.faces.selected == 2


def test_there_may_be_only_so_many_faces(state):
    face_edits.show(state)
    for count in (32, 33):
        drop(state, (ONE,) * count)
        assert state.photo.boxes == (ONE,) * 32
    assert state.asking.notices[0][1]


def test_choosing_a_face_keeps_the_boxes(state):
    drop(state, (THREE, TWO))
    answered(state, (ONE, TWO))
    state.choose_face(0)
    assert state.photo.boxes == (THREE, TWO)
    assert not face_edits.is_searching(state)


def test_finding_again_shows_nothing_until_it_is_known(state):
    drop(state, (THREE, TWO))
    state.choose_face(1)
    answered(state, ())
    state.faces.selected = 1
    face_edits.find_again(state)
    assert state.photo.face_index is None, "there may be fewer faces then"
    assert state.faces.selected == -1
    assert face_edits.is_searching(state)
    assert face_edits.wished_boxes(state) == ()
    answered(state, (ONE, TWO))
    assert not face_edits.is_searching(state)
    assert face_edits.wished_boxes(state) == (ONE, TWO)


def test_a_photo_in_which_nobody_is_found_asks_for_a_box_and_a_hidden_one_of_boxes_does_not(state):
    state.open_photo(Path("/photos/back.jpg"))
    answered(state, ())
    assert state.faces.is_open
    face_edits.cancel(state)
    assert not state.faces.is_open
    state.open_photo(PLACE)
    answered(state, (ONE,))
    assert not state.faces.is_open


def test_each_drag_is_one_step_with_a_name_and_can_be_undone(state):
    state.snapshot = replace(state.snapshot, light=FakeLight(state))
    state.remember(0.0)
    face_edits.show(state)
    for now_s, boxes in ((0.1, (THREE, TWO)), (0.2, (THREE, TWO, ONE)), (0.3, (THREE, TWO))):
        drop(state, boxes)
        state.remember(now_s)
    assert [step.name for step in state.history.steps] == [
        "Open us.jpg",
        "Resize face 1",
        "Add face 3",
        "Remove face 3",
    ]
    for boxes in ((THREE, TWO, ONE), (THREE, TWO), None):
        state.restore(state.history.undo())
        assert state.photo.boxes == boxes
        assert state.photo.place is state.snapshot.opened.photo


class FakeLight:
    """The light that is wished for, in force."""

    def __init__(self, state):
        self.source = state.light


def test_in_a_queue_every_photo_keeps_its_own_boxes(state):
    other = Path("/photos/others.jpg")
    state.open_photos([PLACE, other])
    answered(state, (ONE, TWO))
    drop(state, (THREE,))
    answered(state, ())
    state.step_photo(1)
    assert state.photo.boxes is None
    answered(state, (TWO,))
    assert portrait_of(state, PLACE).boxes == (THREE,)
    assert portrait_of(state, other).boxes is None
    state.step_photo(-1)
    assert state.photo.boxes == (THREE,)


@pytest.mark.parametrize("end", [lambda state: drop(state, (THREE, TWO)), face_edits.cancel, face_edits.find_again])
def test_the_tool_takes_back_no_photo_that_is_on_its_way(state, end):
    drop(state, (ONE, THREE))
    answered(state, (ONE, THREE))
    face_edits.show(state)
    state.open_photo(Path("/photos/other.jpg"))
    wish = state.photo
    end(state)
    assert state.photo is wish
    assert wish.boxes is None


def test_the_choice_of_faces_is_the_one_asked_for_while_it_is_still_being_relit(state):
    def chosen():
        return [action.name for action in setting_actions(state) if action.group == "Faces" and action.is_on(state)]

    state.choose_face(1)
    assert chosen() == ["Faces: 2"]
    state.choose_face(None)
    assert chosen() == ["Faces: all"]
    state.choose_face(1)
    state.open_photo(Path("/photos/them.jpg"))
    assert chosen() == ["Faces: 2"], "that of the photo that is in sight"
