"""A photo that comes back has its own faces, and its own work is offered and replaced by nothing unasked."""

from dataclasses import replace
from pathlib import Path

import pytest
from live_editor import Editor, unsaved_files
from opened_things import SKY, opened_for, refuse_light, refuse_photo

from app.document.document import Document, PhotoRef
from app.document.session_file import read_session, write_session
from app.engine.sources import PhotoSource
from app.ui.photo_works import is_worked_on, note_saved, portrait_of, session_of_photo, unsaved_work, work_left
from relight_core.face.find import FaceBox
from relight_core.pipeline.edit import Edit

BOXES = (FaceBox(0, 0, 2, 2), FaceBox(2, 2, 4, 4))


@pytest.fixture
def editor(folder, photos):
    """Both photos in the queue; of the first the faces are corrected and the second is relit alone."""
    editor = Editor(folder)
    editor.state.open_photos(photos)
    editor.live()
    editor.state.photo = PhotoSource(editor.state.snapshot.opened.photo, None, BOXES)
    editor.live()
    editor.state.choose_face(1)
    editor.live()
    yield editor
    editor.deeds.close()


def drop(editor, photo, **then):
    editor.deeds._take([photo])
    editor.live()
    if then:
        editor.state.change(**then)
        editor.live()


def save(editor):
    editor.state.asking.wish("save_session")
    editor.live()


def open_session(editor, photo, shadow):
    """Ask for a session of a photo, which is not read yet."""
    path = photo.with_suffix(".relight.json")
    write_session(path, Document(PhotoRef(photo), edit=Edit(quality="final", shadow=shadow)))
    editor.state.open_session(read_session(path).document, path)


def faces(editor):
    return editor.state.photo.face_index, editor.state.photo.boxes


def questions(editor):
    return [question.key for question in editor.state.asking.questions]


def kept_shadows(folder):
    return sorted(read_session(path).document.edit.shadow for path in unsaved_files(folder))


@pytest.fixture
def saved(editor, photos):
    """The first photo has a session with a shadow of 0.2, and is left for the second, which gets one of 1.7."""
    editor.state.change(shadow=0.2)
    save(editor)
    drop(editor, photos[1], shadow=1.7)
    return photos[0].with_name("a.relight.json")


def test_its_session_is_not_replaced_by_the_sliders_of_another_photo(editor, photos, saved):
    drop(editor, photos[0])
    assert faces(editor) == (1, BOXES)
    assert is_worked_on(editor.state, photos[0])
    save(editor)
    assert read_session(saved).document.edit.shadow == 0.2
    assert f"replace {saved}" in questions(editor)


def test_what_is_set_on_it_instead_of_going_on_is_its_work_from_then_on(editor, photos, saved):
    drop(editor, photos[0], shadow=0.9)
    drop(editor, photos[1], shadow=1.3)
    drop(editor, photos[0])
    assert work_left(editor.state, photos[0]).edit.shadow == 0.9


def test_work_that_was_left_by_going_back_in_the_history_waits_when_its_photo_comes_back(editor, photos, saved):
    state = editor.state
    state.restore(state.history.go(0))
    editor.live()
    assert state.photo.path == photos[0]
    drop(editor, photos[1])
    assert work_left(state, photos[1]).edit.shadow == 1.7


def test_nor_while_it_is_still_being_read(editor, photos, saved):
    editor.deeds._take([photos[0]])
    editor.state.asking.wish("save_session")
    editor.deeds.act(editor.now_s)
    assert read_session(saved).document.edit.shadow == 0.2
    editor.answer_question("Replace")
    assert read_session(saved).document.edit.shadow == 1.7
    assert editor.state.session_path == saved, "what was agreed to is its session from then on"
    assert questions(editor) == []


def test_a_light_that_can_not_be_had_takes_no_session_file_away_from_work_under_another(editor, photos, saved):
    drop(editor, photos[0])
    editor.answer_question("Continue")
    editor.state.choose_light(SKY)
    refuse_light(editor.state)
    assert editor.state.session_path == saved


def test_its_session_is_offered_and_goes_on(editor, photos, saved):
    drop(editor, photos[0])
    assert questions(editor) == ["session"]
    editor.answer_question("Continue")
    assert editor.state.edit.shadow == 0.2
    assert not editor.state.is_unsaved()
    editor.state.change(shadow=0.3)
    save(editor)
    assert read_session(saved).document.edit.shadow == 0.3


def test_with_the_settings_it_was_left_with_it_goes_on_unasked(editor, photos, saved):
    editor.state.change(shadow=0.2)
    drop(editor, photos[0])
    assert questions(editor) == []
    assert editor.state.session_path == saved
    assert not editor.state.is_unsaved()
    assert is_worked_on(editor.state, photos[0]), "that it is saved makes it no less its own"


@pytest.mark.parametrize("way", ["dropped", "undone"])
def test_that_session_is_the_one_to_save_to_while_it_is_still_being_read(editor, photos, saved, way):
    state = editor.state
    if way == "dropped":
        state.change(shadow=0.2)
        editor.deeds._take([photos[0]])
    else:
        state.restore(state.history.go(0))
    path, document = session_of_photo(state)
    assert (path, document.edit.shadow) == (saved, 0.2)
    assert unsaved_work(state, photos[0]) is None


@pytest.mark.parametrize("way", ["session", "history"])
def test_a_photo_that_is_still_being_read_has_the_work_that_it_is_coming_with(editor, photos, way):
    state = editor.state
    if way == "session":
        open_session(editor, photos[1], 0.4)
    else:
        drop(editor, photos[1], shadow=1.7)
        drop(editor, photos[0])
        state.restore(state.history.go([step.name for step in state.history.steps].index("Shadow 1.70") - 1))
    assert (state.photo.path, state.is_at_work()) == (photos[1], False)
    assert is_worked_on(state, photos[1])
    assert work_left(state, photos[1]).edit.shadow == (0.4 if way == "session" else 1.0)


def test_a_session_that_is_opened_has_nothing_of_the_work_that_waits_for_another_photo(editor, photos):
    editor.state.change(shadow=0.2)
    drop(editor, photos[1], shadow=1.7)
    drop(editor, photos[0])
    assert work_left(editor.state, photos[0]).edit.shadow == 0.2
    open_session(editor, photos[1], 0.4)
    editor.live()
    assert work_left(editor.state, photos[1]).edit.shadow == 0.4


def test_a_photo_that_was_only_looked_at_comes_back_with_what_is_set_now_and_no_question(editor, photos):
    drop(editor, photos[1])
    drop(editor, photos[0], shadow=1.7)
    editor.deeds._take([photos[1]])
    assert work_left(editor.state, photos[1]).edit.shadow == 1.7
    editor.live()
    assert (editor.state.edit.shadow, questions(editor)) == (1.7, [])


def test_a_photo_that_was_given_up_before_it_was_read_has_no_work_nor_the_session_of_another(editor, photos):
    editor.state.change(shadow=0.2)
    save(editor)
    editor.state.step_photo(1)
    editor.state.step_photo(-1)
    editor.live()
    assert work_left(editor.state, photos[1]) is None
    assert unsaved_work(editor.state, photos[1]) is None


def test_a_photo_that_comes_when_another_is_wanted_by_then_is_opened_as_itself(editor, photos):
    editor.state.step_photo(1)
    coming = opened_for(editor.state.photo)
    editor.state.step_photo(-1)
    editor.state.accept(replace(editor.state.snapshot, opened=coming))
    assert editor.state.kept.photo.path == photos[1]


def test_what_was_set_after_saving_began_is_not_lost_when_that_ends_beside_another_photo(editor, photos, saved):
    as_saved = read_session(saved).document
    note_saved(editor.state, saved, replace(as_saved, edit=replace(as_saved.edit, shadow=0.1)))
    assert unsaved_work(editor.state, photos[0]).edit.shadow == 0.2
    assert work_left(editor.state, photos[0]).edit.shadow == 0.2


def test_unsaved_work_stays_for_recovery_and_is_offered_however_often_it_is_passed(editor, photos, folder):
    editor.state.change(shadow=0.2)
    editor.live()
    editor.state.step_photo(1)
    editor.live()
    editor.state.change(shadow=1.7)
    editor.live()
    for _ in range(2):
        editor.state.step_photo(-1)
        editor.live()
        assert (editor.state.edit.shadow, faces(editor)) == (1.7, (1, BOXES))
        assert questions(editor) == ["session"]
        assert kept_shadows(folder) == [0.2, 1.7]
        editor.state.step_photo(1)
        editor.live()
        assert questions(editor) == []
    drop(editor, photos[0])
    editor.answer_question("Continue")
    assert editor.state.edit.shadow == 0.2
    assert editor.state.is_unsaved()
    assert kept_shadows(folder) == [0.2, 1.7]


def test_who_starts_afresh_has_no_work_on_it_any_more(editor, photos, folder):
    editor.state.change(shadow=0.2)
    drop(editor, photos[1], shadow=1.7)
    drop(editor, photos[0])
    editor.answer_question("Start afresh")
    assert (editor.state.edit.shadow, faces(editor)) == (1.7, (1, BOXES))
    assert not editor.state.is_unsaved()
    assert kept_shadows(folder) == [1.7]


def test_opening_the_open_photo_again_loses_no_unsaved_faces(editor, photos, folder):
    assert len(unsaved_files(folder)) == 1
    drop(editor, photos[0])
    assert faces(editor) == (1, BOXES)
    assert editor.state.is_unsaved()
    (path,) = unsaved_files(folder)
    assert read_session(path).document.photo.boxes == BOXES
    assert questions(editor) == []


def test_asking_who_is_relit_changes_nothing_and_needs_no_earlier_question(editor, photos):
    editor.state.step_photo(1)
    editor.live()
    editor.state.choose_face(0)
    first, second = (portrait_of(editor.state, path) for path in photos)
    assert (first.face_index, first.boxes) == (1, BOXES)
    assert (second.face_index, second.boxes) == (0, None)


def test_a_photo_that_changed_on_disk_so_that_its_boxes_fit_no_more_opens_as_found(editor, photos):
    drop(editor, photos[1])
    editor.deeds._take([photos[0]])
    refuse_photo(editor.state)
    drop(editor, photos[0])
    assert faces(editor) == (None, None)
    editor.answer_question("Continue")
    assert faces(editor) == (1, BOXES)


def test_undo_goes_back_to_any_step_on_the_photo_with_its_session(editor, photos, saved):
    names = [step.name for step in editor.state.history.steps]
    editor.state.restore(editor.state.history.go(names.index("Shadow 0.20") - 1))
    editor.live()
    assert (editor.state.photo.path, editor.state.edit.shadow) == (photos[0], 1.0)
    assert editor.state.session_path == saved
    assert editor.state.is_unsaved()
    assert questions(editor) == []


def test_a_photo_is_the_same_however_its_path_is_written(editor, photos, folder, monkeypatch):
    editor.deeds.close()
    monkeypatch.chdir(photos[0].parent)
    again = Editor(folder)
    again.state.asking.questions.clear()
    drop(again, Path("a.jpg"), shadow=0.2)
    save(again)
    drop(again, photos[1])
    drop(again, photos[0])
    assert again.state.session_path == photos[0].with_name("a.relight.json")
    assert not again.state.is_unsaved()
    assert questions(again) == []
    again.deeds.close()


def test_work_as_it_was_left_is_the_photos_own_also_where_it_waits(editor, photos):
    def shadows():
        return [work and work.edit.shadow for work in (work_left(editor.state, photo) for photo in photos)]

    editor.state.change(shadow=0.2)
    editor.live()
    assert shadows() == [0.2, None]
    drop(editor, photos[1], shadow=1.7)
    assert shadows() == [0.2, 1.7]
    assert work_left(editor.state, photos[0]).photo.boxes == BOXES
    editor.deeds._take([photos[0]])
    assert shadows() == [0.2, 1.7], "while it is still being read"
    editor.live()
    assert (editor.state.edit.shadow, shadows()) == (1.7, [0.2, 1.7])
    editor.answer_question("Start afresh")
    assert shadows() == [1.7, 1.7]
