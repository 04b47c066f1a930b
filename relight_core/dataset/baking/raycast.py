"""Rays against one dressed head, cast by Mitsuba."""

from __future__ import annotations

import numpy as np

from relight_core.dataset.baking.mitsuba_backend import mesh_of, mitsuba_backend
from relight_core.dataset.baking.scene import Scene


class RayCaster:
    """Closest hits and occlusion tests against one scene."""

    def __init__(self, scene: Scene):
        self._scene = mitsuba_backend().load_dict({"type": "scene", "mesh": mesh_of(scene)})

    def closest(self, origin: np.ndarray, toward: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """First triangle along each ray.

        Args:
            origin: (3,) shared by all rays.
            toward: (N, 3) unit directions.

        Returns:
            triangle (N,) int64, -1 for a miss; barycentric (N, 3); distance (N,).
        """
        mitsuba = mitsuba_backend()
        ray = mitsuba.Ray3f(mitsuba.Point3f(*[float(c) for c in origin]), mitsuba.Vector3f(toward.T))
        hit = self._scene.ray_intersect_preliminary(ray)
        valid = np.array(hit.is_valid())
        uv = np.where(valid[:, None], np.array(hit.prim_uv).T, 0)
        barycentric = np.stack([1 - uv[:, 0] - uv[:, 1], uv[:, 0], uv[:, 1]], 1)
        triangle = np.where(valid, np.array(hit.prim_index).astype(np.int64), -1)
        return triangle, barycentric.astype(np.float32), np.array(hit.t)

    def occluded(self, origins: np.ndarray, toward: np.ndarray) -> np.ndarray:
        """(N,) bool: does anything lie along each ray? origins and toward are (N, 3)."""
        mitsuba = mitsuba_backend()
        ray = mitsuba.Ray3f(mitsuba.Point3f(origins.T), mitsuba.Vector3f(toward.T))
        return np.array(self._scene.ray_test(ray))
