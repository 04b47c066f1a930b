"""Colours that a display transform has to survive."""

import numpy as np


def hostile_colours():
    """(N, 3) random radiance over many magnitudes, and every pair of troublesome values."""
    rng = np.random.default_rng(7)
    values = [0.0, -0.0, 1.0, 1.0001, 0.0031308, 1e-30, 65504.0, 1e30, -1.0, np.nan, np.inf, -np.inf]
    grid = np.array(np.meshgrid(values, values, [0.0, 0.5, 3.0])).reshape(3, -1).T
    magnitudes = rng.random((3000, 3)) * 10.0 ** rng.uniform(-4, 4, (3000, 1))
    return np.concatenate([grid, magnitudes, rng.random((3000, 3))]).astype(np.float32)
