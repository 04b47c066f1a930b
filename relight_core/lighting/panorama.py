"""Averages of lat-long panoramas, weighted by solid angle: in larger texels, over the sphere, and after a rotation.

They are exact under the assumption that radiance is constant over each texel's patch of the sphere.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from relight_core.imaging.colour import REC709_LUMINANCE
from relight_core.lighting.sphere import turn_fraction

_BLOCK_ROWS = 64
"""Rows that are converted to float64 at once, to save memory."""
_BALANCINGS = 300
"""Iterations in which the weights of `_spread_row_overlaps` converge."""


def rotate(radiance: np.ndarray, yaw_deg: float) -> np.ndarray:
    """Rotate a panorama about +y; positive moves its content to the right.

    Between two whole texels the result is the linear mix of the two rotations by whole texels. So every row keeps
    its sum, and the result changes evenly with the angle. 360 degrees is the identity, bit for bit.

    Args:
        radiance: (H, W, C) or (H, W).
        yaw_deg: any finite angle in degrees.

    Returns:
        A new array of the same shape and type.

    Raises:
        ValueError: the angle is NaN or infinite.
    """
    width = radiance.shape[1]
    shift = turn_fraction(yaw_deg) * width
    whole = math.floor(shift)
    part = shift - whole
    turned = np.roll(radiance, whole, axis=1)
    if part == 0.0:
        return turned
    further = np.roll(turned, 1, axis=1)
    mixed = turned * np.float64(1.0 - part) + further * np.float64(part)
    return mixed.astype(radiance.dtype)


def shrink(radiance: np.ndarray, height: int) -> np.ndarray:
    """Average a panorama over the texels of a smaller one, by exact solid angle.

    Texels that overlap in part count by the exact overlap (a band between two latitudes by its difference of
    cosines). So the energy, the sum of radiance times solid angle, is kept for any ratio. A larger height repeats
    texels.

    Args:
        radiance: (H, W, C) linear.
        height: rows of the result, at least 1.

    Returns:
        (height, 2 * height, C) float32.
    """
    whole = radiance.shape[1] // (2 * height)
    if whole * 2 * height == radiance.shape[1]:
        return _shrink_rows(radiance, height, whole).astype(np.float32)
    rows = _shrink_rows(radiance, height)
    overlaps = _column_overlaps(rows.shape[1], 2 * height)
    return np.einsum("ij,hjc->hic", overlaps, rows, optimize=True).astype(np.float32)


def mean_luminance(radiance: np.ndarray) -> float:
    """Mean Rec.709 luminance of an (H, W, 3) panorama over the sphere."""
    return float(row_shares(len(radiance)) @ (radiance.mean(axis=1, dtype=np.float64) @ REC709_LUMINANCE))


def normalise_light(light: np.ndarray) -> np.ndarray:
    """A light (H, W, 3) divided by its mean luminance over the sphere, as of `Environment`, float32; black stays so."""
    return (light / max(mean_luminance(light), 1e-12)).astype(np.float32)


def mean_radiance(radiance: np.ndarray) -> np.ndarray:
    """Mean colour (3,) of an (H, W, 3) panorama over the sphere, float64."""
    return row_shares(len(radiance)) @ radiance.mean(axis=1, dtype=np.float64)


def row_shares(height: int) -> np.ndarray:
    """The share of the sphere that each row of a panorama covers, (height,) float64 of sum 1."""
    return -np.diff(np.cos(np.pi * np.arange(height + 1) / height)) / 2


def column_sums(radiance: np.ndarray, height: int) -> np.ndarray:
    """(H, W, C) to (height, W + 1, C) float64: the part of `turned_means` that doesn't depend on the angle.

    Rows are averaged, texels spread (see `environment.network_light`), and then summed up along each row.
    """
    return _running_sums(_spread(_evenly_shrunk_rows(radiance, height), 2 * height))


def turned_means(sums: np.ndarray, yaw_deg: float) -> np.ndarray:
    """Means over the texels of a smaller map after a rotation as by `rotate`, (h, 2 h, C) float64.

    Args:
        sums: (h, W + 1, C), the panorama's `column_sums`.
        yaw_deg: any finite angle in degrees.

    Raises:
        ValueError: the angle is NaN or infinite.
    """
    count, width = 2 * len(sums), sums.shape[1] - 1
    edges = np.arange(count + 1) / count - turn_fraction(yaw_deg)
    return np.diff(_sum_up_to(sums, edges * width), axis=1) * (count / width)


def _overlap_weights(edges: np.ndarray, new_edges: np.ndarray) -> np.ndarray:
    """The share of each new interval that each old one covers, (new, old) float64; rows sum to 1.

    Args:
        edges, new_edges: ascending, with the same first and last one.
    """
    low = np.maximum(edges[None, :-1], new_edges[:-1, None])
    high = np.minimum(edges[None, 1:], new_edges[1:, None])
    overlaps = np.maximum(high - low, 0.0)
    return overlaps / overlaps.sum(axis=1, keepdims=True)


@lru_cache(maxsize=16)
def _row_overlaps(height: int, new_height: int) -> np.ndarray:
    def edges(count: int) -> np.ndarray:
        return -np.cos(np.pi * np.arange(count + 1) / count)

    return _overlap_weights(edges(height), edges(new_height))


@lru_cache(maxsize=16)
def _column_overlaps(width: int, new_width: int) -> np.ndarray:
    return _overlap_weights(np.arange(width + 1) / width, np.arange(new_width + 1) / new_width)


def _shrink_rows(radiance: np.ndarray, height: int, columns: int = 1) -> np.ndarray:
    """(H, W, C) to (height, W / columns, C) float64.

    Args:
        columns: how many are averaged into one; divides W.
    """
    return _block_sums(radiance, _row_overlaps(radiance.shape[0], height), columns)


def _block_sums(radiance: np.ndarray, overlaps: np.ndarray, columns: int = 1) -> np.ndarray:
    """Rows (H, W, C) weighted by `overlaps` (height, H), a few at a time, since a map may fill gigabytes."""
    (height, old_height), (_, width, channels) = overlaps.shape, radiance.shape
    width //= columns
    result = np.zeros((height, width * channels))
    for start in range(0, old_height, _BLOCK_ROWS):
        block = slice(start, min(start + _BLOCK_ROWS, old_height))
        touched = np.flatnonzero(overlaps[:, block].any(axis=1))
        rows = radiance[block].reshape(-1, width, columns, channels).mean(axis=2, dtype=np.float64)
        result[touched] += overlaps[touched, block] @ rows.reshape(-1, width * channels)
    return result.reshape(height, width, channels)


def _evenly_shrunk_rows(radiance: np.ndarray, height: int) -> np.ndarray:
    """(H, W, C) to (height, W, C) float64; rows that are lower than a new one are first spread to its height.

    Beyond a pole a meridian goes on as the opposite one.
    """
    if radiance.shape[0] <= height:
        return _shrink_rows(radiance, height)
    before, beyond = (_block_sums(radiance, overlaps) for overlaps in _spread_row_overlaps(radiance.shape[0], height))
    return before + np.roll(beyond, radiance.shape[1] // 2, axis=1)


@lru_cache(maxsize=16)
def _spread_row_overlaps(height: int, new_height: int) -> tuple[np.ndarray, np.ndarray]:
    """As `_row_overlaps`, with old rows spread to the height of a new one: what lies before the poles, and beyond them.

    The weights are balanced until even light stays even and no row loses energy (Sinkhorn and Knopp, 1967).
    """
    edges, half = np.linspace(0.0, np.pi, new_height + 1), np.pi / new_height / 2
    middles = (np.arange(height) + 0.5) * np.pi / height
    centres = np.concatenate([middles, -middles, 2 * np.pi - middles])
    overlaps = np.minimum(centres + half, edges[1:, None]) - np.maximum(centres - half, edges[:-1, None])
    parts = np.maximum(overlaps, 0.0).reshape(new_height, 3, height)
    energy = parts.sum(1)
    share_beyond = parts[:, 1:].sum(1) / np.maximum(energy, np.finfo(float).tiny)
    given, wanted = row_shares(height), row_shares(new_height)
    for _ in range(_BALANCINGS):
        energy *= (wanted / energy.sum(1))[:, None]
        energy *= given / energy.sum(0)
    weights = energy / energy.sum(1, keepdims=True)
    return weights * (1 - share_beyond), weights * share_beyond


def _spread(rows: np.ndarray, new_width: int) -> np.ndarray:
    """Every texel of (H, W, C) spread along its row to the width of a texel of `new_width`, if that is wider."""
    span = rows.shape[1] / new_width
    if span <= 1:
        return rows
    sums, centres = _running_sums(rows), np.arange(rows.shape[1]) + 0.5
    return (_sum_up_to(sums, centres + span / 2) - _sum_up_to(sums, centres - span / 2)) / span


def _running_sums(rows: np.ndarray) -> np.ndarray:
    """(H, W + 1, C) sums of the columns to the left of each texel edge."""
    return np.concatenate([np.zeros_like(rows[:, :1]), np.cumsum(rows, axis=1)], axis=1)


def _sum_up_to(sums: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Integral along each row from 0 to each position; the function is constant in a texel, and periodic.

    Args:
        sums: (H, W + 1, C) running sums, starting with 0.
        positions: (N,) in texels, any sign.

    Returns:
        (H, N, C).
    """
    width = sums.shape[1] - 1
    turns = np.floor(positions / width)
    within = np.clip(positions - turns * width, 0.0, width)
    left = np.minimum(within.astype(np.intp), width - 1)
    part = (within - left)[None, :, None]
    inside = sums[:, left] * (1.0 - part) + sums[:, left + 1] * part
    return inside + turns[None, :, None] * sums[:, -1:]
