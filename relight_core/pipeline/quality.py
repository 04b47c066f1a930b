"""The quality tiers: how large the networks see a portrait."""

from __future__ import annotations

from dataclasses import dataclass

from relight_core.errors import InputError


@dataclass(frozen=True)
class Tier:
    """One setting of the accuracy dial.

    Attributes:
        size: side of the view the networks see, in pixels; a multiple of 32.
        relief_size: side of the relief that is marched for cast shadow.
    """

    size: int
    relief_size: int


TIERS = {"draft": Tier(192, 64), "live": Tier(256, 96), "final": Tier(512, 128)}


def tier_of(quality: str) -> Tier:
    """The tier of a name; raises InputError naming the known ones."""
    if quality not in TIERS:
        raise InputError(f"unknown quality {quality!r}: choose one of {', '.join(TIERS)}")
    return TIERS[quality]
