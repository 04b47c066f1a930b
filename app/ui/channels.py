"""Everything the filmstrip shows."""

from __future__ import annotations

RESULT, PHOTO = "result", "photo"
WHOLE_PHOTO = (PHOTO, RESULT)
"""Those that show all of the photo; the others show the part that the networks see, or a light."""

CHANNELS: tuple[tuple[str, str, str], ...] = (
    (PHOTO, "Photo", "The photo as it was opened."),
    ("albedo", "Albedo", "The colour of skin, hair and cloth with all light taken away."),
    ("normal", "Normal", "Which way each spot of the face is turned."),
    ("parsing", "Parsing", "Which part of the head each spot belongs to."),
    ("source_light", "Source light", "The light the photo was taken under, as estimated from the face."),
    ("specular", "Specular", "The shine the new light puts on the skin."),
    ("shadow", "Shadow", "The shadows the new light casts."),
    ("composition", "Composition", "The relit face before it goes back into the photo."),
    (RESULT, "Result", "The finished picture."),
)
"""Name, title and explanation of everything the filmstrip shows, in its order; number keys count along."""


def following(shown: str) -> tuple[str, ...]:
    """The channels that must follow the hand: the one in the viewport. The filmstrip's wait until it rests."""
    return () if shown in WHOLE_PHOTO else (shown,)
