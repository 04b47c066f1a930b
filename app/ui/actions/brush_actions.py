"""The actions that correct the people's outline."""

from __future__ import annotations

from app.ui import brush_edits
from app.ui.actions.action import Action, Gesture, has_picture
from app.ui.state import EditorState

_OUTLINE = "Outline"


def _is_open(state: EditorState) -> bool:
    return state.brush.is_open


OUTLINE = (
    Action(
        "Edit the outline",
        _OUTLINE,
        ("Shift+O",),
        "Paint over what belongs to the person and was missed, or over what does not",
        brush_edits.switch,
        available=has_picture,
        is_on=_is_open,
    ),
    Action(
        "Add to the person or take away",
        _OUTLINE,
        ("X",),
        "What the brush does; Alt, held while you paint, is the other",
        brush_edits.turn_over,
        available=_is_open,
    ),
    Action(
        "Larger brush",
        _OUTLINE,
        (".",),
        "On the screen; zooming in makes it finer in the photo",
        lambda state: brush_edits.resize(state, 1),
        available=_is_open,
        repeats=True,
    ),
    Action(
        "Smaller brush",
        _OUTLINE,
        (",",),
        "On the screen; zooming in makes it finer in the photo",
        lambda state: brush_edits.resize(state, -1),
        available=_is_open,
        repeats=True,
    ),
    Action(
        "Outline as found",
        _OUTLINE,
        ("Ctrl+Shift+O",),
        "Forgets all that was painted",
        brush_edits.forget,
        available=brush_edits.is_painted,
    ),
)

GESTURES = (
    Gesture("Paint on the picture", _OUTLINE, "While the outline is in sight: add to the person"),
    Gesture("Alt + paint", _OUTLINE, "Take away from the person"),
)
