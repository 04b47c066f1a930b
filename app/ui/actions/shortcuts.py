"""The keys of the action table; they work wherever the mouse is, unless something is being typed."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui.actions.action import Action, Chord
from app.ui.actions.action_table import ACTIONS
from app.ui.state import EditorState

_NAMED = {
    "Left": "left_arrow",
    "Right": "right_arrow",
    "Up": "up_arrow",
    "Down": "down_arrow",
    "=": "equal",
    "-": "minus",
    "\\": "backslash",
    ",": "comma",
    ".": "period",
    "PageDown": "page_down",
    "PageUp": "page_up",
}
_ALSO = {"Enter": "keypad_enter", "=": "keypad_add", "-": "keypad_subtract"}
_ALSO |= {str(digit): f"keypad{digit}" for digit in range(10)}


def apply(state: EditorState) -> None:
    """Run the actions whose keys went down in this frame."""
    io = imgui.get_io()
    typing = io.want_text_input or state.look.palette or state.picking is not None
    if not typing and _put_menu_away():
        return
    for action in ACTIONS:
        if action.let_go is not None:
            _hold(state, action, typing)
        elif not typing and any(_pressed(chord, action.repeats) for chord in action.chords) and action.available(state):
            action.run(state)


def _put_menu_away() -> bool:
    """Escape closes a menu or a list that is open, and does nothing else then."""
    is_open = imgui.is_popup_open("", imgui.PopupFlags_.any_popup)
    if not is_open or not imgui.is_key_pressed(imgui.Key.escape, False):
        return False
    imgui.internal.close_popup_to_level(0, True)
    return True


def _hold(state: EditorState, action: Action, typing: bool) -> None:
    down = not typing and any(imgui.is_key_down(key) for chord in action.chords for key in _keys(chord.key))
    if down and action.available(state):
        action.run(state)
    else:
        action.let_go(state)


def _pressed(chord: Chord, repeats: bool) -> bool:
    io = imgui.get_io()
    if chord.key == "?":
        # The character, since every keyboard has it elsewhere.
        return ord("?") in io.input_queue_characters
    if (io.key_ctrl, io.key_shift, io.key_alt) != (chord.ctrl, chord.shift, chord.alt) or io.key_super:
        return False
    return any(imgui.is_key_pressed(key, repeats) for key in _keys(chord.key))


def _keys(name: str) -> list[imgui.Key]:
    names = [_NAMED.get(name, f"_{name}" if name.isdigit() else name.lower()), _ALSO.get(name)]
    return [getattr(imgui.Key, key) for key in names if key]
