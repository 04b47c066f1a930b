"""Which edit is asked of the engine while a hand moves something."""

from __future__ import annotations

from dataclasses import replace

from relight_core.pipeline.edit import Edit

_APPLIED_LAST = ("strength", "background", "background_fov_deg", "background_blur_deg")
"""Settings that are applied to the finished result: at any quality a new picture takes as long as at the quickest."""
_HOW = ("quality", "surface_of", "channels")


def edit_in_motion(edit: Edit, quick: Edit, asked: Edit | None) -> Edit:
    """What to ask for next.

    Args:
        edit: what will be asked for when the hand rests.
        quick: the same at the quality that keeps up with the hand.
        asked: what was asked for last, under the same light; None if the light is another now.

    Returns:
        `asked` if nothing has changed since; `edit`, with the channels of `quick`, if only settings have changed that
        are applied to the finished result; else `quick`.
    """
    if asked is None:
        return quick
    if replace(edit, **_from(asked, *_HOW)) == asked:
        return asked
    is_finished = replace(asked, **_from(edit, *_APPLIED_LAST, "channels")) == edit
    return replace(edit, channels=quick.channels) if is_finished else quick


def _from(edit: Edit, *names: str) -> dict:
    return {name: getattr(edit, name) for name in names}
