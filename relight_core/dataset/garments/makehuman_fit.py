"""A smooth map of space that takes the MakeHuman base head onto the mean of the head model."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from relight_core.dataset.garments.garment_binding import scattered
from relight_core.dataset.garments.garment_mesh import vertex_normals
from relight_core.dataset.heads import OUTER_SKIN, HeadModel
from relight_core.errors import InputError

# MakeHuman "hm08" vertex on the left, index into the 68 landmarks on the right.
_LANDMARKS = {132: 27, 5054: 30, 343: 33, 455: 51, 496: 57, 5171: 8}
_EYE_HELPERS = ((14598, 14670), (14670, 14742))
_LOWEST_FITTED_CM = 54.0
_REACH_CM = 30.0


class HeadWarp:
    """x -> similarity(x) + sum of smooth bumps, fitted to landmarks and then to the whole surface.

    The bumps end `_REACH_CM` from the surface they were fitted to; beyond, only the similarity remains.
    """

    def __init__(self, base: np.ndarray, body_faces: np.ndarray, model: HeadModel):
        """Fit the base mesh (`makehuman.read_base`) to the head model.

        Raises:
            InputError: a part of the base mesh is missing.
        """
        if len(base) < _EYE_HELPERS[-1][1]:
            raise InputError("3dobjs/base.obj: ends before its last vertex; unpack the MakeHuman archive again")
        source, target = _landmark_pairs(base, model)
        self._scale, self._shift = _similarity(source, target)
        moved = self._similar(source)
        self._centres, self._weights = moved, _solve(moved, target - moved, 0.0)
        surface, skin = _head_surface(model)
        for reach, smoothing in ((3.0, 0.3), (2.0, 0.15), (1.2, 0.05), (1.2, 0.03)):
            self._refine(base, body_faces, surface, skin, (source, target), reach, smoothing)

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """Points (N, 3) around the MakeHuman body, cm -> around the mean head, cm."""
        moved = self._similar(points)
        return (moved + _kernel(moved, self._centres) @ self._weights).astype(np.float32)

    def _similar(self, points: np.ndarray) -> np.ndarray:
        return points * self._scale + self._shift

    def _refine(self, base, body_faces, surface, skin, landmarks, reach, smoothing):
        """Draw the warped base to the nearest skin that faces the same way."""
        used = np.unique(body_faces)
        used = used[base[used, 1] > _LOWEST_FITTED_CM]
        warped = base.copy()
        warped[used] = self(base[used])
        normals = vertex_normals(warped, body_faces[(base[body_faces][..., 1] > _LOWEST_FITTED_CM).all(1)])
        used = used[scattered(base[used], 1.5)]
        distance, nearest = cKDTree(surface).query(warped[used])
        close = (distance < reach) & ((normals[used] * skin[nearest]).sum(1) > 0.7)
        offset = ((surface[nearest] - warped[used]) * skin[nearest]).sum(1, keepdims=True) * skin[nearest]
        source = np.concatenate([landmarks[0], base[used[close]]])
        target = np.concatenate([landmarks[1], (warped[used] + offset)[close]])
        moved = self._similar(source)
        self._centres, self._weights = moved, _solve(moved, target - moved, smoothing)


def _head_surface(model: HeadModel) -> tuple[np.ndarray, np.ndarray]:
    skin = model.has_triangles_of(*OUTER_SKIN)
    normals = vertex_normals(model.mean, model.triangles[skin])
    used = np.unique(model.triangles[skin])
    return model.mean[used], normals[used]


def _landmark_pairs(base: np.ndarray, model: HeadModel) -> tuple[np.ndarray, np.ndarray]:
    """Matching points (N, 3) on both heads: face, eyes, ears, top and back of the head."""
    pairs = [(base[v], model.mean[model.landmarks[i]]) for v, i in _LANDMARKS.items()]
    for (first, last), side in zip(_EYE_HELPERS, "LR", strict=True):
        ball = model.mean[model.vertices_of(f"sclera_{side}")]
        eye = base[first:last]
        pairs.append(((eye.min(0) + eye.max(0)) / 2, (ball.min(0) + ball.max(0)) / 2))
    theirs, ours = base[:13380], model.mean[model.vertices_of(*OUTER_SKIN)]
    both = theirs[theirs[:, 1] > 62], ours[ours[:, 1] > -6]
    pairs.append(tuple(p[p[:, 1].argmax()] * [0, 1, 1] for p in both))
    pairs.append(tuple(p[p[:, 2].argmin()] * [0, 1, 1] for p in both))
    pairs.append(tuple(p[p[:, 0].argmax()] for p in both))
    pairs.append(tuple(p[p[:, 0].argmin()] for p in both))
    source, target = (np.array(side, np.float64) for side in zip(*pairs, strict=True))
    return source, target


def _similarity(source: np.ndarray, target: np.ndarray) -> tuple[float, np.ndarray]:
    """Scale and shift; both heads look along +z, so no rotation."""
    spread = source - source.mean(0)
    scale = float((spread * (target - target.mean(0))).sum() / (spread**2).sum())
    return scale, target.mean(0) - scale * source.mean(0)


def _kernel(points: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """Wendland's C2 function of the distance: smooth, positive definite, nothing beyond its reach."""
    squared = (points**2).sum(1)[:, None] + (centres**2).sum(1) - 2 * points @ centres.T
    t = np.minimum(np.sqrt(np.maximum(squared, 0)) / _REACH_CM, 1)
    return (1 - t) ** 4 * (4 * t + 1)


def _solve(centres: np.ndarray, offsets: np.ndarray, smoothing: float) -> np.ndarray:
    matrix = _kernel(centres, centres) + np.eye(len(centres)) * (smoothing + 1e-6)
    return np.linalg.solve(matrix, offsets)
