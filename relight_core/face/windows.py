"""Squares over the whole photo in which a parsing can search for a face that no cascade sees."""

from __future__ import annotations

import numpy as np

from relight_core.face.crop import Crop

_SHARES = (1.0, 0.5)
"""Sides of the squares, in shorter sides of the photo."""
_MOST_STEPS = 9
"""Steps from the first square along a side to the last."""


def search_windows(photo_size: tuple[int, int]) -> list[Crop]:
    """Squares as wide as the photo's shorter side, then half as wide, each overlapping the next by half.

    In a very long photo there are at most ten along the longer side, evenly spaced, with gaps between them.

    Args:
        photo_size: (height, width).
    """
    shortest = min(photo_size)
    windows = []
    for share in _SHARES:
        side = float(max(round(shortest * share), 1))
        windows += [Crop(x, y, side) for y in _centres(photo_size[0], side) for x in _centres(photo_size[1], side)]
    return windows


def _centres(length: int, side: float) -> np.ndarray:
    """Centres of the windows along a length, from border to border."""
    steps = min(int(np.ceil(2 * (length - side) / side)), _MOST_STEPS)
    return np.round(np.linspace(side / 2, length - side / 2, steps + 1)) if steps > 0 else np.array([length / 2])
