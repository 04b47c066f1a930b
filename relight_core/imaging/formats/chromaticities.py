"""RGB spaces by the chromaticities of their primaries and white (CIE x, y)."""

from __future__ import annotations

import numpy as np

REC709 = np.array([0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290])
"""x and y of red, green, blue and white."""

_SAME = 2e-3
"""How far programs' rounded chromaticities lie from the standard."""


def is_rec709(chromaticities: np.ndarray) -> bool:
    """Whether (8,) chromaticities of red, green, blue and white are those of Rec.709 up to rounding."""
    return bool(np.abs(chromaticities - REC709).max() < _SAME)


def rgb_to_xyz(chromaticities: np.ndarray) -> np.ndarray:
    """(3, 3) linear RGB to XYZ, with a white of Y = 1.

    Args:
        chromaticities: (8,) x and y of red, green, blue and white.

    Raises:
        LinAlgError: the primaries lie in a line.
    """
    xy = chromaticities.reshape(4, 2)
    xyz = np.column_stack([xy[:, 0] / xy[:, 1], np.ones(4), (1 - xy.sum(axis=1)) / xy[:, 1]])
    return xyz[:3].T * np.linalg.solve(xyz[:3].T, xyz[3])


def to_rec709(to_xyz: np.ndarray) -> np.ndarray:
    """(3, 3) from a space to linear Rec.709, its white to the white of that.

    Args:
        to_xyz: (3, 3) from the space to XYZ.
    """
    target = rgb_to_xyz(REC709)
    return np.linalg.solve(target, adaptation(to_xyz.sum(axis=1), target.sum(axis=1)) @ to_xyz)


def adaptation(white: np.ndarray, target: np.ndarray) -> np.ndarray:
    """(3, 3) XYZ under one white to XYZ under another, by Bradford's cones."""
    cone = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
    gains = (cone @ target) / (cone @ white)
    return np.linalg.solve(cone, gains[:, None] * cone)
