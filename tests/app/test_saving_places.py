"""Which place is offered for a session or a light, and what is asked before it is written there."""

from pathlib import Path

import pytest
from live_editor import Editor

from app.document.light_file import read_light
from app.document.session_file import read_session
from app.engine.sources import LightSource
from app.ui.asking import Asking, Question
from app.window.offers import saved_session_offer
from app.window.replacing import write_or_ask


@pytest.fixture
def editor(folder, photos):
    editor = Editor(folder)
    editor.state.open_photo(photos[0])
    editor.live()
    yield editor
    editor.deeds.close()


def asked(editor, wish):
    editor.state.asking.wish(wish)
    editor.live(1)
    return editor.state.picking


@pytest.mark.parametrize(
    ("name", "beside"),
    [("mine.light.json", "mine-2.light.json"), ("Mine.LIGHT.json", "Mine-2.LIGHT.json"), ("a.b.json", "a.b-2.json")],
)
def test_a_light_that_is_kept_beside_another_ends_like_a_light(editor, tmp_path, name, beside):
    place = tmp_path / name
    place.touch()
    asked(editor, "save_light").then([place])
    editor.answer_question("Keep both")
    assert read_light(tmp_path / beside).light.name == "rembrandt"
    assert place.read_bytes() == b""


def test_a_session_that_was_saved_elsewhere_is_offered_that_place_and_saved_there_unasked(editor, photos, tmp_path):
    place = tmp_path / "work" / "mine.relight.json"
    place.parent.mkdir()
    assert asked(editor, "save_session_as").start == photos[0].with_name("a.relight.json")
    editor.state.picking.then([place])
    editor.state.change(shadow=0.25)
    assert asked(editor, "save_session_as").start == place
    editor.state.picking.then([place])
    assert editor.state.asking.questions == []
    assert read_session(place).document.edit.shadow == 0.25


@pytest.mark.parametrize(
    ("wish", "name"), [("save_light", "mine.light.json"), ("save_session_as", "mine.relight.json")]
)
def test_no_file_of_another_kind_is_replaced_even_where_that_was_agreed_to(editor, tmp_path, wish, name):
    place = tmp_path / name
    place.write_text('{"of": "another program"}')
    asked(editor, wish).then([place])
    editor.answer_question("Replace")
    assert place.read_text() == '{"of": "another program"}'
    line, is_error = editor.said[-1]
    assert is_error
    assert "relight replaces only its own files, choose another name" in line


def test_a_light_is_offered_its_name_beside_the_photo(editor, photos):
    editor.state.choose_light(LightSource("rig", "golden-hour"))
    assert asked(editor, "save_light").start == photos[0].with_name("golden-hour.light.json")


def test_the_photo_s_own_light_is_not_saved_alone(editor):
    editor.state.choose_light(LightSource("own"))
    assert asked(editor, "save_light") is None
    ((line, is_error),) = editor.said
    assert is_error
    assert "save the session instead" in line


@pytest.mark.parametrize(
    ("saved", "told"), [("a.relight.json", "beside it."), ("b/a.relight.json", "/p/b/a.relight.json.")]
)
def test_a_saved_session_is_told_with_its_place_where_that_is_elsewhere(saved, told):
    offer = saved_session_offer(Path("/p/a.jpg"), Path("/p") / saved, print, print)
    assert offer.text.endswith(told)


@pytest.mark.parametrize(
    ("answer", "written"),
    [("Keep both", ("a-2.png", False)), ("Replace", ("a.png", True)), ("Cancel", None)],
)
def test_what_is_there_is_replaced_only_where_the_user_says_so(tmp_path, answer, written):
    asking, places = Asking(), []
    for name in ("a.png", "b.png"):
        write_or_ask(asking, tmp_path / name, lambda path, replaces: places.append((path.name, replaces)))
    assert (places, asking.questions) == ([("a.png", False), ("b.png", False)], [])
    places.clear()
    for name in ("a.png", "b.png"):
        (tmp_path / name).touch()
        write_or_ask(asking, tmp_path / name, lambda path, replaces: places.append((path.name, replaces)))
    first, second = asking.questions
    assert (first.text, first.calling_off) == (f"a.png is already there, in {tmp_path}.", "Cancel")
    asking.answer(first, [label for label, _ in first.choices].index(answer))
    assert places == ([written] if written else [])
    assert asking.questions == [second]


def test_a_question_asked_again_is_asked_once_and_escape_calls_off_the_newest_that_can_be():
    asking, answered = Asking(), []
    for key in ("a", "b", "a"):
        no = "No", lambda key=key: answered.append(key)
        asking.ask(Question(key, "Really?", (("Yes", print), no), calling_off="No"))
    asking.ask(Question("c", "Really?", (("Yes", print),)))
    assert [question.key for question in asking.questions] == ["b", "a", "c"]
    assert [asking.call_off() for _ in range(3)] == [True, True, False]
    assert (answered, [question.key for question in asking.questions]) == (["a", "b"], ["c"])
