"""Where to look for a face that no cascade sees: squares over the whole photo, for a parsing to judge."""

from __future__ import annotations

import numpy as np

from relight_core.face.crop import Crop

_SHARES = (1.0, 0.5)
_MOST_STEPS = 9


def search_windows(photo_size: tuple[int, int]) -> list[Crop]:
    """Squares as large as the photo is narrow, then half as large, each half beside the next.

    Along a photo that is very long for its width there are ten at the most, evenly spread, with gaps between them.

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
    """Middles of windows along a length, from border to border."""
    steps = min(int(np.ceil(2 * (length - side) / side)), _MOST_STEPS)
    return np.round(np.linspace(side / 2, length - side / 2, steps + 1)) if steps > 0 else np.array([length / 2])
