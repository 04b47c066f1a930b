"""A relief with the slopes that normals say: what a face's shadows need is the height of its nose.

Heights of one photo are guesswork, slopes are plain to see. The result follows the slopes of the normals and
stays near the given heights: a screened Poisson equation (Bhat et al. 2008), solved exactly by cosine
transforms.
"""

from __future__ import annotations

import numpy as np
from scipy.fft import dctn, idctn

_PULL = 4e-3
_STEEPEST = 2.0
_LEAST_FACING = 0.15


def integrate_normals(relief: np.ndarray, normal: np.ndarray, trust: np.ndarray, slope_gain: float = 1.0) -> np.ndarray:
    """Sharpen a relief by normals.

    Args:
        relief: (S, S) height toward the camera, in half-widths of the image.
        normal: (3, S, S) unit vectors, camera space.
        trust: (S, S) in [0, 1]: where normals are known; elsewhere the relief keeps its own slopes.
        slope_gain: the normals' slopes are multiplied by it.

    Returns:
        (S, S) float32, of the same mean as `relief`.
    """
    size = len(relief)
    facing = np.maximum(normal[2], _LEAST_FACING)
    slopes = (slope_gain * s / facing for s in (-normal[0], normal[1]))
    to_right, down = (np.clip(slope, -_STEEPEST, _STEEPEST) * (2 / size) for slope in slopes)
    divergence = _divergence(_steps(relief, to_right, trust, 1), 1) + _divergence(_steps(relief, down, trust, 0), 0)
    frequency = 2 - 2 * np.cos(np.pi * np.arange(size) / size)
    laplacian = frequency[:, None] + frequency[None]
    spectrum = _PULL * dctn(relief, norm="ortho") - dctn(divergence, norm="ortho")
    return idctn(spectrum / (laplacian + _PULL), norm="ortho").astype(np.float32)


def _steps(relief: np.ndarray, slope: np.ndarray, trust: np.ndarray, axis: int) -> np.ndarray:
    """Height differences between neighbours along an axis, as the normals or the relief itself have them."""
    first, second = _neighbours(slope, axis)
    sure = np.minimum(*_neighbours(trust, axis))
    return sure * (first + second) / 2 + (1 - sure) * np.diff(relief, axis=axis)


def _neighbours(image: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    count = image.shape[axis] - 1
    return image.take(range(count), axis), image.take(range(1, count + 1), axis)


def _divergence(steps: np.ndarray, axis: int) -> np.ndarray:
    """Of differences between neighbours, nothing flowing over the border."""
    border = [(0, 0), (0, 0)]
    border[axis] = (1, 1)
    return np.diff(np.pad(steps, border), axis=axis)
