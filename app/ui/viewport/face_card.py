"""The card over the picture that says what can be done about the boxes of faces, and that no face was found."""

from __future__ import annotations

from app.ui import face_edits
from app.ui.layout import Rect
from app.ui.state import EditorState
from app.ui.viewport import face_tool, tool_card
from app.ui.viewport.tool_card import Button

_CORRECTING = "Move or resize a box, or draw one from brows to chin."
_NOBODY = "No face was found. Draw a box over it, from brows to chin."
_NOBODY_LEFT = "No face is left. Draw a box over one, from brows to chin."
_SEARCHING = "Looking for faces…"


_CLOSED = (Button("Draw a box", "Then drag over the face.  Shift + F", face_edits.show, is_main=True),)
_OPEN = (
    Button(
        "Find again", "Forget these boxes and look for the faces anew.", face_edits.find_again, face_edits.is_corrected
    ),
    Button(
        "Remove",
        "The selected box is no face.  Delete",
        face_edits.remove,
        lambda state: 0 <= state.faces.selected < len(face_edits.wished_boxes(state)),
    ),
    Button("Done", "Enter.  Esc puts the boxes back as they were", face_edits.done, is_main=True),
)


def draw(state: EditorState, viewport: Rect) -> None:
    """The card, where there is something to be done."""
    tool = state.faces
    if state.snapshot.opened is None or state.picking is not None or tool.held is not None:
        return
    if not tool.is_open and (state.snapshot.faces or face_edits.wished_boxes(state) or face_edits.is_searching(state)):
        return
    buttons, boxes = _OPEN if tool.is_open else _CLOSED, face_tool.on_the_screen(state, viewport)
    tool_card.draw(state, "faces", words(state), buttons, viewport, boxes)


def words(state: EditorState) -> str:
    """What can be done now."""
    if face_edits.is_searching(state):
        return _SEARCHING
    if face_edits.wished_boxes(state):
        return _CORRECTING
    return _NOBODY_LEFT if face_edits.is_corrected(state) else _NOBODY
