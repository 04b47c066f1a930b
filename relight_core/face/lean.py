"""The angle by which a head leans, from the eyes and brows in its parsing."""

from __future__ import annotations

import numpy as np

from relight_core.face.parsing import INDEX

_PAIRS = (("right_eye", "left_eye"), ("right_brow", "left_brow"))
_FEWEST_PIXELS = 2
"""Pixels that an eye or a brow must have."""
_LARGEST_DEG = 35.0
"""A larger angle is taken for an error of the parsing."""


def remaining_roll(labels: np.ndarray) -> float:
    """The angle in degrees by which the head in a view still leans to the view's left; 0 if that can't be told.

    The line through both eyes and the one through both brows lie across the head; one of them is enough.

    Args:
        labels: (S, S) parsing labels of the view.
    """
    lines = [line for line in (_between(labels, *pair) for pair in _PAIRS) if line is not None]
    if not lines:
        return 0.0
    across, down = np.sum(lines, axis=0)
    angle = float(np.degrees(np.arctan2(-down, across)))
    return angle if abs(angle) <= _LARGEST_DEG else 0.0


def _between(labels: np.ndarray, first: str, second: str) -> np.ndarray | None:
    """x, y from the centre of one part of the face to that of another; None if either is not visible."""
    middles = []
    for name in (first, second):
        rows, columns = np.nonzero(labels == INDEX[name])
        if rows.size < _FEWEST_PIXELS:
            return None
        middles.append(np.array([columns.mean(), rows.mean()]))
    return middles[1] - middles[0]
