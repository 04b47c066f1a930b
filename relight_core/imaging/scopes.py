"""Histogram and waveform of a picture as the screen shows it, and how much of it the screen can't show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from relight_core.imaging.half_floats import LARGEST_HALF
from relight_core.imaging.view_transform import expose

LEVELS = 256
_HISTOGRAM_ROWS = 96
_GAMMA = 0.55
"""Of the waveform's brightness: so that a few pixels of a value are seen beside thousands of another."""


@dataclass(frozen=True)
class Extremes:
    """What share of a picture the screen shows wrongly, each in [0, 1].

    Attributes:
        too_dark: black in every channel though light may be there.
        too_bright: at least one channel as bright as the screen gets, or beyond.
        no_number: NaN or infinite in at least one channel.
    """

    too_dark: float
    too_bright: float
    no_number: float


def thinned(pixels: np.ndarray, most: int = 1 << 15) -> np.ndarray:
    """Every n-th row and column of (H, W, ...), such that about `most` pixels are left; a view."""
    step = thinning_step(pixels.shape[:2], most)
    return pixels[::step, ::step]


def thinning_step(size: tuple[int, int], most: int = 1 << 15) -> int:
    """Which n leaves about `most` pixels of a picture of (height, width)."""
    return max(1, int(np.ceil(np.sqrt(size[0] * size[1] / most))))


def histogram(codes: np.ndarray, seen: np.ndarray | None = None) -> np.ndarray:
    """How many pixels have each code.

    Args:
        codes: (H, W, 3) uint8 sRGB.
        seen: (H, W) bool, the pixels that count: what is transparent has colours that nobody sees. None counts all.

    Returns:
        (3, 256) int64: red, green, blue.
    """
    counted = codes if seen is None else codes[seen]
    return np.stack([np.bincount(counted[..., channel].ravel(), minlength=LEVELS) for channel in range(3)])


def waveform(codes: np.ndarray, columns: int = 256, rows: int = 128, seen: np.ndarray | None = None) -> np.ndarray:
    """How many pixels of each column of the picture have each code.

    Args:
        codes: (H, W, 3) uint8 sRGB.
        columns, rows: of the result; row 0 is the brightest code.
        seen: (H, W) bool, the pixels that count; None counts all.

    Returns:
        (rows, columns, 3) int64. Where the picture has fewer columns than the result, they repeat.
    """
    seen = np.ones(codes.shape[:2], bool) if seen is None else seen
    if codes.shape[1] < columns:
        taken = np.arange(columns) * codes.shape[1] // columns
        codes, seen = codes[:, taken], seen[:, taken]
    across = np.arange(codes.shape[1]) * columns // codes.shape[1]
    result = np.empty((rows, columns, 3), np.int64)
    for channel in range(3):
        down = rows - 1 - codes[..., channel].astype(np.int64) * rows // LEVELS
        counts = np.bincount((down * columns + across)[seen], minlength=rows * columns)
        result[..., channel] = counts.reshape(rows, columns)
    return result


def histogram_picture(codes: np.ndarray, seen: np.ndarray | None = None) -> np.ndarray:
    """The histogram as columns of light: where red, green and blue overlap they add up to white.

    Codes 0 and 255 do not set the scale, since a black or white backdrop would flatten all the rest.

    Returns:
        (96, 256, 4) uint8: colour, and coverage.
    """
    counts = histogram(codes, seen).astype(np.float64)
    smooth = (np.roll(counts, 1, 1) + 2 * counts + np.roll(counts, -1, 1)) / 4
    smooth[:, [0, -1]] = counts[:, [0, -1]]
    top = max(smooth[:, 2:-2].max(), 1.0)
    heights = np.minimum(smooth / top, 1.0) * _HISTOGRAM_ROWS
    from_below = np.arange(_HISTOGRAM_ROWS, 0, -1)[:, None, None] - 0.5
    filled = np.clip(heights.T[None] - from_below + 0.5, 0, 1)
    coverage = filled.max(axis=-1, keepdims=True)
    colour = 0.12 + 0.5 * filled
    return _codes(np.concatenate([colour, coverage], axis=-1))


def waveform_picture(codes: np.ndarray, seen: np.ndarray | None = None) -> np.ndarray:
    """The waveform as light: the more pixels, the brighter. (rows, columns, 4) uint8: colour, and coverage."""
    counts = waveform(codes, seen=seen).astype(np.float64)
    rows, columns = counts.shape[:2]
    share = counts * rows / max(codes.shape[0] * max(codes.shape[1] / columns, 1.0), 1.0)
    light = np.clip(share / 6.0, 0, 1) ** _GAMMA
    return _codes(np.concatenate([light, light.max(axis=-1, keepdims=True)], axis=-1))


def extremes(linear: np.ndarray, exposure_ev: float = 0.0, seen: np.ndarray | None = None) -> Extremes:
    """What share of a picture the screen can't show.

    Args:
        linear: (H, W, 3) radiance, any float type.
        exposure_ev: stops.
        seen: (H, W) bool, the pixels that count; None counts all. Where none does, there are no extremes.
    """
    linear = linear if seen is None else linear[seen]
    if linear.size == 0:
        return Extremes(0.0, 0.0, 0.0)
    # Half floats hold infinity as their largest number.
    bad = ~np.isfinite(linear).all(axis=-1) | (linear >= LARGEST_HALF).any(axis=-1)
    peak = expose(linear, exposure_ev).max(axis=-1)
    bright = (peak >= 1.0) & ~bad
    dark = (peak * (12.92 * 255) < 0.5) & ~bad
    return Extremes(float(dark.mean()), float(bright.mean()), float(bad.mean()))


def _codes(values: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(np.rint(np.clip(values, 0, 1) * 255).astype(np.uint8))
