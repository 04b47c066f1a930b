"""Blur of a light on the sphere, isotropic and energy-conserving."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from relight_core.lighting.panorama import row_shares, shrink
from relight_core.lighting.sphere import directions

LARGEST_BLUR_DEG = 90.0
BLURRED_HEIGHT = 128
"""Rows a blurred map keeps at most."""

_BALANCING_STEPS = 60
"""Iterations in which the kernel is balanced."""


def blur_light(radiance: np.ndarray, blur_deg: float) -> np.ndarray:
    """Blur a panorama with a kernel that is a Gaussian of the angle between two directions.

    The kernel is balanced on the map's texels, so that the sum of radiance times solid angle is kept and an even
    light stays even. Along the rows it is a circular convolution, done by Fourier transform. A kernel narrower than
    half a texel can't be sampled; a blur of half a texel is then mixed with the map, so that a slider starts without
    a jump.

    Args:
        radiance: (H, 2H, C) linear.
        blur_deg: standard deviation, [0, 90]; 0 returns the argument.

    Returns:
        (h, 2h, C) float32; h is at most 128, or H if the blur is less than half a texel of such a map.

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
    """A map (h, 2h, C) blurred by a kernel of at least half a texel."""
    kernel = _kernel(small.shape[0], blur_deg)
    spectrum = np.fft.rfft(small, axis=1)
    mixed = np.einsum("ijm,jmc->imc", kernel, spectrum, optimize=True)
    return np.maximum(np.fft.irfft(mixed, n=small.shape[1], axis=1), 0.0).astype(np.float32)


@lru_cache(maxsize=4)
def _kernel(height: int, blur_deg: float) -> np.ndarray:
    """The balanced kernel times the solid angle of the rows in, as (rows out, rows in, frequencies along a row)."""
    toward = directions(height, 2 * height).astype(np.float64)
    cosines = np.clip(np.einsum("ic,jwc->ijw", toward[:, 0], toward), -1.0, 1.0)
    weights = np.exp(-0.5 * (np.arccos(cosines) / np.radians(blur_deg)) ** 2)
    bands = 2 * row_shares(height)
    row_weights = weights.sum(axis=2) * bands
    gains = np.ones(height)
    for _ in range(_BALANCING_STEPS):
        gains = np.sqrt(gains / (row_weights @ gains))
    gains /= np.sqrt(gains @ (row_weights @ gains) / height)
    # One last step makes the energy that each row gives exact.
    rows = gains[:, None] * row_weights * gains[None, :]
    spread = (bands @ rows) / bands
    balanced = weights * (gains[:, None] * (gains * bands / spread)[None, :])[..., None]
    return np.fft.rfft(balanced, axis=2)
