"""Unsaved work, and the work that others have put into a session's file, is replaced by nothing unasked."""

import json
from dataclasses import replace

import pytest
from live_editor import Editor, unsaved_files

from app.document.document import Document, LightRef, PhotoRef
from app.document.session_file import read_session, write_session
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_photo.brush import BrushStroke


@pytest.fixture
def session(photos):
    """Of the first photo, with a shadow of 0.2."""
    path = photos[0].with_name("a.relight.json")
    write_session(path, Document(PhotoRef(photos[0]), edit=Edit(quality="final", shadow=0.2)))
    return path


@pytest.fixture
def editor(folder, photos, session):
    """Work on the first photo that no file holds, beside a session of it."""
    editor = Editor(folder)
    editor.state.open_photos(photos)
    editor.live()
    editor.state.asking.drop("session")
    editor.state.change(shadow=0.7)
    editor.live()
    yield editor
    editor.deeds.close()


def drop(editor, *paths):
    editor.deeds._take(list(paths))
    editor.live()


def asked(editor):
    return [question.text for question in editor.state.asking.questions]


def kept_shadows(folder):
    return [read_session(path).document.edit.shadow for path in unsaved_files(folder)]


@pytest.mark.parametrize("is_open", [True, False])
def test_a_session_dropped_over_unsaved_work_on_its_photo_waits_for_an_answer(editor, photos, session, folder, is_open):
    if not is_open:
        editor.state.step_photo(1)
        editor.live()
    before = editor.state.document()
    drop(editor, session, photos[1])
    assert asked(editor) == ["The work on a.jpg is not saved, and this would take its place."]
    editor.answer_question("Keep the work")
    assert (editor.state.document(), kept_shadows(folder), asked(editor)) == (before, [0.7], [])
    drop(editor, session, photos[1])
    editor.answer_question("Replace it")
    assert (editor.state.edit.shadow, editor.state.session_path) == (0.2, session)
    assert (editor.state.queue.paths, kept_shadows(folder)) == (tuple(photos), [])


def test_whoever_gives_no_answer_of_his_own_keeps_the_work(editor, session):
    drop(editor, session)
    (question,) = editor.state.asking.questions
    assert question.choices[0][0] == question.calling_off == "Keep the work"


def test_a_light_dropped_with_a_session_waits_with_it(editor, session, tmp_path):
    sky = tmp_path / "sky.hdr"
    drop(editor, session, sky)
    assert editor.state.light.kind == "rig"
    editor.answer_question("Replace it")
    assert (editor.state.light.name, editor.state.edit.shadow) == (str(sky), 0.2)


def test_where_no_work_would_be_lost_a_session_opens_unasked(editor, session):
    editor.state.change(shadow=0.2)
    drop(editor, session)
    assert (asked(editor), editor.state.session_path) == ([], session)
    editor.state.change(shadow=0.4)
    editor.state.asking.wish("save_session")
    editor.live()
    drop(editor, session)
    assert (asked(editor), editor.state.is_unsaved()) == ([], False)


def test_work_on_another_photo_needs_no_answer(editor, session, photos, folder):
    other = photos[1].with_name("b.relight.json")
    write_session(other, Document(PhotoRef(photos[1]), edit=Edit(quality="final", shadow=0.3)))
    drop(editor, other)
    assert (asked(editor), editor.state.edit.shadow, kept_shadows(folder)) == ([], 0.3, [0.7])


def test_restored_work_that_is_not_put_over_newer_work_is_offered_again(editor, folder, photos):
    editor.deeds.close()
    again = Editor(folder)
    again.state.open_photo(photos[0])
    again.live()
    again.state.asking.drop("session")
    again.state.change(shadow=0.9)
    again.live()
    (offer,) = asked(again)
    again.answer_question("Restore")
    again.answer_question("Keep the work")
    assert (asked(again), again.state.edit.shadow) == ([offer], 0.9)
    assert sorted(kept_shadows(folder)) == [0.7, 0.9]
    again.deeds.close()


def come_back_with_settings_of_another(editor):
    """To the first photo, whose own work waits, from the second, where the shadow was set."""
    editor.state.step_photo(1)
    editor.live()
    editor.state.change(shadow=1.7)
    editor.live()
    editor.state.step_photo(-1)
    editor.live()


def test_going_on_with_what_was_left_asks_where_there_is_newer_work(editor):
    come_back_with_settings_of_another(editor)
    editor.state.change(shadow=1.8)
    editor.live()
    editor.answer_question("Continue")
    assert editor.state.edit.shadow == 1.8
    editor.answer_question("Replace it")
    assert editor.state.edit.shadow == 0.7


@pytest.mark.parametrize("wish", ["save_session", "save_session_as"])
def test_saving_the_settings_of_another_photo_asks_where_own_work_waits(editor, session, folder, wish):
    session.unlink()
    come_back_with_settings_of_another(editor)
    editor.state.asking.drop("session")
    editor.state.asking.wish(wish)
    editor.live()
    assert (len(asked(editor)), session.exists(), editor.state.picking) == (1, False, None)
    editor.answer_question("Replace it")
    if wish == "save_session_as":
        editor.state.picking.then([session])
    assert read_session(session).document.edit.shadow == 1.7


def save(editor):
    editor.state.asking.wish("save_session")
    editor.live()


@pytest.fixture
def saved(editor, session):
    """The unsaved work in the session's file, and a change since."""
    drop(editor, session)
    editor.answer_question("Replace it")
    stroke = BrushStroke(((1.23456789012, 2.0),), 3.3333333333333335, True)
    editor.state.photo = replace(editor.state.photo, place=editor.state.snapshot.opened.photo, strokes=(stroke,))
    save(editor)
    editor.state.change(shadow=0.5)
    editor.live()
    return session


@pytest.mark.parametrize(("answer", "there", "beside"), [("Replace", 0.5, None), ("Keep both", 1.5, 0.5)])
def test_what_another_window_has_saved_is_not_replaced_unasked(editor, saved, photos, answer, there, beside):
    write_session(saved, Document(PhotoRef(photos[0]), edit=Edit(quality="final", shadow=1.5)))
    save(editor)
    assert asked(editor) == ["a.relight.json holds other work than it did when it was opened or saved here."]
    assert read_session(saved).document.edit.shadow == 1.5
    editor.answer_question(answer)
    own = saved if beside is None else saved.with_name("a-jpg.relight.json")
    assert read_session(saved).document.edit.shadow == there
    assert read_session(own).document.edit.shadow == 0.5
    assert editor.state.session_path == own


def test_nor_where_the_photo_is_away_by_now(editor, saved, photos):
    write_session(saved, Document(PhotoRef(photos[0]), edit=Edit(quality="final", shadow=1.5)))
    photos[0].unlink()
    save(editor)
    assert len(asked(editor)) == 1
    assert json.loads(saved.read_text())["edit"]["shadow"] == 1.5


def test_nor_is_the_session_of_another_photo_that_was_put_in_its_place(editor, saved, photos):
    save(editor)
    editor.state.step_photo(1)
    editor.live()
    editor.state.asking.wish("save_session_as")
    editor.live()
    editor.state.picking.then([saved])
    editor.answer_question("Replace")
    editor.state.step_photo(-1)
    editor.live()
    assert (editor.state.session_path, asked(editor)) == (saved, [])
    save(editor)
    assert len(asked(editor)) == 1
    assert read_session(saved).document.photo.path == photos[1]


@pytest.mark.parametrize("change", ["nothing", "no photo", "no session", "older", "by hand"])
def test_its_own_file_is_saved_to_unasked_whatever_became_of_the_photo(editor, saved, photos, change):
    content = json.loads(saved.read_text())
    if change == "no photo":
        photos[0].unlink()
    elif change == "no session":
        saved.unlink()
    elif change in ("older", "by hand"):
        content = content | ({"version": 3} if change == "older" else {"unheard of": 1})
        saved.write_text(json.dumps(content))
        editor.state.change(shadow=0.7)
    save(editor)
    assert (asked(editor), json.loads(saved.read_text())["edit"]["shadow"]) == ([], editor.state.edit.shadow)


def test_a_light_that_is_gone_since_does_not_keep_a_session_from_being_saved(editor, session, photos, tmp_path):
    sky = tmp_path / "sky.hdr"
    sky.write_bytes(b"light")
    write_session(session, Document(PhotoRef(photos[0]), LightRef("panorama", str(sky))))
    drop(editor, session)
    editor.answer_question("Replace it")
    sky.unlink()
    editor.state.change(shadow=0.5)
    save(editor)
    assert (asked(editor), json.loads(session.read_text())["edit"]["shadow"]) == ([], 0.5)
