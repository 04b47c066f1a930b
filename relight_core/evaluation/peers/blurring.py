"""A blur that looks at the head alone."""

from __future__ import annotations

import cv2
import numpy as np


def blurred_within(image: np.ndarray, weight: np.ndarray, deviation_px: float) -> np.ndarray:
    """Gaussian means (S, S, C) of an image over the pixels that count.

    Args:
        weight: (S, S) float32, 1 where a pixel counts and 0 elsewhere.
    """
    total = cv2.GaussianBlur(image * weight[..., None], (0, 0), deviation_px)
    return total / np.maximum(cv2.GaussianBlur(weight, (0, 0), deviation_px), 1e-4)[..., None]
