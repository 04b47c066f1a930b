"""Faces and outlines that were corrected in a photo which has another size by the time it is opened again."""

import json
from dataclasses import replace

import live_editor
import numpy as np
import pytest
from corrected_photo import BOXES, CROPPED, HALF, HALF_STROKES, LARGE, SMALL, STROKES, corrected, held
from live_editor import Editor, unsaved_files

from app.document.document import Document, PhotoRef
from app.document.session_file import read_session, write_session
from app.engine.snapshot import OpenPhoto
from app.ui import brush_edits, face_edits
from app.ui.photo_works import portrait_of
from relight_core.imaging.photo import Photo
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_photo.brush import BrushStroke


@pytest.fixture
def sizes(monkeypatch):
    """By path, the size that a photo has when it is read; else a large one."""
    by_path = {}

    def opened(source):
        photo = source.place
        if not isinstance(photo, Photo):
            width, height = by_path.get(source.path, LARGE)
            photo = Photo(np.full((height, width, 3), 0.5, np.float32), path=source.path)
        return OpenPhoto(source, photo, photo.linear.astype(np.float16))

    monkeypatch.setattr(live_editor, "opened_for", opened)
    return by_path


@pytest.fixture
def editor(folder, sizes):
    editor = Editor(folder)
    yield editor
    editor.deeds.close()


@pytest.fixture
def session(photos):
    """A session of the first photo, whose faces and outline were corrected when it was large."""
    path = photos[0].with_name("a.relight.json")
    write_session(path, Document(corrected(photos[0]), edit=Edit(quality="final", shadow=0.5)))
    return path


def take(editor, path):
    editor.deeds._take([path])
    editor.live()


def change_another(editor, state, photos):
    """Open the second photo, and work on it."""
    take(editor, photos[1])
    state.change(shadow=0.1)
    editor.live()


def opened(editor, session):
    take(editor, session)
    editor.state.asking.questions.clear()
    return editor.state


def save(editor):
    editor.state.asking.wish("save_session")
    editor.live()


def told(editor):
    return [text for text, is_error in editor.said if "when it was worked on" in text and is_error]


def test_a_session_s_faces_and_outline_follow_a_photo_that_was_exported_again_at_half_size(
    editor, sizes, session, photos
):
    sizes[photos[0]] = SMALL
    state = opened(editor, session)
    assert held(state.document().photo) == (1, HALF, HALF_STROKES, SMALL)
    assert face_edits.wished_boxes(state) == HALF
    assert [line.partition("; ")[2] for line in told(editor)] == [
        "scaled to that: boxes of faces, strokes of the outline"
    ]
    assert state.session_path == session
    assert read_session(session).document.photo == corrected(photos[0])
    save(editor)
    assert held(read_session(session).document.photo) == (1, HALF, HALF_STROKES, SMALL)
    assert not state.is_unsaved()


def test_what_a_session_has_no_place_for_in_a_cropped_photo_stays_in_its_file_until_the_user_agrees(
    editor, sizes, session, photos
):
    sizes[photos[0]] = CROPPED
    state = opened(editor, session)
    assert held(state.document().photo) == (None, None, (), CROPPED)
    assert state.edit.shadow == 0.5
    assert len(told(editor)) == 1
    assert "left out: boxes of faces" in told(editor)[0]
    before = session.read_bytes()
    save(editor)
    assert [question.key for question in state.asking.questions] == [f"replace {session}"]
    assert session.read_bytes() == before


@pytest.mark.parametrize("kept", ["no size", "the same size"])
def test_faces_and_outlines_stay_where_they_are_in_a_photo_of_the_same_size_or_of_an_older_session(
    editor, session, photos, kept
):
    if kept == "no size":
        content = json.loads(session.read_text())
        del content["photo_size"]
        session.write_text(json.dumps(content | {"version": 5}))
    state = opened(editor, session)
    assert held(state.document().photo) == (1, BOXES, STROKES, LARGE)
    assert told(editor) == []
    assert not state.is_unsaved()


def test_a_session_keeps_the_size_of_its_photo(editor, photos):
    take(editor, photos[0])
    save(editor)
    assert json.loads(photos[0].with_name("a.relight.json").read_text())["photo_size"] == {"width": 80, "height": 60}


def test_what_is_corrected_in_a_resized_photo_is_kept_in_its_own_pixels(editor, sizes, session, photos):
    sizes[photos[0]] = SMALL
    state = opened(editor, session)
    face_edits.find_again(state)
    editor.live()
    brush_edits.begin(state, (7.0, 8.0), 2.0, adds=False)
    brush_edits.lift(state)
    editor.live()
    strokes = (*HALF_STROKES, BrushStroke(((7.0, 8.0),), 2.0, False))
    assert held(state.document().photo) == (None, None, strokes, SMALL)
    assert len(told(editor)) == 1


def choose(state):
    state.choose_face(1)
    return 1, None, ()


def draw_boxes(state):
    face_edits.show(state)
    state.faces.moving = HALF
    face_edits.finish_drag(state)
    return None, HALF, ()


def paint(state):
    brush_edits.begin(state, (7.0, 8.0), 2.0, adds=False)
    brush_edits.lift(state)
    return None, None, (BrushStroke(((7.0, 8.0),), 2.0, False),)


@pytest.mark.parametrize("size", [SMALL, CROPPED])
@pytest.mark.parametrize("correct", [choose, draw_boxes, paint])
def test_what_is_corrected_first_after_a_photo_was_resized_is_where_it_was_drawn(editor, sizes, photos, size, correct):
    path = photos[0].with_name("a.relight.json")
    write_session(path, Document(PhotoRef(photos[0], size=LARGE)))
    sizes[photos[0]] = size
    state = opened(editor, path)
    assert told(editor) == []
    expected = (*correct(state), size)
    editor.live()
    assert held(state.document().photo) == expected


def test_giving_up_boxes_that_opened_by_themselves_brings_none_back_that_were_left_out(editor, sizes, session, photos):
    sizes[photos[0]] = CROPPED
    state = opened(editor, session)
    assert state.faces.is_open
    face_edits.cancel(state)
    editor.live()
    assert held(state.document().photo) == (None, None, (), CROPPED)


def test_undo_and_redo_go_on_past_the_opening_of_a_resized_photo(editor, sizes, session, photos):
    sizes[photos[0]] = SMALL
    take(editor, photos[1])
    state = opened(editor, session)
    state.change(shadow=0.2)
    editor.live()
    names = [step.name for step in state.history.steps]
    for _ in range(2):
        state.restore(state.history.undo())
        editor.live()
    assert state.photo.path == photos[1]
    for _ in range(2):
        state.restore(state.history.redo())
        editor.live()
    assert [step.name for step in state.history.steps] == names
    assert (held(state.document().photo), state.edit.shadow) == ((1, HALF, HALF_STROKES, SMALL), 0.2)


def left_and_resized(editor, sizes, session, photos):
    """The state of an editor in which the session's photo was changed and left for another, and is smaller now."""
    state = opened(editor, session)
    state.change(shadow=0.2)
    editor.live()
    take(editor, photos[1])
    sizes[photos[0]] = SMALL
    return state


def test_undo_back_to_a_photo_that_was_resized_meanwhile_keeps_the_steps_after_it(editor, sizes, session, photos):
    state = left_and_resized(editor, sizes, session, photos)
    names = [step.name for step in state.history.steps]
    for _ in range(2):
        state.restore(state.history.undo())
        editor.live()
    assert (held(state.document().photo), state.edit.shadow) == ((1, HALF, HALF_STROKES, SMALL), 0.5)
    assert [step.name for step in state.history.steps] == names
    assert state.history.can_redo
    assert len(told(editor)) == 1


def test_a_step_of_a_resized_photo_comes_back_from_another_photo_without_a_question(editor, sizes, session, photos):
    state = left_and_resized(editor, sizes, session, photos)
    state.restore(state.history.go(0))
    editor.live()
    assert (held(state.document().photo), state.edit.shadow) == ((1, HALF, HALF_STROKES, SMALL), 0.5)
    assert state.asking.questions == []
    assert state.session_path == session


@pytest.mark.parametrize("size", [SMALL, CROPPED])
def test_a_photo_of_the_queue_that_was_resized_while_another_was_open_comes_back_so(
    editor, sizes, session, photos, size
):
    state = opened(editor, session)
    state.queue = replace(state.queue, paths=tuple(photos), at=0)
    state.step_photo(1)
    editor.live()
    sizes[photos[0]] = size
    state.step_photo(-1)
    editor.live()
    expected = (1, HALF, HALF_STROKES, SMALL) if size == SMALL else (None, None, (), CROPPED)
    assert held(state.document().photo) == expected
    assert held(portrait_of(state, photos[0])) == expected
    assert state.session_path == (session if size == SMALL else None)
    assert state.is_unsaved()
    assert len(told(editor)) == 1


def test_the_question_about_a_photo_s_own_work_waits_though_the_photo_was_resized(editor, sizes, session, photos):
    state = opened(editor, session)
    change_another(editor, state, photos)
    sizes[photos[0]] = SMALL
    take(editor, photos[0])
    assert [question.key for question in state.asking.questions] == ["session"]
    editor.answer_question("Continue")
    assert (held(state.document().photo), state.edit.shadow) == ((1, HALF, HALF_STROKES, SMALL), 0.5)


def test_a_photo_that_is_dropped_again_after_it_was_resized_has_its_faces_where_they_are(editor, sizes, photos):
    take(editor, photos[0])
    editor.state.photo = replace(editor.state.photo.on(editor.state.snapshot.opened.photo), boxes=BOXES)
    editor.live()
    sizes[photos[0]] = SMALL
    take(editor, photos[0])
    assert held(editor.state.document().photo) == (None, HALF, (), SMALL)
    assert len(told(editor)) == 1


def test_a_photo_of_an_older_session_is_known_by_the_size_that_it_had_when_it_was_opened(
    editor, sizes, session, photos
):
    content = json.loads(session.read_text())
    session.write_text(json.dumps(content | {"photo_size": None}))
    state = opened(editor, session)
    sizes[photos[0]] = SMALL
    take(editor, photos[0])
    assert held(state.document().photo) == (1, HALF, HALF_STROKES, SMALL)


def test_a_cropped_photo_that_is_dropped_again_keeps_its_session_s_file_until_the_user_agrees(
    editor, sizes, session, photos
):
    state, before = opened(editor, session), session.read_bytes()
    sizes[photos[0]] = CROPPED
    take(editor, photos[0])
    assert held(state.document().photo) == (None, None, (), CROPPED)
    state.asking.questions.clear()
    save(editor)
    assert [question.key for question in state.asking.questions] == [f"replace {session}"]
    assert session.read_bytes() == before


@pytest.mark.parametrize("size", [SMALL, CROPPED])
def test_a_photo_that_was_only_looked_at_has_no_unsaved_work_once_it_was_resized(editor, sizes, session, photos, size):
    state = opened(editor, session)
    change_another(editor, state, photos)
    take(editor, photos[0])
    editor.answer_question("Start afresh")
    assert not state.is_unsaved()
    sizes[photos[0]] = size
    take(editor, photos[0])
    assert not state.is_unsaved()


def test_work_that_waits_for_an_answer_while_its_photo_is_cropped_is_saved_over_nothing_unasked(
    editor, sizes, session, photos
):
    state, before = opened(editor, session), session.read_bytes()
    change_another(editor, state, photos)
    take(editor, photos[0])
    sizes[photos[0]] = CROPPED
    take(editor, photos[0])
    editor.answer_question("Continue")
    assert (held(state.document().photo), state.edit.shadow) == ((None, None, (), CROPPED), 0.5)
    save(editor)
    assert session.read_bytes() == before


def test_work_that_a_crash_left_fits_a_photo_that_was_resized_since(editor, sizes, session, folder, photos):
    state = opened(editor, session)
    state.change(shadow=0.2)
    editor.live()
    editor.deeds.close()
    assert len(unsaved_files(folder)) == 1
    sizes[photos[0]] = SMALL
    again = Editor(folder)
    again.live()
    again.answer_question("Restore")
    assert (held(again.state.document().photo), again.state.edit.shadow) == ((1, HALF, HALF_STROKES, SMALL), 0.2)
    assert [question.key for question in again.state.asking.questions] == []
    assert len(told(again)) == 1
    again.deeds.close()
