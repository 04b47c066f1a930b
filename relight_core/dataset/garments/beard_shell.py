"""Beards, moustaches and stubble as opaque shells over the lower face."""

from __future__ import annotations

import numpy as np

from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_mesh import at_midpoints, clip, compact, fractal, smoothstep, subdivide
from relight_core.dataset.heads import OUTER_SKIN, HeadModel

_CHEEK_X_CM = np.array([0.0, 2.7, 4.5, 6.2, 7.3, 9.0])
_CHEEK_Y_CM = np.array([-2.2, -2.7, -3.2, -1.0, 1.5, 3.0])


class BeardPatch:
    """The lower face of a head model, refined once; beards are grown from it."""

    def __init__(self, model: HeadModel):
        skin = model.has_triangles_of(*OUTER_SKIN)
        corners = model.mean[model.triangles]
        low = (corners[..., 1] < 4).all(1) & (corners[..., 1] > -13).all(1) & (corners[..., 2] > 1).all(1)
        faces = model.triangles[skin & low & (np.abs(corners[..., 0]) < 7.9).all(1)]
        self._faces, self._used = compact(faces, np.arange(len(model.mean)))
        self._edges, self._faces = subdivide(self._faces, len(self._used))
        self._mean = at_midpoints(model.mean[self._used], self._edges)
        span = self._mean.max(0) - self._mean.min(0)
        self._uv = ((self._mean - self._mean.min(0)) / span)[:, :2].astype(np.float32)

    def grow(self, head: np.ndarray, normals: np.ndarray, rng: np.random.Generator) -> Garment:
        """A beard on a head (V, 3) with unit vertex normals (V, 3)."""
        kind = rng.choice(["full", "goatee", "moustache", "circle"], p=[0.55, 0.15, 0.15, 0.15])
        points = at_midpoints(head[self._used], self._edges)
        outward = at_midpoints(normals[self._used], self._edges)
        field = self._outline(str(kind), rng) + 0.15 * fractal(self._mean, rng, 1.5, 2)
        length = rng.uniform(0.12, 0.5) if rng.random() < 0.5 else rng.uniform(0.5, 2.2)
        chin = smoothstep(-4.5, -7.5, self._mean[:, 1])
        hang = length * (0.25 + 0.75 * chin) * smoothstep(0, 0.5 + 0.5 * length, field)
        relief = 1 + 0.3 * fractal(self._mean * [1, 0.5, 1], rng, rng.uniform(0.6, 1.5), 3)
        direction = outward + chin[:, None] * np.array([0, -0.7, 0.2]) * min(length, 1.0)
        direction /= np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-6)
        moved = points + direction * (0.04 + hang * np.maximum(relief, 0.2))[:, None]
        faces, values = clip(self._faces, field, np.concatenate([moved, self._uv], 1).astype(np.float32))
        return Garment(values[:, :3], faces, np.clip(values[:, 3:], 0, 1), "hair", name=f"beard_{kind}")

    def _outline(self, kind: str, rng: np.random.Generator) -> np.ndarray:
        """Signed distance (N,) on the mean head, about cm, positive where hair grows."""
        x, y, z = np.abs(self._mean[:, 0]), self._mean[:, 1], self._mean[:, 2]
        lips = np.hypot(x / 2.75, (y + 3.45) / 1.1)
        off_lips = np.where(z > 7, (lips - 1) * 1.2, 1.0)
        cheek = np.interp(x, _CHEEK_X_CM, _CHEEK_Y_CM) + rng.uniform(-0.8, 0.5) - y
        throat = y + rng.uniform(9.3, 11.0) - 0.25 * x
        under_nose = np.minimum(-1.35 - y, np.minimum(y + 3.5, rng.uniform(2.5, 3.4) - x))
        if kind == "moustache":
            return np.minimum(np.minimum(under_nose, off_lips), z - 8)
        beard = np.minimum(cheek, throat)
        if kind in ("goatee", "circle"):
            beard = np.minimum(beard, rng.uniform(2.2, 3.6) - x)
        if kind != "goatee":
            beard = np.maximum(beard, np.where(z > 8, under_nose, -1))
        return np.minimum(np.minimum(beard, off_lips), -1.3 - y + 3 * smoothstep(4, 6, x))
