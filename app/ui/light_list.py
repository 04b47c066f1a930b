"""The list of lights beyond the bundled ones."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from app.engine.sources import LightSource
from relight_core.lighting.light_edit import LightEdit


def wish_again(
    light: LightSource, listed: Sequence[LightSource], refused: Collection[object], afresh: bool = False
) -> tuple[LightSource, list[LightSource]]:
    """The wish in the list for the same light, and the list; a wish that was refused is made anew, to be tried again.

    Args:
        light: what to wish for.
        listed: the wishes so far.
        refused: wishes that failed, which no one looks at any more.
        afresh: every wish is made anew, so that its file is read again.
    """
    known = next((known for known in listed if known.same_as(light)), light)
    wish = replace(known) if afresh or known in refused else known
    return wish, [wish if other is known else other for other in listed]


def edit_of_another(light: LightSource, before: LightEdit) -> LightEdit:
    """How another light is opened: as it is, around the user's own soft boxes.

    The room's share stays with the boxes; level, colour and blur were changes to the light before.
    """
    kept = before if before.boxes else LightEdit()
    return replace(light.opening_edit, base=kept.base, boxes=kept.boxes)
