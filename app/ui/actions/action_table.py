"""The one table of everything the user can do; app/ui/actions/action.py tells how to add to it."""

from __future__ import annotations

from app.ui import brush_edits, face_edits
from app.ui.actions import brush_actions, edit_actions, face_actions, look_actions
from app.ui.actions.action import Action, Gesture
from app.ui.news import put_message_away
from app.ui.state import EditorState
from app.ui.viewport.questions import answered_by_enter

_PROGRAM = "Program"


def _switch_palette(state: EditorState) -> None:
    state.look.switch("palette")
    state.look.palette_text, state.look.palette_row = "", 0


def _done(state: EditorState) -> None:
    """Put the open tool away with what was done by it; else answer what was asked last."""
    if state.faces.is_open:
        face_edits.done(state)
    elif state.brush.is_open:
        brush_edits.done(state)
    elif (question := answered_by_enter(state)) is not None:
        state.asking.answer(question, 0)


def _can_be_done(state: EditorState) -> bool:
    return state.faces.is_open or state.brush.is_open or answered_by_enter(state) is not None


def _close(state: EditorState) -> None:
    """Close what is open, taking back what it is for taking back, else call off a question or put the message away."""
    if state.look.help:
        state.look.help = False
    elif state.faces.is_open:
        face_edits.cancel(state)
    elif state.brush.is_open:
        brush_edits.cancel(state)
    elif state.aim.target or state.playing:
        state.aim.target, state.playing = "", False
    elif not state.asking.call_off():
        put_message_away(state)


PROGRAM = (
    Action(
        "Find a command",
        _PROGRAM,
        ("Ctrl+P",),
        "Type a few letters of what you want to do, of a setting or of a light",
        _switch_palette,
    ),
    Action("Show all keys", _PROGRAM, ("?", "F1"), "This overview", lambda state: state.look.switch("help")),
    Action(
        "Done, or the first answer",
        _PROGRAM,
        ("Enter",),
        "Keeps faces or outline as they are, where Esc puts them back as they were; else answers what is asked",
        _done,
        available=_can_be_done,
    ),
    Action(
        "Close or put away",
        _PROGRAM,
        ("Escape",),
        "Closes what is open, gives Cancel to what is asked, or hides the message below",
        _close,
    ),
    Action(
        "Quit",
        _PROGRAM,
        ("Ctrl+Q",),
        "Closes the window; asks first where files or work would be lost",
        lambda state: setattr(state, "quit_wanted", True),
    ),
)

ACTIONS: tuple[Action, ...] = (
    *look_actions.LOOKING,
    *look_actions.COMPARING,
    *look_actions.SHOWING,
    *look_actions.READING,
    *edit_actions.LIGHT,
    *edit_actions.BOXES,
    *face_actions.FACES,
    *brush_actions.OUTLINE,
    *edit_actions.HISTORY,
    *edit_actions.FILE,
    *look_actions.PANELS,
    *look_actions.ARRANGING,
    *PROGRAM,
)
"""In the order of the palette and, group by group, of the overlay."""

GESTURES: tuple[Gesture, ...] = (
    *look_actions.GESTURES,
    *edit_actions.GESTURES,
    *face_actions.GESTURES,
    *brush_actions.GESTURES,
)
