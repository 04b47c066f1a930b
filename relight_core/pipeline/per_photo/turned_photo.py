"""The corners of a photo that was turned: filled in one colour, they are no part of anybody who is cut off by them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from relight_core.imaging.photo_frame import FLAT, STEP

_CORNER_PX, _LEAST_LEG_PX = 4, 8
_STRAIGHT_PX, _STRAIGHT, _PLAIN = 1.5, 0.8, 0.98
"""How near a line its corner ends, in which share of the rows, and how much of it has its colour."""
_BORDER_PX = 1.5
"""A border is that soft, and darkened or lit by sharpening as far."""
_RIGHT_DEG = 1.5
"""By how much at most the borders of one picture miss a right angle."""


@dataclass(frozen=True, eq=False)
class _Corner:
    """A triangle in a corner of a picture.

    Attributes:
        filled: (h, w) bool, what it covers.
        colour: (3,) sRGB.
        turn_deg: of its border, in [0, 90): the borders of a picture have all the same.
    """

    filled: np.ndarray
    colour: np.ndarray
    turn_deg: float


def filled_corners(shown: np.ndarray) -> np.ndarray | None:
    """Where a picture's corners were filled in one colour when it was turned.

    Such corners end along straight lines, at right angles to each other; a wall or a coat in one corner may end
    along one, and not in another corner too.

    Args:
        shown: (h, w, 3) sRGB, [0, 1].

    Returns:
        (h, w) bool; None where there are none.
    """
    flips = [(slice(None, None, down), slice(None, None, across)) for down in (1, -1) for across in (1, -1)]
    found = [corner for flip in flips if (corner := _corner(shown[flip], flip)) is not None]
    pairs = [pair for pair in combinations(found, 2) if _of_one_picture(*pair)]
    return np.logical_or.reduce([corner.filled for pair in pairs for corner in pair]) if pairs else None


def _of_one_picture(first: _Corner, second: _Corner) -> bool:
    apart = abs(first.turn_deg - second.turn_deg)
    return min(apart, 90 - apart) <= _RIGHT_DEG and np.abs(first.colour - second.colour).max() <= FLAT


def _corner(shown: np.ndarray, flip: tuple[slice, slice]) -> _Corner | None:
    """The triangle that is filled at the first row's and column's end of a picture that was flipped so."""
    tip = shown[:_CORNER_PX, :_CORNER_PX].reshape(-1, 3)
    if np.ptp(tip, axis=0).max() > FLAT:
        return None
    colour = np.median(tip, axis=0)
    # Below the first row that begins with something else, nothing is of the corner.
    count = int(np.argmax(np.append(_away(shown[:, 0], colour) > STEP, True)))
    if count < _LEAST_LEG_PX:
        return None
    away = _away(shown[:count], colour)
    legs = _legs(np.argmax(np.pad(away > STEP, ((0, 0), (0, 1)), constant_values=True), axis=1))
    if legs is None:
        return None
    down, across = legs
    rows, columns = np.ogrid[: shown.shape[0], : shown.shape[1]]
    # How far each pixel's middle is from the border, positive in the corner.
    depth = (1 - (rows + 0.5) / down - (columns + 0.5) / across) * down * across / math.hypot(down, across)
    if (away[depth[:count] > _BORDER_PX] <= FLAT).mean() < _PLAIN:
        return None
    angle = math.degrees(math.atan2(down, across))
    mirrored = flip[0].step != flip[1].step
    return _Corner((depth > -_BORDER_PX)[flip], colour, (90 - angle if mirrored else angle) % 90)


def _away(shown: np.ndarray, colour: np.ndarray) -> np.ndarray:
    """How far pixels (..., 3) are from a colour, (...), in the channel in which they are farthest."""
    red, green, blue = (np.abs(shown[..., channel] - colour[channel]) for channel in range(3))
    return np.maximum(np.maximum(red, green), blue)


def _legs(runs: np.ndarray) -> tuple[float, float] | None:
    """How far a filled triangle reaches down and across; None where it is none.

    Args:
        runs: (h,) how many of the first pixels of each row are filled, more than none. Where the picture's own corner
            touches its border, a row may be filled on from one triangle into the next: it counts for nothing.
    """
    rows, ends = np.arange(len(runs)) + 0.5, runs.astype(float)
    half = len(runs) // 2
    slope = float(np.median(ends[:half] - ends[half : 2 * half])) / half
    across = float(np.median(ends + slope * rows))
    if slope <= 0 or min(across, across / slope) < _LEAST_LEG_PX:
        return None
    missed = np.abs(ends - (across - slope * rows)) / math.hypot(1, slope)
    return (across / slope, across) if (missed <= _STRAIGHT_PX).mean() >= _STRAIGHT else None
