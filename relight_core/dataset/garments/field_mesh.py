"""Meshes of what a field encloses, for things that are grown around something or melted together."""

from __future__ import annotations

import numpy as np
from skimage.measure import marching_cubes

_UV_CM = 90.0


def grid_between(low: np.ndarray, high: np.ndarray, step_cm: float) -> np.ndarray:
    """Places (X, Y, Z, 3) float32, `step_cm` apart along each axis, from one corner (3,) toward another."""
    axes = [np.arange(first, last, step_cm, dtype=np.float32) for first, last in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1)


def enclosed(inside: np.ndarray, low: np.ndarray, step_cm: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The surface, facing outward, of where a field is positive.

    Args:
        inside: (X, Y, Z) of the places of `grid_between`, which begin at `low` (3,).

    Returns:
        vertices (V, 3) float32 cm, faces (F, 3) int32, texture coordinates (V, 2) float32 in [0, 1].
    """
    vertices, faces, _, _ = marching_cubes(inside, 0.0, spacing=(step_cm,) * 3)
    vertices = (vertices + low).astype(np.float32)
    return vertices, faces[:, ::-1].astype(np.int32), uv_in_place(vertices)


def uv_in_place(vertices: np.ndarray) -> np.ndarray:
    """Texture coordinates (V, 2) float32 in [0, 1] that follow places (V, 3): x and y, both shifted with depth."""
    return np.clip((vertices[:, :2] + vertices[:, 2:]) / _UV_CM + 0.5, 0, 1).astype(np.float32)
