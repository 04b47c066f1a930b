"""Garments follow a head: bound to it once on the mean head, moved with every other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree


@dataclass(frozen=True)
class Binding:
    """Displacement of garment vertices as a weighted mean of displacements of head vertices.

    Attributes:
        anchors: (A,) indices of head vertices.
        weights: (V, A) sparse, rows sum to one.
    """

    anchors: np.ndarray
    weights: csr_matrix

    def follow(self, vertices: np.ndarray, displacement: np.ndarray) -> np.ndarray:
        """Garment vertices (V, 3) moved with a head whose vertices moved by `displacement` (26719, 3)."""
        return (vertices + self.weights @ displacement[self.anchors]).astype(np.float32)


def bind(vertices: np.ndarray, head: np.ndarray, anchors: np.ndarray, neighbours: int) -> Binding:
    """Bind garment vertices (V, 3) to the `neighbours` nearest of the head vertices `anchors`.

    The influence of an anchor falls smoothly to nothing at the distance of the farthest neighbour, so
    that the displacement is continuous; more neighbours make a stiffer garment.
    """
    distance, nearest = cKDTree(head[anchors]).query(vertices, neighbours)
    reach = distance[:, -1:] * 1.0001
    weight = (1 / (distance + 0.3) - 1 / (reach + 0.3)) ** 2 + 1e-9
    weight /= weight.sum(1, keepdims=True)
    rows = np.repeat(np.arange(len(vertices)), neighbours)
    weights = csr_matrix((weight.ravel().astype(np.float32), (rows, nearest.ravel())), (len(vertices), len(anchors)))
    return Binding(anchors, weights)


def scattered(points: np.ndarray, spacing_cm: float) -> np.ndarray:
    """Indices of a subset of points (N, 3) about one per cube of the given side."""
    cell = np.floor(points / spacing_cm).astype(int)
    return np.unique(cell, axis=0, return_index=True)[1]


def fit_affine(source: np.ndarray, target: np.ndarray, stiffness: float) -> tuple[np.ndarray, np.ndarray]:
    """Scale per axis and shift that take points (N, 3) to others; `stiffness` > 0 draws the scale toward 1.

    Returns:
        scale (3,), shift (3,): target = source * scale + shift.
    """
    middle, aim = source.mean(0), target.mean(0)
    spread = source - middle
    variance = (spread**2).sum(0)
    ease = stiffness * variance.mean()
    scale = ((spread * (target - aim)).sum(0) + ease) / (variance + ease)
    return scale, aim - middle * scale


class HeadSurface:
    """Where a head's skin is, for pushing things out of it."""

    def __init__(self, points: np.ndarray, normals: np.ndarray):
        self.points, self._normals = points, normals
        self._tree = cKDTree(points)

    def height(self, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Height (V,) above the nearest skin point's tangent plane, that point's normal, and its distance."""
        distance, nearest = self._tree.query(vertices)
        normal = self._normals[nearest]
        return ((vertices - self.points[nearest]) * normal).sum(1), normal, distance

    def push_out(self, vertices: np.ndarray, margin_cm: float | np.ndarray, reach_cm: float = 4.0) -> np.ndarray:
        """Vertices (V, 3), those lower than `margin_cm` lifted to it; those beyond `reach_cm` stay."""
        for _ in range(2):
            height, normal, distance = self.height(vertices)
            lift = np.where(distance < reach_cm, np.maximum(margin_cm - height, 0), 0)
            vertices = vertices + normal * lift[:, None]
        return vertices.astype(np.float32)

    def press_down(self, vertices: np.ndarray, ceiling_cm: np.ndarray) -> np.ndarray:
        """Vertices (V, 3) with those higher than `ceiling_cm` (V,) lowered to it, as under a hat."""
        height, normal, _ = self.height(vertices)
        return (vertices - normal * np.maximum(height - ceiling_cm, 0)[:, None]).astype(np.float32)
