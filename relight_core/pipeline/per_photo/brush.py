"""Brush strokes with which a user corrects what belongs to the person in a photo."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import cv2
import numpy as np

from relight_core.errors import InputError

MOST_STROKES, MOST_POINTS = 400, 256
"""Largest number of strokes in a photo, and of points in a stroke."""

FARTHEST_PX, THINNEST_PX, WIDEST_PX = 1e5, 0.1, 1e4
"""Limits in photo pixels: of a point's coordinates, and of a brush's radius."""

_SUBPIXEL_BITS = 4
"""OpenCV takes coordinates with so many fractional bits."""
_HAIRLINE_DOT = np.array([1 << (_SUBPIXEL_BITS - 1), 0])
"""Half a pixel sideways."""
_SMOOTHING_PX = 1.5
"""OpenCV's antialiased lines are wider by this than a requested even width, and by one more than an odd one."""


@dataclass(frozen=True)
class BrushStroke:
    """One movement of the brush.

    Attributes:
        points: (x, y) in photo pixels, at least one; a single one is a dot.
        radius_px: half the brush's width, in photo pixels.
        adds: True if what it covers belongs to the person, False if not.
    """

    points: tuple[tuple[float, float], ...]
    radius_px: float
    adds: bool


def checked_strokes(strokes: Sequence[BrushStroke]) -> tuple[BrushStroke, ...]:
    """The strokes that a user painted, if they are valid.

    Raises:
        InputError: too many, or one without a point or a width, or with points far from the photo.
    """
    if len(strokes) > MOST_STROKES:
        raise InputError(f"a photo has at most {MOST_STROKES} strokes of the brush; undo some")
    for stroke in strokes:
        near = all(abs(part) <= FARTHEST_PX for point in stroke.points for part in point)
        if not (0 < len(stroke.points) <= MOST_POINTS and near and 0 < stroke.radius_px <= WIDEST_PX):
            raise InputError("a stroke of the brush is empty or far outside the photo; paint it anew")
    return tuple(strokes)


def painted(share: np.ndarray, strokes: Sequence[BrushStroke], photo_size: tuple[int, int]) -> np.ndarray:
    """A map with strokes painted into it: 1 under those that add, 0 under the others. Later strokes cover earlier ones.

    Args:
        share: (h, w) in [0, 1], over the whole photo.
        strokes: in the order in which they were painted.
        photo_size: (height, width).

    Returns:
        (h, w) float32; the map itself if there are no strokes.
    """
    scale = np.array(share.shape[::-1]) / np.array(photo_size)[::-1]
    for adds, alike in groupby(strokes, key=lambda stroke: stroke.adds):
        cover = np.zeros(share.shape, np.uint8)
        for stroke in alike:
            _draw(cover, stroke, scale)
        share = share + cover.astype(np.float32) / 255 * (float(adds) - share)
    return share


def _draw(cover: np.ndarray, stroke: BrushStroke, scale: np.ndarray) -> None:
    """Set what a stroke covers of a map to 255; `scale` is the map's size over the photo's, across and down."""
    # OpenCV's whole numbers are pixel centres.
    places = (np.array(stroke.points, np.float64) * scale - 0.5) * (1 << _SUBPIXEL_BITS)
    width = max(2 * round((2 * stroke.radius_px * float(scale.mean()) - _SMOOTHING_PX) / 2), 1)
    ends = [places[-1:]]
    if width == 1:
        # OpenCV draws nothing for a line of width 1 from a point to itself.
        ends = [places[-1:] - _HAIRLINE_DOT, places[-1:] + _HAIRLINE_DOT]
    line = [np.round(np.concatenate([places, *ends])).astype(np.int32)]
    cv2.polylines(cover, line, False, 255, width, cv2.LINE_AA, _SUBPIXEL_BITS)
