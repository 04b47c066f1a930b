"""Upsampling of coarse panoramas that is smooth and keeps the mean of every old texel exactly."""

from __future__ import annotations

import numpy as np

from relight_core.lighting.panorama import shrink

COARSE_HEIGHT = 64
"""Panoramas with fewer rows, such as estimated lights, would show their texels as blocks."""

_ROUNDS = 4
"""Corrections of the interpolated map before the last, exact one."""
_TINY = np.float32(1e-12)


def enlarge(radiance: np.ndarray, height: int) -> np.ndarray:
    """Interpolate a panorama on a finer grid, across its seam and its poles, with every old texel's mean unchanged.

    Interpolation alone takes light from bright texels. So the result is multiplied a few times by the interpolated
    ratio of what each old texel should have to what it has, and finally by that ratio itself. Shrinking the result
    gives the old map back, and nothing becomes negative.

    Args:
        radiance: (H, 2H, C) linear, >= 0.
        height: rows of the result, a multiple of H; H itself copies.

    Returns:
        (height, 2 * height, C) float32.

    Raises:
        ValueError: another height.
    """
    coarse = radiance.shape[0]
    if height % coarse:
        raise ValueError(f"{height} rows are no multiple of {coarse}")
    old = np.maximum(radiance, np.float32(0.0)).astype(np.float32)
    if height == coarse:
        return old
    fine = _blended(old, height)
    for _ in range(_ROUNDS):
        fine *= _blended(_lacking(old, fine), height)
    fine *= shrink(_lacking(old, fine), height)
    return fine


def draw_finer(radiance: np.ndarray, height: int) -> np.ndarray:
    """A panorama with at least as many rows: interpolated if its texels would show, otherwise repeated.

    Args:
        radiance: (H, 2H, C) linear, >= 0.
        height: rows of the result, at least H.

    Returns:
        (height, 2 * height, C) float32. If the height is a multiple of H, every old texel keeps its mean; if it is H,
        this is `radiance` itself.
    """
    rows = radiance.shape[0]
    if rows == height:
        return radiance
    is_coarse = rows < COARSE_HEIGHT and height % rows == 0
    return enlarge(radiance, height) if is_coarse else shrink(radiance, height)


def _lacking(old: np.ndarray, fine: np.ndarray) -> np.ndarray:
    """Each old texel over the fine map's mean in it."""
    return old / np.maximum(shrink(fine, old.shape[0]), _TINY)


def _blended(coarse: np.ndarray, height: int) -> np.ndarray:
    """Bilinear between the centres of texels; across a pole lies what is half a turn away."""
    rows, columns = coarse.shape[:2]
    over = np.roll(coarse, columns // 2, axis=1)
    padded = np.concatenate([over[:1], coarse, over[-1:]])
    padded = np.concatenate([padded[:, -1:], padded, padded[:, :1]], axis=1)
    times = height // rows
    import cv2  # the command line names lights without drawing any

    size = (padded.shape[1] * times, padded.shape[0] * times)
    grown = cv2.resize(padded, size, interpolation=cv2.INTER_LINEAR).reshape(size[1], size[0], -1)
    return np.ascontiguousarray(grown[times:-times, times:-times])
