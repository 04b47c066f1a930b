"""Eyelashes: clumps of lashes cut from the strips that the head model keeps for them on its lids."""

from __future__ import annotations

import numpy as np

from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_mesh import clip, grid_faces
from relight_core.dataset.heads import HeadModel

_ROWS = 8
_COLUMNS_PER_LASH = 6
_UPPER, _LOWER = slice(0, 3), slice(3, 6)


class LashStrips:
    """The strips of both eyes as grids of vertices of the head model: root to tip, along the lid."""

    def __init__(self, model: HeadModel):
        self._strips = [_grids(model, side) for side in "LR"] if model.lashes is not None else []

    def grow(self, head: np.ndarray, rng: np.random.Generator) -> list[Garment]:
        """Lashes on the lids of a head (V, 3); none where the head model has no strips."""
        worn = []
        layers = rng.permutation(3)[: rng.integers(1, 4)]
        count, width = int(rng.integers(18, 36)), rng.uniform(0.2, 0.48)
        upper, lower = rng.uniform(0.5, 1.0), rng.uniform(0.0, 0.8)
        for strips in self._strips:
            for strip in [strips[_UPPER][k] for k in layers]:
                worn.append(_clumps(head[strip], count, width, upper, rng))
            if lower > 0.3:
                worn.append(_clumps(head[strips[_LOWER][0]], count, 0.7 * width, lower, rng))
        return worn


def _grids(model: HeadModel, side: str) -> list[np.ndarray]:
    """Vertex indices (rows, columns) of one eye's strips, upper lid first."""
    faces, uv = model.lashes[side]
    height = {int(v): uv_of for v, uv_of in zip(faces.ravel(), uv.reshape(-1, 2), strict=True)}
    vertices = np.array(sorted(height))
    at = np.array([height[v] for v in vertices])
    skin = model.mean[model.vertices_of("face")]
    grids = []
    for strip in _parts(faces, vertices):
        rows = np.unique(at[strip, 1].round(3))
        grid = [strip[at[strip, 1].round(3) == row] for row in rows]
        grid = np.array([vertices[row[np.argsort(at[row, 0])]] for row in grid])
        first, last = (_distance(model.mean[grid[end]], skin) for end in (0, -1))
        grids.append(grid if first < last else grid[::-1])
    return sorted(grids, key=lambda grid: -model.mean[grid[-1], 1].mean())


def _parts(faces: np.ndarray, vertices: np.ndarray) -> list[np.ndarray]:
    """Indices into `vertices` of each connected part."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    at = np.searchsorted(vertices, faces)
    sides = np.concatenate([at[:, [0, 1]], at[:, [1, 2]]])
    shape = (len(vertices), len(vertices))
    count, part = connected_components(coo_matrix((np.ones(len(sides)), sides.T), shape), directed=False)
    return [np.flatnonzero(part == number) for number in range(count)]


def _distance(points: np.ndarray, skin: np.ndarray) -> float:
    return float(np.linalg.norm(points[:, None] - skin[None], axis=-1).min(1).mean())


def _clumps(strip: np.ndarray, count: int, width: float, length: float, rng: np.random.Generator) -> Garment:
    """Lashes on a strip of points (rows, columns, 3), `width` and `length` as shares of their spacing and of it."""
    columns = count * _COLUMNS_PER_LASH
    along = np.linspace(0, 1, columns + 1)
    points = _resampled(_resampled(strip, _ROWS, 0), columns + 1, 1)
    tip = np.linspace(0, 1, _ROWS)[:, None]
    lash = np.minimum((along * count).astype(int), count - 1)
    reach = length * rng.uniform(0.6, 1.0, count)[lash]
    bent = rng.uniform(-0.25, 0.25, count)[lash] * tip
    across = np.abs(along * count - lash - 0.5 + bent)
    field = width * (1 - 0.8 * tip / reach) - across
    field = np.minimum(field, (reach - tip) * 0.5)
    u, v = np.meshgrid(along, tip[:, 0])
    values = np.concatenate([points.reshape(-1, 3), u.reshape(-1, 1), v.reshape(-1, 1)], 1).astype(np.float32)
    faces, values = clip(grid_faces(_ROWS, columns + 1), field.ravel(), values)
    return Garment(values[:, :3], faces, np.clip(values[:, 3:], 0, 1), "lash", name="lashes")


def _resampled(grid: np.ndarray, count: int, axis: int) -> np.ndarray:
    """A grid of points with `count` of them along an axis, between the first and the last."""
    place = np.linspace(0, grid.shape[axis] - 1, count)
    low = np.minimum(place.astype(int), grid.shape[axis] - 2)
    share = (place - low).reshape([-1 if a == axis else 1 for a in range(3)])
    return np.take(grid, low, axis) * (1 - share) + np.take(grid, low + 1, axis) * share
