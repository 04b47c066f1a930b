"""The command palette and the keyboard in the real window: all that a mouse can do, found by its name."""

import glfw
import pytest
from imgui_bundle import imgui
from window_hand import PATIENCE

from app.ui.asking import FileRequest, Question
from app.ui.layout import OpenGroups, Panels


def test_the_palette_finds_and_runs_a_command_with_the_keyboard_alone(opened):
    opened.key(glfw.KEY_P, ctrl=True)
    assert opened.window.state.look.palette
    opened.type("norm")
    assert opened.window.state.shown == "result"
    opened.key(glfw.KEY_ENTER)
    assert not opened.window.state.look.palette
    assert opened.window.state.shown == "normal"


def test_the_palette_finds_a_bundled_light(opened):
    opened.key(glfw.KEY_P, ctrl=True)
    opened.type("neon")
    opened.key(glfw.KEY_ENTER)
    assert opened.window.state.light.name == "neon"


def test_the_palette_closes_the_window(opened):
    opened.key(glfw.KEY_P, ctrl=True)
    opened.type("quit")
    assert not opened.window.may_close()
    opened.key(glfw.KEY_ENTER)
    assert opened.window.may_close()


def test_a_slider_of_a_hidden_panel_is_set_with_the_keyboard_alone(opened):
    state = opened.window.state
    state.panels, state.groups = Panels(effects=False), OpenGroups(effects=False)
    opened.key(glfw.KEY_P, ctrl=True)
    opened.type("exposure")
    opened.key(glfw.KEY_ENTER)
    assert state.typing == "Exposure"
    opened.type("1.5")
    opened.key(glfw.KEY_ENTER)
    assert (state.edit.exposure_ev, state.typing) == (1.5, None)


@pytest.mark.parametrize(
    ("typed", "found"),
    [
        ("background none", lambda state: state.edit.background == "transparent"),
        ("quality live", lambda state: state.quality.wish == "live"),
        ("kind exr", lambda state: state.export.form == ".exr"),
    ],
)
def test_a_choice_of_the_panels_is_made_with_the_keyboard_alone(opened, typed, found):
    opened.key(glfw.KEY_P, ctrl=True)
    opened.type(typed)
    opened.key(glfw.KEY_ENTER)
    assert found(opened.window.state)


def test_what_is_asked_is_answered_with_the_keyboard_alone(opened):
    asking, given = opened.window.state.asking, []
    choices = tuple((label, lambda label=label: given.append(label)) for label in ("Keep both", "Replace"))
    asking.ask(Question("older", "An older one.", (("Restore", lambda: given.append("Restore")),)))
    asking.ask(Question("newer", "me.png is already there.", choices))
    opened.key(glfw.KEY_ENTER)
    assert (given, [question.key for question in asking.questions]) == (["Keep both"], ["older"])
    asking.ask(Question("newer", "me.png is already there.", choices))
    opened.key(glfw.KEY_P, ctrl=True)
    opened.type("repl")
    opened.key(glfw.KEY_ENTER)
    assert (given, [question.key for question in asking.questions]) == (["Keep both", "Replace"], ["older"])


def test_enter_is_for_the_tool_in_use_before_it_answers(opened):
    asking, given = opened.window.state.asking, []
    opened.key(glfw.KEY_F, shift=True)
    asking.ask(Question("asked", "A question.", (("Yes", lambda: given.append("Yes")),)))
    opened.key(glfw.KEY_ENTER)
    assert (opened.window.state.faces.is_open, given) == (False, [])
    opened.key(glfw.KEY_ENTER)
    assert given == ["Yes"]


def test_typing_in_the_palette_triggers_no_shortcut_and_escape_closes_it(opened):
    calls = opened.window.state.edit
    opened.key(glfw.KEY_P, ctrl=True)
    opened.type("2")
    opened.key(glfw.KEY_LEFT)
    assert opened.window.state.shown == "result"
    assert opened.window.state.edit == calls
    opened.key(glfw.KEY_ESCAPE)
    assert not opened.window.state.look.palette
    opened.key(glfw.KEY_2)
    assert opened.window.state.shown == "albedo"


def has_tooltip():
    drawn = imgui.internal.find_window_by_name("##Tooltip_00")
    return drawn is not None and drawn.active


@pytest.mark.parametrize("over", ["palette", "file"])
def test_no_tooltip_lies_over_what_is_typed_in(opened, tmp_path, over):
    state = opened.window.state
    opened.move(opened.panorama(0.5))
    for _ in range(PATIENCE):
        if has_tooltip():
            break
        opened.frames(1)
    assert has_tooltip()
    if over == "palette":
        opened.key(glfw.KEY_P, ctrl=True)
    else:
        state.picking = FileRequest("open", "A file", tmp_path, list)
    opened.frames(2)
    assert state.look.palette or state.picking is not None
    assert not has_tooltip()
