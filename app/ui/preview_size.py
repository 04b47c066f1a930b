"""How large a picture need be to be looked at."""

from __future__ import annotations

from app.engine.snapshot import OpenPhoto
from app.ui.viewport.view import View
from relight_core.pipeline.edit import Edit

PREVIEW_PX = 2560
"""Longest side of what is shown of a large photo while it is all in sight or the hand moves: about a screen's."""

_SMALL_PHOTO_PX = 6_000_000
"""Photos of no more pixels are always shown at their own size."""


def longest_side_px(opened: OpenPhoto | None, view: View, edit: Edit) -> int | None:
    """The longest side the picture need have, in pixels; None is as large as the photo."""
    size = opened.photo.linear.shape[:2] if opened else (0, 0)
    is_quick = edit.channels is not None
    return PREVIEW_PX if size[0] * size[1] > _SMALL_PHOTO_PX and (view.fit or is_quick) else None
