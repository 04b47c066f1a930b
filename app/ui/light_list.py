"""The list of lights beyond the bundled ones."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from app.engine.sources import LightSource


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
