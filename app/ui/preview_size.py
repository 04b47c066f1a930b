"""How large a picture need be to be looked at."""

from __future__ import annotations

from app.ui.viewport.view import View
from relight_core.pipeline.edit import Edit

PREVIEW_PX = 2560
"""Longest side of what is shown of a large photo while it is all in sight or the hand moves: about a screen's."""


def longest_side_px(is_open: bool, view: View, edit: Edit) -> int | None:
    """The longest side that the picture of a large photo need have, in pixels; None is as large as the photo.

    Args:
        is_open: the photo that is wanted is the open one, which `view` is of; another will be all in sight at first.
    """
    is_quick = edit.channels is not None
    return PREVIEW_PX if view.fit or is_quick or not is_open else None
