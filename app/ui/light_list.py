"""The lights to choose from: those that were used, the photo's own, and the bundled ones."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from app.engine.sources import LightSource

if TYPE_CHECKING:
    from app.ui.state import EditorState

_FROM_FILE = {"panorama": "A panorama you used.", "portrait": "The light of a portrait you used."}
_OWN = "The photo's own light, as estimated from the face."


@dataclass(frozen=True)
class Shelf:
    """The bundled lights as the window shows them.

    Attributes:
        names: in the order of the list.
        words: title and description of one; the description is empty until it has been read.
    """

    names: tuple[str, ...]
    words: Callable[[str], tuple[str, str]]


def lights_to_choose(state: EditorState, shelf: Shelf) -> list[tuple[LightSource, str]]:
    """Every light that can be chosen now, with a sentence on each."""
    used = [(light, _FROM_FILE[light.kind]) for light in state.extra_lights]
    # From the moment its photo is asked for: coming later, it would move every light behind it under the mouse.
    has_own = state.photo is not None or state.snapshot.opened is not None or state.light.kind == "own"
    own = [(LightSource("own"), _OWN)] if has_own else []
    return [*used, *own, *((LightSource("rig", name), shelf.words(name)[1]) for name in shelf.names)]


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
