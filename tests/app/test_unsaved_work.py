"""Unsaved work stays unsaved, and kept for recovery, while other photos come and go."""

import pytest
from live_editor import Editor, unsaved_files
from opened_things import photo_files, refuse_photo

from app.document.session_file import read_session
from app.engine.sources import LightSource


@pytest.fixture
def editor(folder, photos):
    editor = Editor(folder)
    editor.state.open_photos(photos)
    editor.live()
    yield editor
    editor.deeds.close()


def offered(folder):
    again = Editor(folder)
    again.deeds.close()
    return [question.text for question in again.state.asking.questions]


def test_the_next_photo_of_a_queue_leaves_the_work_on_this_one_for_recovery(editor, folder):
    editor.state.change(shadow=0.5)
    editor.live()
    editor.state.step_photo(1)
    editor.live()
    assert not editor.state.is_unsaved()
    assert len(unsaved_files(folder)) == 1
    editor.state.step_photo(-1)
    editor.live()
    assert editor.state.is_unsaved()
    editor.state.step_photo(1)
    editor.live()
    editor.deeds.close()
    (text,) = offered(folder)
    assert "a.jpg" in text


def test_a_change_just_before_the_next_photo_is_kept_too(editor, folder):
    editor.state.change(shadow=0.5)
    editor.live(1)
    assert unsaved_files(folder) == []
    assert editor.deeds.waiting, "the window has to wake for it"
    editor.state.step_photo(1)
    editor.live(1)
    assert len(unsaved_files(folder)) == 1


def test_a_change_in_the_frame_in_which_the_next_photo_is_asked_for_is_kept_too(editor, folder):
    editor.state.change(shadow=0.5)
    editor.state.step_photo(1)
    editor.live()
    editor.deeds.close()
    (text,) = offered(folder)
    assert text.startswith("Your work on a.jpg")


def test_work_on_two_photos_is_kept_for_both(editor, folder):
    for shadow in (0.5, 0.6):
        editor.state.change(shadow=shadow)
        editor.live()
        editor.state.step_photo(1)
        editor.live()
    assert len(unsaved_files(folder)) == 2
    editor.deeds.close()
    assert sorted(text.split(",")[0] for text in offered(folder)) == ["Your work on a.jpg", "Your work on b.jpg"]


def test_undoing_a_stray_drop_goes_on_with_the_session_and_its_unsaved_work(editor, photos, folder, tmp_path):
    place = tmp_path / "work.relight.json"
    editor.state.asking.wish("save_session_as")
    editor.live()
    editor.state.picking.then([place])
    editor.state.change(shadow=0.5)
    editor.live()
    editor.state.open_photos(photos[1:])
    editor.live()
    assert editor.state.session_path is None
    editor.state.restore(editor.state.history.undo())
    editor.live()
    assert (editor.state.photo.path, editor.state.edit.shadow) == (photos[0], 0.5)
    assert editor.state.session_path == place
    assert editor.state.is_unsaved()
    assert len(unsaved_files(folder)) == 1
    editor.state.asking.wish("save_session")
    editor.live()
    assert read_session(place).document.edit.shadow == 0.5
    assert not editor.state.is_unsaved()
    assert unsaved_files(folder) == []


def test_a_photo_that_is_refused_is_no_work(editor, folder, tmp_path):
    editor.state.change(shadow=0.5)
    editor.live()
    editor.state.open_photo(tmp_path / "bad.jpg")
    for _ in range(5):
        editor.now_s += 1.0
        editor.deeds.act(editor.now_s)
    refuse_photo(editor.state)
    editor.live()
    assert editor.state.is_unsaved()
    assert len(unsaved_files(folder)) == 1


def test_saving_while_the_next_photo_is_read_leaves_the_session_of_this_one_alone(editor, photos):
    editor.state.change(shadow=0.5)
    editor.state.asking.wish("save_session")
    editor.live()
    editor.state.change(shadow=0.6)
    editor.state.step_photo(1)
    editor.state.asking.wish("save_session")
    editor.deeds.act(editor.now_s)
    first, second = (read_session(path.with_suffix(".relight.json")).document for path in photos)
    assert (first.photo.path, first.edit.shadow) == (photos[0], 0.5)
    assert (second.photo.path, second.edit.shadow) == (photos[1], 0.6)
    editor.live()
    assert editor.state.session_path == photos[1].with_suffix(".relight.json")
    assert not editor.state.is_unsaved()


def test_what_is_replaced_after_a_question_is_the_work_that_was_asked_about(editor, photos, folder):
    place = photos[0].with_suffix(".relight.json")
    editor.state.asking.wish("save_session")
    editor.live()
    editor.state.session_path = None
    editor.state.change(shadow=0.5)
    editor.state.asking.wish("save_session")
    editor.live()
    editor.state.step_photo(1)
    editor.live()
    editor.answer_question("Replace")
    document = read_session(place).document
    assert (document.photo.path, document.edit.shadow) == (photos[0], 0.5)
    assert editor.state.session_path is None, "the photo that is open has no session"
    assert unsaved_files(folder) == []
    editor.state.step_photo(-1)
    editor.live()
    assert editor.state.session_path == place
    assert not editor.state.is_unsaved()


def leave_work(editor):
    """Work on the first photo that was not saved; the editor that comes next."""
    editor.state.change(shadow=0.5)
    editor.live()
    editor.deeds.close()


def test_restored_work_whose_photo_is_refused_is_kept_and_offered_again(editor, folder, photos):
    leave_work(editor)
    again = Editor(folder)
    (question,) = again.state.asking.questions
    again.state.asking.drop(question.key)
    dict(question.choices)["Restore"]()
    refuse_photo(again.state)
    again.state.open_photo(photos[1])
    again.live()
    assert [asked.text for asked in again.state.asking.questions] == [question.text]
    again.state.change(shadow=0.7)
    again.live()
    again.deeds.close()
    assert sorted(text.split(",")[0] for text in offered(folder)) == ["Your work on a.jpg", "Your work on b.jpg"]


def test_of_two_works_restored_at_once_the_first_is_offered_again(editor, folder, photos):
    editor.state.change(shadow=0.5)
    editor.live()
    editor.state.step_photo(1)
    editor.live()
    editor.state.change(shadow=0.7)
    editor.live()
    editor.deeds.close()
    again = Editor(folder)
    first, second = again.state.asking.questions
    for question in (first, second):
        again.state.asking.drop(question.key)
        dict(question.choices)["Restore"]()
    again.live()
    assert again.state.photo.path.name in second.text
    assert [asked.text for asked in again.state.asking.questions] == [first.text]
    again.answer_question("Restore")
    assert again.state.photo.path.name in first.text
    again.deeds.close()
    assert len(offered(folder)) == 2, "neither is saved yet"


def test_restoring_leaves_unsaved_work_on_another_photo_for_recovery(editor, folder, photos):
    leave_work(editor)
    again = Editor(folder)
    again.state.open_photo(photos[1])
    again.live()
    again.state.change(shadow=0.7)
    again.live()
    again.answer_question("Restore")
    assert again.state.photo.path == photos[0]
    again.deeds.close()
    assert sorted(text.split(",")[0] for text in offered(folder)) == ["Your work on a.jpg", "Your work on b.jpg"]


@pytest.mark.parametrize("save", [True, False])
def test_work_restored_and_at_once_saved_or_left_is_not_offered_twice(editor, folder, save):
    leave_work(editor)
    again = Editor(folder)
    assert len(again.state.asking.questions) == 1
    again.answer_question("Restore", 1)
    if save:
        again.state.asking.wish("save_session")
        again.live(1)
    again.deeds.close()
    assert len(offered(folder)) == (0 if save else 1)


def test_work_whose_panorama_is_out_of_reach_is_told_and_stays(editor, folder, tmp_path):
    sky = tmp_path / "sky.hdr"
    sky.write_bytes(b"light")
    editor.state.choose_light(LightSource("panorama", str(sky)))
    leave_work(editor)
    sky.rename(tmp_path / "away.hdr")
    again = Editor(folder)
    again.live(1)
    again.deeds.close()
    (line, is_error), *_ = again.said
    assert is_error
    assert "sky.hdr is not there" in line
    (tmp_path / "away.hdr").rename(sky)
    assert len(offered(folder)) == 1


def test_restored_work_is_kept_until_it_takes_the_place_of_other_work_on_that_photo(editor, folder, photos):
    leave_work(editor)
    again = Editor(folder)
    again.state.open_photo(photos[0])
    again.live()
    again.state.change(shadow=0.7)
    again.live()
    assert len(again.state.asking.questions) == 1
    again.answer_question("Restore")
    again.answer_question("Replace it", 1)
    held = [read_session(path).document.edit.shadow for path in unsaved_files(folder)]
    assert 0.5 in held
    again.live()
    assert [read_session(path).document.edit.shadow for path in unsaved_files(folder)] == [0.5]
    again.deeds.close()


def test_what_a_slider_was_dragged_to_is_kept_when_a_key_opens_the_next_photo_meanwhile(editor, folder):
    editor.state.hand_on_control = True
    editor.state.change(shadow=0.3)
    editor.live(1)
    editor.state.step_photo(1)
    editor.live()
    editor.state.hand_on_control = False
    editor.live()
    editor.deeds.close()
    (text,) = offered(folder)
    assert text.startswith("Your work on a.jpg")


@pytest.mark.parametrize(("answer", "kept"), [("Restore", 5), ("Discard", 0)])
def test_all_unsaved_work_is_offered_three_at_a_time(folder, tmp_path, answer, kept):
    names = [f"{number}.jpg" for number in range(5)]
    for photo in photo_files(tmp_path, *names):
        editor = Editor(folder)
        editor.state.open_photo(photo)
        editor.live()
        editor.state.change(shadow=0.5)
        editor.deeds.close()
    again = Editor(folder)
    asked = []
    while again.state.asking.questions:
        assert len(again.state.asking.questions) <= 3
        asked.append(again.state.asking.questions[0].text.split(",")[0].removeprefix("Your work on "))
        again.answer_question(answer)
    again.deeds.close()
    assert sorted(asked) == names
    assert len(unsaved_files(folder)) == kept


def test_restored_work_that_can_not_be_kept_anew_stays_where_it_is_which_is_told_once(editor, folder, monkeypatch):
    def refuses(*_):
        raise OSError("no space left")

    leave_work(editor)
    again = Editor(folder)
    monkeypatch.setattr("app.document.autosave.KeptFile.save", refuses)
    again.answer_question("Restore")
    again.live()
    again.deeds.close()
    assert again.said == [("Unsaved work is not kept for recovery: no space left", True)]
    assert len(unsaved_files(folder)) == 1


@pytest.mark.parametrize("is_full", [False, True])
def test_a_window_that_closes_just_after_a_change_knows_whether_that_is_kept(editor, folder, monkeypatch, is_full):
    def refuses(*_):
        raise OSError("no space left")

    if is_full:
        monkeypatch.setattr("app.document.autosave.KeptFile.save", refuses)
    editor.state.change(shadow=0.5)
    assert editor.deeds.would_lose_work() is is_full
    assert editor.deeds.keep_now() is not is_full
    assert len(unsaved_files(folder)) == (0 if is_full else 1)


def test_that_work_is_not_kept_is_told_and_no_more_once_it_is(editor, folder, monkeypatch):
    def refuses(*_):
        raise OSError("no space left")

    with monkeypatch.context() as full:
        full.setattr("app.document.autosave.KeptFile.save", refuses)
        editor.state.change(shadow=0.5)
        for seconds in (5, 1):
            editor.live(seconds)
    assert editor.said == [("Unsaved work is not kept for recovery: no space left", True)]
    for seconds in (20, 1):
        editor.live(seconds)
    assert (len(editor.said), len(unsaved_files(folder))) == (1, 1)
