"""Calibrated probabilities from a parsing that was trained with the focal loss."""

from __future__ import annotations

import numpy as np

_FOCUS = 2.0
"""The loss's exponent (paper, Eq. 4: eta)."""
_LEAST = 1e-6


def posterior(parsing: np.ndarray) -> np.ndarray:
    """Undo the underconfidence that the focal loss teaches.

    The loss is smallest if the likeliest class gets too low a probability and all others too high a one: for a pixel
    that is nine tenths background it is seven tenths. The true probabilities can be computed from the network's
    (Charoenphakdee et al. 2021, On focal loss for class-posterior probability estimation).

    Args:
        parsing: (classes, ...) in [0, 1], the softmax of a network; sums to 1.

    Returns:
        (classes, ...) float32 in [0, 1], sums to 1; the likeliest class is the same.
    """
    predicted = np.clip(parsing, _LEAST, 1 - _LEAST).astype(np.float32)
    others = 1 - predicted
    weight = predicted / (others**_FOCUS - _FOCUS * others ** (_FOCUS - 1) * predicted * np.log(predicted))
    return weight / weight.sum(0, keepdims=True)
