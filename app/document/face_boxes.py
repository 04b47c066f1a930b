"""Boxes of faces, drawn by hand, as a session's JSON holds them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from app.document.json_fields import Fields
from relight_core.errors import InputError
from relight_core.face.find import FaceBox

MOST_FACES = 32
"""As many a photo may have by hand; each is kept in memory as the networks see it."""

_KEY = "face_boxes"
_FARTHEST_PX = 1e6
_EDGES = ("x0", "y0", "x1", "y1")


def face_boxes_content(boxes: Sequence[FaceBox] | None) -> list[dict] | None:
    """Boxes as JSON holds them; None where the finder says where the faces are."""
    if boxes is None:
        return None
    return [{key: float(getattr(box, key)) for key in (*_EDGES, "roll_deg")} for box in boxes]


def read_face_boxes(fields: Fields, path: Path) -> tuple[FaceBox, ...] | None:
    """The boxes in a session.

    Args:
        path: of the session, for messages.

    Raises:
        InputError: a box that is none.
    """
    if fields.is_nothing(_KEY):
        return None
    return tuple(_box(group, path) for group in fields.groups(_KEY, MOST_FACES))


def _box(fields: Fields, path: Path) -> FaceBox:
    edges = [fields.number(key, -_FARTHEST_PX, _FARTHEST_PX, 0.0) for key in _EDGES]
    box = FaceBox(*edges, fields.number("roll_deg", -360.0, 360.0, 0.0))
    fields.finish()
    if box.width < 1.0 or box.height < 1.0:
        raise InputError(f"{path}: the box of a face is empty; mend the file or delete its {_KEY}")
    return box
