"""Hair in a great mass around a head, as a mesh: an afro, curls or waves that stand off it and leave the face free.

A shell grown from the scalp cannot be it: what stands off by more than a hand's breadth is a wall seen from the front.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import label

from relight_core.dataset.garments.field_mesh import enclosed, grid_between
from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_mesh import fractal

_SKULL_CM, _SKULL_RADII_CM = np.array([0.0, 6.5, -1.0]), np.array([8.5, 10.5, 10.0])
_FACE_CM, _FACE_RADII_CM = np.array([0.0, -1.5, 13.0]), np.array([8.6, 12.0, 13.0])
_STEP_CM = 0.5


def grow_mass(rng: np.random.Generator) -> Garment:
    """A mass of hair for heads of a head model's usual size, in its frame."""
    thick = rng.uniform(3, 12)
    around = _SKULL_RADII_CM + thick * np.array([rng.uniform(0.8, 1.2), rng.uniform(0.6, 1.0), 0.8])
    middle = _SKULL_CM + np.array([rng.normal(0, 0.15) * thick, 0, -0.15 * thick])
    free = _FACE_RADII_CM * np.exp(rng.normal(0, 0.06, 3))
    lowest = rng.uniform(-20, 2)
    low, high = np.maximum(middle - 1.3 * around, [-40, lowest - 3, -40]), middle + 1.3 * around
    grid = grid_between(low, high, _STEP_CM)
    curls = rng.uniform(0.15, 0.5) * _noise(grid, rng, rng.uniform(1.5, 4))
    locks = rng.uniform(0.1, 0.12) * thick * _noise(grid, rng, rng.uniform(6, 16))
    outside = np.maximum(_beyond(grid, middle, around) + locks, lowest - grid[..., 1] + 2 * locks)
    outside = np.maximum(outside, -_beyond(grid, _FACE_CM, free)) + curls
    return Garment(*enclosed(_in_one_piece(-outside), low, _STEP_CM), "hair", name="mass")


def _in_one_piece(inside: np.ndarray) -> np.ndarray:
    """The field (X, Y, Z), positive inside, without the crumbs that noise leaves in the air."""
    pieces, _ = label(inside > 0)
    largest = np.bincount(pieces.ravel())[1:].argmax() + 1
    return np.where((pieces == largest) | (inside <= 0), inside, -1e-3)


def _beyond(grid: np.ndarray, middle: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """About how far points (..., 3) are outside an ellipsoid, in centimetres."""
    scaled = (grid - middle.astype(np.float32)) / radii.astype(np.float32)
    return (np.sqrt(np.einsum("...c,...c->...", scaled, scaled)) - 1) * float(radii.min())


def _noise(grid: np.ndarray, rng: np.random.Generator, wavelength_cm: float) -> np.ndarray:
    return fractal(grid.reshape(-1, 3), rng, wavelength_cm, 3).reshape(grid.shape[:-1])
