"""The status line's words, and which of them are in sight."""

import pytest

from app.engine.snapshot import Message, Snapshot
from app.ui.actions.action_table import ACTIONS
from app.ui.news import let_news_pass
from app.ui.panels.status_line import brief
from app.ui.state import EditorState


@pytest.mark.parametrize(
    ("message", "shown"),
    [
        ("/home/me/photos/a.jpg: not an image; use a JPEG", "a.jpg: not an image; use a JPEG"),
        ("Saved /home/me/a.png", "Saved /home/me/a.png"),
        ("/home/me/relit: 1 photo is missing\n/home/me/a.jpg: not an image", "relit: 1 photo is missing"),
        ("a.jpg: no face found", "a.jpg: no face found"),
        ("/: no photos in this folder", "/: no photos in this folder"),
        ("The graphics driver failed: it was started again", "The graphics driver failed: it was started again"),
    ],
)
def test_a_file_is_told_by_its_name(message, shown):
    assert brief(message) == shown


def told(*lines):
    """A state that was told lines, each with whether it is an error, before its next frame."""
    state, snapshot = EditorState(), Snapshot()
    for number, (text, is_error) in enumerate(lines, 1):
        snapshot = snapshot.telling(Message(number, text, is_error))
    state.accept(snapshot)
    return state


def put_away(state):
    """Press Esc until nothing is in sight; what was in sight before each time."""
    (escape,) = (action for action in ACTIONS if "Escape" in action.keys)
    seen = []
    while (message := state.message()) is not None:
        assert len(seen) < 99
        seen.append(message.text)
        escape.run(state)
    return seen


def test_an_error_is_in_sight_again_once_the_news_after_it_has_passed():
    state = told(("no light", True), ("Saved a.png", False))
    assert state.message().text == "Saved a.png"
    for frame in range(100):
        let_news_pass(state, 0.2 * frame)
    assert (state.message().text, state.message().is_error) == ("no light", True)
    assert put_away(state) == ["no light"]


def test_news_that_is_put_away_takes_no_error_along_and_behind_an_error_is_the_one_before():
    lines = [("no light", True), ("no photo", True), ("Saved a.png", False), ("Saved b.png", False)]
    assert put_away(told(*lines)) == ["Saved b.png", "no photo", "no light"]


def test_what_an_error_says_again_is_put_away_with_it_and_is_back_when_it_is_said_once_more():
    state = told(("full", True), ("no light", True), ("full", True), ("full\nSaved a.png", True))
    assert put_away(state) == ["full\nSaved a.png", "no light"]
    state.accept(state.snapshot.telling(Message(5, "no light", True)))
    assert put_away(state) == ["no light"]


def test_a_thousand_errors_are_not_kept_for_ever():
    state = told(*[(f"no photo {number}", True) for number in range(1000)])
    assert put_away(state)[0] == "no photo 999"
    assert len(state.snapshot.errors) < 99
    assert state.snapshot.errors[-1].text == "no photo 999"
