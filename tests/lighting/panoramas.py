"""Panoramas of noise and of one lit texel, and angles to turn them by."""

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

ANGLES = st.floats(-1000, 1000, allow_nan=False)
quick = settings(deadline=None, max_examples=40)


def noise(height: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).exponential(size=(height, 2 * height, 3)).astype(np.float32)


def lamp(height: int, row: int, column: int, radiance: float = 1e6) -> np.ndarray:
    panorama = np.zeros((height, 2 * height, 3), np.float32)
    panorama[row, column] = radiance
    return panorama
