"""How often colours occur in one part of a picture and in another, and which of both a pixel's colour tells of."""

from __future__ import annotations

import cv2
import numpy as np

_BINS = 16
_BLUR_BINS = 0.8
_UNSEEN = 2e-4
"""Share that any colour has, seen or not."""


def bins_of(srgb: np.ndarray) -> np.ndarray:
    """(..., 3) sRGB in [0, 1] as the indices, in [0, 15], of coarse colours."""
    return (srgb * _BINS).astype(np.intp).clip(0, _BINS - 1)


def shares_of(bins: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """How often each colour occurs, (16, 16, 16), somewhat blurred; sums to 1 unless nothing weighs.

    Args:
        bins: (h, w, 3), see `bins_of`.
        weight: (h, w) >= 0, how much each pixel counts.
    """
    places = np.ravel_multi_index(tuple(bins.reshape(-1, 3).T), (_BINS,) * 3)
    counts = np.bincount(places, weight.ravel(), _BINS**3).reshape((_BINS,) * 3)
    for axis in range(3):
        flat = np.ascontiguousarray(np.moveaxis(counts, axis, 0).reshape(_BINS, -1))
        flat = cv2.GaussianBlur(flat, (1, 7), 0, sigmaY=_BLUR_BINS, borderType=cv2.BORDER_REPLICATE)
        counts = np.moveaxis(flat.reshape((_BINS,) * 3), 0, axis)
    return counts / max(float(counts.sum()), 1e-9)


def log_odds(bins: np.ndarray, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """How much likelier each pixel's colour, (..., 3) bins, is by `one` share of colours than by another: (...)."""
    return np.log((one + _UNSEEN) / (other + _UNSEEN))[tuple(np.moveaxis(bins, -1, 0))]
