"""The level of a light at which a face is as bright as in its photo."""

from __future__ import annotations

import math

import numpy as np

from relight_core.imaging.colour import luminance
from relight_core.imaging.resampling import resize_area
from relight_core.pipeline.results.channels import ViewChange

MOST_STOPS = 4.0
"""Enough for a light that is in a photo's units."""

_SIDE = 64
_BLACK = 1e-4
_FEWEST = 20


def level_as_in_photo_ev(
    photo_view: np.ndarray, change: ViewChange, skin: np.ndarray, most_stops: float = MOST_STOPS, exposure: float = 1.0
) -> float:
    """Stops of light that bring the lit part of a face to the brightness that it has in the photo.

    The lit part is the brighter half of the skin, in either picture its own: what a photographer meters in a face that
    is half in shadow.

    Args:
        photo_view: (S, S, 3) linear.
        change: what the light makes of it, of any size.
        skin: (s, s) probability of skin.
        most_stops: for lights in units of their own, which may be thousands of times as bright as a photo's.
        exposure: of the portrait, at which a face is black or isn't.

    Returns:
        stops in [-most_stops, most_stops]; 0 where there is next to no skin, or where it is black in one of the two.
    """
    images = photo_view, change.gain, change.offset, skin
    side = min(_SIDE, *(len(image) for image in images))
    photo, gain, offset, skin = (resize_area(image, (side, side)) for image in images)
    with np.errstate(over="ignore", invalid="ignore"):
        before, after = (_of_lit_part(luminance(image)[skin > 0.5]) for image in (photo, gain * photo + offset))
    # A dim light leaves skin nearly black that is not black at another level of that light.
    lit = max(after, after / (change.level or 1.0))
    if not (before * exposure > _BLACK and lit > _BLACK and after > 0.0):
        return 0.0
    return min(max(math.log2(before) - math.log2(after), -most_stops), most_stops)


def _of_lit_part(luminances: np.ndarray) -> float:
    """Mean of the brighter half, or 0 of too few."""
    finite = luminances[np.isfinite(luminances)]
    return float(finite[finite >= np.median(finite)].mean(dtype=np.float64)) if finite.size >= _FEWEST else 0.0
