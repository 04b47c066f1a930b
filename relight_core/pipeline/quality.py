"""The quality tiers: how large a portrait is seen, and how often."""

from __future__ import annotations

from dataclasses import dataclass

from relight_core.errors import InputError


@dataclass(frozen=True)
class Tier:
    """One setting of the accuracy dial.

    Attributes:
        size: side of the view of the portrait, in pixels; channels have it.
        network_size: side at which the networks see that view, a multiple of 32. They were trained on
            images of 128 pixels, and a face much larger than there confuses them.
        relief_size: side of the relief that is marched for cast shadow.
        mirrored: de-light the mirrored view too, and average.
    """

    size: int
    network_size: int
    relief_size: int
    mirrored: bool


TIERS = {
    "draft": Tier(192, 96, 48, False),
    "live": Tier(256, 128, 64, False),
    "final": Tier(512, 128, 96, True),
}


def tier_of(quality: str) -> Tier:
    """The tier of a name; raises InputError naming the known ones."""
    if quality not in TIERS:
        raise InputError(f"unknown quality {quality!r}: choose one of {', '.join(TIERS)}")
    return TIERS[quality]
