"""By how much a head leans, from where its parsing map has the eyes and brows."""

from __future__ import annotations

import numpy as np

from relight_core.face.parsing import INDEX

_SIDES = (("right_eye", "right_brow"), ("left_eye", "left_brow"))
_FEWEST_PIXELS = 6
_LARGEST_DEG = 35.0


def remaining_roll(labels: np.ndarray) -> float:
    """How far the head in a view still leans to the left of it, in degrees; 0 where that can't be seen.

    Where both eyes are in sight, they and the brows above them lie on a line across the head.

    Args:
        labels: (S, S) parsing labels of the view.
    """
    middles = [_middle(labels, names) for names in _SIDES]
    if any(middle is None for middle in middles):
        return 0.0
    across, down = middles[1] - middles[0]
    angle = float(np.degrees(np.arctan2(-down, across)))
    return angle if abs(angle) <= _LARGEST_DEG else 0.0


def _middle(labels: np.ndarray, names: tuple[str, str]) -> np.ndarray | None:
    """x, y halfway between an eye and its brow; None where either is out of sight."""
    middles = []
    for name in names:
        rows, columns = np.nonzero(labels == INDEX[name])
        if rows.size < _FEWEST_PIXELS:
            return None
        middles.append((columns.mean(), rows.mean()))
    return np.mean(middles, axis=0)
