"""Everything the filmstrip shows."""

from __future__ import annotations

from collections.abc import Container
from typing import NamedTuple

RESULT, PHOTO = "result", "photo"
WHOLE_PHOTO = (PHOTO, RESULT)
"""Those that show all of the photo; the others show the part that the networks see, or a light."""


class Channel(NamedTuple):
    """One picture of the filmstrip.

    Attributes:
        name: as of `relight_core.pipeline.edit.CHANNELS`, or RESULT.
        title, explanation: words for it.
        key: shows it.
        is_rare: it is left out of the filmstrip where there is none.
    """

    name: str
    title: str
    explanation: str
    key: str
    is_rare: bool = False


CHANNELS = (
    Channel(PHOTO, "Photo", "The photo as it was opened.", "1"),
    Channel("foreign_shadow", "Shadow taken off", "Shadows from outside that were taken off the photo.", "0", True),
    Channel("albedo", "Albedo", "The colour of skin, hair and cloth with all light taken away.", "2"),
    Channel("normal", "Normal", "Which way each spot of the face is turned.", "3"),
    Channel("parsing", "Parsing", "Which part of the head each spot belongs to.", "4"),
    Channel("source_light", "Source light", "The light the photo was taken under, as estimated from the face.", "5"),
    Channel("specular", "Specular", "The shine the new light puts on the skin.", "6"),
    Channel("shadow", "Shadow", "The shadows the new light casts.", "7"),
    Channel("composition", "Composition", "The relit face before it goes back into the photo.", "8"),
    Channel(RESULT, "Result", "The finished picture.", "9"),
)
"""Everything the filmstrip shows, in its order."""


def in_filmstrip(there: Container[str]) -> tuple[Channel, ...]:
    """The channels to show, of which some there are."""
    return tuple(channel for channel in CHANNELS if not channel.is_rare or channel.name in there)


def following(shown: str) -> tuple[str, ...]:
    """The channels that must follow the hand: the one in the viewport. The filmstrip's wait until it rests."""
    return () if shown in WHOLE_PHOTO else (shown,)
