"""Probabilities out of a parsing that was learnt with the focal loss."""

from __future__ import annotations

import numpy as np

_FOCUS = 2.0
"""The loss's exponent (paper, Eq. 4: eta)."""
_LEAST = 1e-6


def posterior(parsing: np.ndarray) -> np.ndarray:
    """How likely each class is, where the focal loss made the network say less than it knows.

    That loss is smallest where the likeliest class gets too little and all others too much: a pixel that is nine
    tenths background is called seven tenths. What is likely follows from what is said (Charoenphakdee et al. 2021,
    On focal loss for class-posterior probability estimation).

    Args:
        parsing: (classes, ...) in [0, 1], the softmax of a network; sums to 1.

    Returns:
        (classes, ...) float32 in [0, 1], sums to 1; the likeliest class is the same.
    """
    said = np.clip(parsing, _LEAST, 1 - _LEAST).astype(np.float32)
    left = 1 - said
    weight = said / (left**_FOCUS - _FOCUS * left ** (_FOCUS - 1) * said * np.log(said))
    return weight / weight.sum(0, keepdims=True)
