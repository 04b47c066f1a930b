"""A light out of focus: blurred on the sphere, alike in all directions, without losing energy."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from relight_core.lighting.panorama import row_shares, shrink
from relight_core.lighting.sphere import directions

LARGEST_BLUR_DEG = 90.0
BLURRED_HEIGHT = 128
"""Rows a blurred map keeps at most."""

_BALANCING_STEPS = 60


def blur_light(radiance: np.ndarray, blur_deg: float) -> np.ndarray:
    """Average a panorama with a Gaussian of the angle on the sphere.

    The kernel is balanced on the map's own texels, so that the sum of radiance times solid angle stays and an
    even light stays even. Sideways it is a circular convolution, done by Fourier transform. Below half a texel a kernel
    would not be sampled: that blur is mixed into the map itself, so that the first tick of a slider is no leap.

    Args:
        radiance: (H, 2H, C) linear.
        blur_deg: standard deviation, [0, 90]; 0 returns the argument.

    Returns:
        (h, 2h, C) float32; h at most 128, or H where the blur is less than half a texel of that.

    Raises:
        ValueError: a blur out of range.
    """
    if not 0.0 <= blur_deg <= LARGEST_BLUR_DEG:
        raise ValueError(f"a blur is from 0 to {LARGEST_BLUR_DEG:g} degrees, not {blur_deg}")
    if blur_deg == 0.0:
        return radiance
    small = shrink(radiance, BLURRED_HEIGHT) if radiance.shape[0] > BLURRED_HEIGHT else radiance
    least_deg = 90.0 / small.shape[0]
    if blur_deg < least_deg:
        blurred = shrink(_blurred(small, least_deg), radiance.shape[0])
        return radiance + np.float32((blur_deg / least_deg) ** 2) * (blurred - radiance)
    return _blurred(small, float(blur_deg))


def _blurred(small: np.ndarray, blur_deg: float) -> np.ndarray:
    kernel = _kernel(small.shape[0], blur_deg)
    spectrum = np.fft.rfft(small, axis=1)
    mixed = np.einsum("ijm,jmc->imc", kernel, spectrum, optimize=True)
    return np.maximum(np.fft.irfft(mixed, n=small.shape[1], axis=1), 0.0).astype(np.float32)


@lru_cache(maxsize=4)
def _kernel(height: int, blur_deg: float) -> np.ndarray:
    """(rows out, rows in, frequencies) of the balanced kernel times the solid angle of the rows in."""
    toward = directions(height, 2 * height).astype(np.float64)
    cosines = np.clip(np.einsum("ic,jwc->ijw", toward[:, 0], toward), -1.0, 1.0)
    weights = np.exp(-0.5 * (np.arccos(cosines) / np.radians(blur_deg)) ** 2)
    bands = 2 * row_shares(height)
    row_weights = weights.sum(axis=2) * bands
    gains = np.ones(height)
    for _ in range(_BALANCING_STEPS):
        gains = np.sqrt(gains / (row_weights @ gains))
    gains /= np.sqrt(gains @ (row_weights @ gains) / height)
    # One last exact step for the energy of every row that is spread.
    rows = gains[:, None] * row_weights * gains[None, :]
    spread = (bands @ rows) / bands
    balanced = weights * (gains[:, None] * (gains * bands / spread)[None, :])[..., None]
    return np.fft.rfft(balanced, axis=2)
