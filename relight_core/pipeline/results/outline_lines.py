"""The people's outlines as lines, to be drawn over a photo."""

from __future__ import annotations

import cv2
import numpy as np

from relight_core.pipeline.per_photo.matte import Matte
from relight_core.pipeline.per_photo.person import Canvas, whole_person

_STRAIGHT_PX = 0.6
_FEWEST_POINTS = 3


def outline_lines(canvas: Canvas, matte: Matte) -> list[np.ndarray]:
    """Closed lines along which the matte is a half, around people and around holes in them.

    Args:
        canvas: the photo, small enough to be looked at often; lines are as fine as its pixels.

    Returns:
        (n, 2) float32 each: x, y in photo pixels.
    """
    share = whole_person(canvas, matte).share
    inside = (share > 0.5).astype(np.uint8)
    found, _ = cv2.findContours(inside, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    scale = (np.array(canvas.photo_size) / share.shape)[::-1]
    lines = (cv2.approxPolyDP(line, _STRAIGHT_PX, True)[:, 0] for line in found)
    return [((line + 0.5) * scale).astype(np.float32) for line in lines if len(line) >= _FEWEST_POINTS]
