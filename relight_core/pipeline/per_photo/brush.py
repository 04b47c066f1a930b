"""Strokes of a brush that say who is person in a photo and what is not, where the networks are mistaken."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import cv2
import numpy as np

from relight_core.errors import InputError

MOST_STROKES, MOST_POINTS = 400, 256
"""Of a photo, and of a stroke."""

FARTHEST_PX, THINNEST_PX, WIDEST_PX = 1e5, 0.1, 1e4
"""Where points may be, and half the width of brushes that a window or a session makes."""

_SUBPIXEL_BITS = 4
_HAIRLINE_DOT = np.array([1 << (_SUBPIXEL_BITS - 1), 0])
_SMOOTHING_PX = 1.5
"""By so much OpenCV's smooth lines are wider than an even width that is asked for, and by one more than an odd one."""


@dataclass(frozen=True)
class BrushStroke:
    """One movement of the brush.

    Attributes:
        points: (x, y) in photo pixels, at least one; where there is one alone, the stroke is a dot.
        radius_px: half the brush's width, in photo pixels.
        adds: what it covers is person; else it is not.
    """

    points: tuple[tuple[float, float], ...]
    radius_px: float
    adds: bool


def checked_strokes(strokes: Sequence[BrushStroke]) -> tuple[BrushStroke, ...]:
    """The strokes that a user painted.

    Raises:
        InputError: too many, or one without a point, a width, or finite places near the photo.
    """
    if len(strokes) > MOST_STROKES:
        raise InputError(f"a photo has at most {MOST_STROKES} strokes of the brush; undo some")
    for stroke in strokes:
        near = all(abs(part) <= FARTHEST_PX for point in stroke.points for part in point)
        if not (0 < len(stroke.points) <= MOST_POINTS and near and 0 < stroke.radius_px <= WIDEST_PX):
            raise InputError("a stroke of the brush is empty or far outside the photo; paint it anew")
    return tuple(strokes)


def painted(share: np.ndarray, strokes: Sequence[BrushStroke], photo_size: tuple[int, int]) -> np.ndarray:
    """A map after the strokes: 1 under those that add, 0 under the others; of strokes that cross, the last counts.

    Args:
        share: (h, w) in [0, 1], over the whole photo.
        photo_size: (height, width).

    Returns:
        (h, w) float32; the map itself where there are no strokes.
    """
    scale = np.array(share.shape[::-1]) / np.array(photo_size)[::-1]
    for adds, alike in groupby(strokes, key=lambda stroke: stroke.adds):
        cover = np.zeros(share.shape, np.uint8)
        for stroke in alike:
            _draw(cover, stroke, scale)
        share = share + cover.astype(np.float32) / 255 * (float(adds) - share)
    return share


def _draw(cover: np.ndarray, stroke: BrushStroke, scale: np.ndarray) -> None:
    """Set what a stroke covers of a map to 255; `scale` is of the map over the photo, across and down."""
    # OpenCV has pixel centres on whole numbers.
    places = (np.array(stroke.points, np.float64) * scale - 0.5) * (1 << _SUBPIXEL_BITS)
    width = max(2 * round((2 * stroke.radius_px * float(scale.mean()) - _SMOOTHING_PX) / 2), 1)
    ends = [places[-1:]]
    if width == 1:
        # It draws nothing of a hairline from a place to itself.
        ends = [places[-1:] - _HAIRLINE_DOT, places[-1:] + _HAIRLINE_DOT]
    line = [np.round(np.concatenate([places, *ends])).astype(np.int32)]
    cv2.polylines(cover, line, False, 255, width, cv2.LINE_AA, _SUBPIXEL_BITS)
