"""The actions that correct where the faces are."""

from __future__ import annotations

from app.ui import face_edits
from app.ui.actions.action import Action, Gesture, has_photo

_FACES = "Faces"


FACES = (
    Action(
        "Edit the face boxes",
        _FACES,
        ("Shift+F",),
        "Move, resize, add and remove the boxes of the faces that are relit",
        face_edits.switch,
        available=has_photo,
        is_on=lambda state: state.faces.is_open,
    ),
    Action(
        "Find the faces again",
        _FACES,
        ("Ctrl+Shift+F",),
        "Forgets the boxes drawn by hand",
        face_edits.find_again,
        available=lambda state: state.is_at_work() and face_edits.is_corrected(state),
    ),
)

GESTURES = (
    Gesture("Drag a face's box", _FACES, "Move it; at its edge, resize it"),
    Gesture("Drag beside the boxes", _FACES, "Add a face that was not found"),
)
