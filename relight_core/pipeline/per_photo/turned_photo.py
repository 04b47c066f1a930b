"""The corners of a photo that was rotated, which are filled with one colour and belong to nobody."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from relight_core.imaging.photo_frame import FLAT, STEP

_CORNER_PX, _LEAST_LEG_PX = 4, 8
"""Side of the square at the picture's corner that must have one colour, and least length of a triangle's legs."""
_STRAIGHT_PX, _STRAIGHT, _PLAIN = 1.5, 0.8, 0.98
"""A triangle's border must be within this distance of a line, in this share of its rows, and this share of the triangle
must have its colour."""
_BORDER_PX = 1.5
"""Half the width of a border, over which it is soft, or darker or brighter by sharpening."""
_RIGHT_DEG = 1.5
"""Largest deviation from a right angle between the borders of one picture."""


@dataclass(frozen=True, eq=False)
class _Corner:
    """A filled triangle in a corner of a picture.

    Attributes:
        filled: (h, w) bool, the pixels that it covers.
        colour: (3,) sRGB.
        turn_deg: angle of its border modulo 90, in [0, 90): the same for all borders of one picture.
    """

    filled: np.ndarray
    colour: np.ndarray
    turn_deg: float


def filled_corners(shown: np.ndarray) -> np.ndarray | None:
    """Where a picture's corners were filled with one colour when it was rotated.

    Such corners end along straight lines that are parallel or at right angles to each other. A wall or a coat in one
    corner may end along a straight line too, but hardly in two corners; so at least two are required.

    Args:
        shown: (h, w, 3) sRGB, [0, 1].

    Returns:
        (h, w) bool; None if there are none.
    """
    flips = [(slice(None, None, down), slice(None, None, across)) for down in (1, -1) for across in (1, -1)]
    found = [corner for flip in flips if (corner := _corner(shown[flip], flip)) is not None]
    pairs = [pair for pair in combinations(found, 2) if _of_one_picture(*pair)]
    return np.logical_or.reduce([corner.filled for pair in pairs for corner in pair]) if pairs else None


def _of_one_picture(first: _Corner, second: _Corner) -> bool:
    """Whether two corners have the same colour and belong to the same rotation."""
    apart = abs(first.turn_deg - second.turn_deg)
    return min(apart, 90 - apart) <= _RIGHT_DEG and np.abs(first.colour - second.colour).max() <= FLAT


def _corner(shown: np.ndarray, flip: tuple[slice, slice]) -> _Corner | None:
    """The filled triangle in the top left corner of a picture (h, w, 3), which has been flipped by `flip`."""
    tip = shown[:_CORNER_PX, :_CORNER_PX].reshape(-1, 3)
    if np.ptp(tip, axis=0).max() > FLAT:
        return None
    colour = np.median(tip, axis=0)
    # The triangle ends above the first row that begins with another colour.
    count = int(np.argmax(np.append(_away(shown[:, 0], colour) > STEP, True)))
    if count < _LEAST_LEG_PX:
        return None
    away = _away(shown[:count], colour)
    legs = _legs(np.argmax(np.pad(away > STEP, ((0, 0), (0, 1)), constant_values=True), axis=1))
    if legs is None:
        return None
    down, across = legs
    rows, columns = np.ogrid[: shown.shape[0], : shown.shape[1]]
    # Distance of each pixel's centre from the border, positive inside the triangle.
    depth = (1 - (rows + 0.5) / down - (columns + 0.5) / across) * down * across / math.hypot(down, across)
    if (away[depth[:count] > _BORDER_PX] <= FLAT).mean() < _PLAIN:
        return None
    angle = math.degrees(math.atan2(down, across))
    mirrored = flip[0].step != flip[1].step
    return _Corner((depth > -_BORDER_PX)[flip], colour, (90 - angle if mirrored else angle) % 90)


def _away(shown: np.ndarray, colour: np.ndarray) -> np.ndarray:
    """The largest difference over channels of pixels (..., 3) from a colour, (...)."""
    red, green, blue = (np.abs(shown[..., channel] - colour[channel]) for channel in range(3))
    return np.maximum(np.maximum(red, green), blue)


def _legs(runs: np.ndarray) -> tuple[float, float] | None:
    """The lengths of a filled triangle's legs, down and across; None if it isn't a triangle.

    Args:
        runs: (h,) number of filled pixels at the start of each row, > 0. Rows that run on into the next triangle, where
            the rotated picture's corner touches the border, are tolerated as outliers.
    """
    rows, ends = np.arange(len(runs)) + 0.5, runs.astype(float)
    half = len(runs) // 2
    slope = float(np.median(ends[:half] - ends[half : 2 * half])) / half
    across = float(np.median(ends + slope * rows))
    if slope <= 0 or min(across, across / slope) < _LEAST_LEG_PX:
        return None
    missed = np.abs(ends - (across - slope * rows)) / math.hypot(1, slope)
    return (across / slope, across) if (missed <= _STRAIGHT_PX).mean() >= _STRAIGHT else None
