"""A light in the camera space of a camera that is rolled about its viewing axis."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from relight_core.lighting.panorama import mean_luminance, shrink
from relight_core.lighting.sphere import directions, place_on_map

_FINER = 4
"""The rolled map is sampled with so many times the result's rows and columns and then averaged."""


def roll_light(radiance: np.ndarray, roll_deg: float, height: int | None = None) -> np.ndarray:
    """A panorama in the camera space of a camera that is rolled counterclockwise, seen in viewing direction.

    A lamp above the upright camera moves to the right of the rolled one. The mean luminance is kept.

    Args:
        radiance: (H, 2H, 3) linear.
        roll_deg: of the camera, as a crop has it.
        height: rows of the result; None keeps those of the panorama. Rolling and shrinking in one step blurs small
            lamps once; shrinking before would blur them twice.

    Returns:
        (height, 2 * height, 3) float32; for a roll of 0 the panorama shrunk, or itself if it has that height.
    """
    rows = radiance.shape[0]
    height = height or rows
    if roll_deg == 0:
        return radiance if height == rows else shrink(radiance, height)
    rolled = shrink(radiance[_texels(rows, _FINER * height, float(roll_deg))], height)
    before, after = mean_luminance(radiance), mean_luminance(rolled)
    return rolled * np.float32(before / after if after > 0 else 1.0)


@lru_cache(maxsize=16)
def _texels(rows: int, height: int, roll_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Row and column of the panorama's texel that each texel of the rolled map shows, both (height, 2 * height)."""
    x, y, z = np.moveaxis(directions(height, 2 * height).astype(np.float64), -1, 0)
    angle = np.radians(roll_deg)
    across, up = np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y
    from_left, from_top = place_on_map(across, up, z)
    column = np.floor(from_left * 2 * rows).astype(np.intp) % (2 * rows)
    return np.clip(np.floor(from_top * rows).astype(np.intp), 0, rows - 1), column
