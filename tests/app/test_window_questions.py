"""Which answer is highlighted in the real window: the one that Enter gives."""

import glfw
from imgui_bundle import imgui
from window_hand import places_drawn

from app.ui.asking import Question

OLDER, NEWER = ("Restore", "Start afresh"), ("Keep both", "Replace")


def highlighted(hand, places, labels):
    """Those of some answers that are in colour."""
    hand.move((hand.width / 2, hand.height - 3))
    frame = hand.window.screenshot().astype(int)
    found = []
    for label in labels:
        x, y = (round(along) for along in places[label])
        around = frame[y - 8 : y + 9, x - 30 : x + 31]
        found += [label] if (around[..., 0] - around[..., 2]).max() > 80 else []
    return found


def test_of_two_questions_the_answer_that_enter_gives_is_highlighted_and_none_while_a_tool_is_open(opened, monkeypatch):
    state, given = opened.window.state, []
    for key, labels in (("older", OLDER), ("newer", NEWER)):
        choices = tuple((label, lambda label=label: given.append(label)) for label in labels)
        state.asking.ask(Question(key, "A question.", choices))
    places = places_drawn(monkeypatch, imgui, "button")
    opened.frames(3)
    assert highlighted(opened, places, OLDER + NEWER) == ["Keep both"]
    for tool in (glfw.KEY_F, glfw.KEY_O):
        opened.key(tool, shift=True)
        assert highlighted(opened, places, OLDER + NEWER) == []
        opened.key(glfw.KEY_ENTER)
        assert given == []
    opened.key(glfw.KEY_ENTER)
    assert given == ["Keep both"]
    opened.frames(3)
    assert highlighted(opened, places, OLDER) == ["Restore"]
