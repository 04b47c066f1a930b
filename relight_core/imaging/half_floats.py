"""What half floats hold: pictures on their way into files and textures, and radiance that is squared and summed."""

from __future__ import annotations

import numpy as np

LARGEST_HALF = 65504.0
"""The largest half float; of radiance, also what infinity becomes."""

_ALL_BUT_SIGN, _INFINITE = np.uint16(0x7FFF), 0x7C00
"""Bits of a half float."""


def within_halves(image: np.ndarray) -> np.ndarray:
    """Radiance of any shape as float32, finite and within [0, 65504]; a new array only where something had to change.

    NaN becomes 0.
    """
    image = np.asarray(image, np.float32)
    if image.size and image.min() >= 0.0 and image.max() <= LARGEST_HALF:
        return image
    image = np.nan_to_num(image, nan=0.0, posinf=LARGEST_HALF, neginf=0.0)
    return np.clip(image, 0.0, LARGEST_HALF)


def are_finite(halves: np.ndarray) -> bool:
    """Whether all of some float16 of any shape, not empty, are; NumPy's own look takes five times as long."""
    return bool((halves.view(np.uint16) & _ALL_BUT_SIGN).max() < _INFINITE)
