"""A reference for the baked light: the same head through Mitsuba's path tracer and principled BSDF."""

from __future__ import annotations

import numpy as np

from relight_core.dataset.baking.framing import Framing
from relight_core.dataset.baking.mitsuba_backend import mesh_of, mitsuba_backend
from relight_core.dataset.baking.scene import Scene
from relight_core.lighting.reflection import GLOSS

_TEXEL_PX = 16
"""Mitsuba interpolates between texels; each of the light's is blown up to this many, to stay one."""


class PathTracer:
    """One dressed head of one colour, rendered under any light."""

    def __init__(self, scene: Scene, albedo: tuple[float, float, float], bounces: int = 4):
        """Build the scene.

        Args:
            albedo: linear reflectance of everything.
            bounces: reflections that are followed; 1 is direct light alone.
        """
        self._mitsuba = mitsuba_backend()
        self._mesh = self._mesh_of(scene, albedo)
        self._integrator = self._mitsuba.load_dict({"type": "path", "max_depth": bounces + 1, "hide_emitters": True})

    def _mesh_of(self, scene: Scene, albedo):
        mitsuba = self._mitsuba
        surface = {
            "type": "principled",
            "base_color": {"type": "rgb", "value": list(albedo)},
            "specular": GLOSS.specular,
            "roughness": GLOSS.roughness,
        }
        properties = mitsuba.Properties()
        properties["bsdf"] = mitsuba.load_dict({"type": "twosided", "bsdf": surface})
        mesh = mesh_of(scene, props=properties, has_vertex_normals=True)
        mesh.recompute_vertex_normals()
        return mesh

    def render(
        self, light: np.ndarray, framing: Framing, size: int, rays_per_pixel: int = 64, noise: int = 0
    ) -> np.ndarray:
        """The head under a light (16, 32, 3): radiance (S, S, 3) float32 linear, black where nothing is.

        Args:
            noise: renderings of different numbers have independent noise.
        """
        mitsuba = self._mitsuba
        scene = mitsuba.load_dict({"type": "scene", "light": self._emitter(light), "mesh": self._mesh})
        origin, toward = framing.rays(size)
        toward = np.repeat(toward, rays_per_pixel, 0)
        ray = mitsuba.RayDifferential3f(
            mitsuba.Ray3f(mitsuba.Point3f(*[float(c) for c in origin]), mitsuba.Vector3f(toward.T))
        )
        sampler = mitsuba.load_dict({"type": "independent"})
        sampler.seed(noise, len(toward))
        radiance, hit, _ = self._integrator.sample(scene, sampler, ray)
        image = np.array(radiance).T * np.array(hit)[:, None]
        return image.reshape(size, size, rays_per_pixel, 3).mean(2).astype(np.float32)

    def _emitter(self, light: np.ndarray) -> dict:
        mitsuba = self._mitsuba
        texels = np.repeat(np.repeat(light.astype(np.float32), _TEXEL_PX, 0), _TEXEL_PX, 1)
        half_turn = mitsuba.ScalarTransform4f().rotate([0, 1, 0], 180)
        return {"type": "envmap", "bitmap": mitsuba.Bitmap(texels), "to_world": half_turn}
