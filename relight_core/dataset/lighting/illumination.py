"""Lighting a baked head: every channel of the paper under any light, by linear algebra.

The surface is Lambert plus the isotropic GGX lobe of the principled BSDF with the paper's parameters
(section 3.2: specular 0.6, roughness 0.5), under direct light.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch

from relight_core.dataset.baking.bake import LIGHT_HEIGHT, LIGHT_WIDTH, BakedHead
from relight_core.dataset.lighting.occluders import Occluder, positions, transmission
from relight_core.lighting.reflection import GLOSS, Gloss, specular_lobe
from relight_core.lighting.sphere import directions, solid_angles

_PIXELS_AT_ONCE = 1024

Transports = Callable[[torch.Tensor, torch.Tensor, torch.Tensor, torch.Tensor], tuple[torch.Tensor, ...]]
"""From the directions of the 512 texels (512, 3), their cosines >= 0 to P normals (512, P), visibilities in [0, 1]
(512, P) and the normals (P, 3) to some transports (512, P): reflected radiance per texel's radiance and steradian."""


@dataclass(frozen=True)
class Illumination:
    """Reflection of K lights at the P pixels of one head, before albedo; in units of the normalised light.

    Attributes:
        irradiance: (K, P, 3), 1 / pi times the irradiance, with self-occlusion.
        irradiance_open: the same without self-occlusion.
        specular: (K, P, 3), reflected gloss with self-occlusion.
        specular_open: the same without.
    """

    irradiance: np.ndarray
    irradiance_open: np.ndarray
    specular: np.ndarray
    specular_open: np.ndarray


def illuminate(head: BakedHead, normal: np.ndarray, lights: np.ndarray) -> Illumination:
    """Light a head.

    Args:
        normal: (P, 3) shading normals, the head's own or with relief added.
        lights: (K, 16, 32, 3) linear radiance.
    """

    def transports(toward, cosine, seen, n):
        lobe = specular_lobe(toward, n, GLOSS)
        irradiance = cosine / torch.pi
        return irradiance * seen, irradiance, lobe * seen, lobe

    return Illumination(*_accumulate(head, normal, lights, 4, transports))


def reflect(head: BakedHead, normal: np.ndarray, lights: np.ndarray, gloss: Gloss) -> np.ndarray:
    """Only the specular reflection with self-occlusion, (K, P, 3), of a surface with another gloss."""

    def transports(toward, cosine, seen, n):
        return (specular_lobe(toward, n, gloss) * seen,)

    return _accumulate(head, normal, lights, 1, transports)[0]


def illuminate_past(
    head: BakedHead, normal: np.ndarray, lights: np.ndarray, gloss: Gloss, occluder: Occluder
) -> list[np.ndarray]:
    """Irradiance / pi and specular, each (K, P, 3), where an occluder blocks a part of the light as well."""

    def transports(toward, cosine, seen, n):
        return cosine / torch.pi * seen, specular_lobe(toward, n, gloss) * seen

    return _accumulate(head, normal, lights, 2, transports, occluder)


def blocked_by_itself(head: BakedHead, normal: np.ndarray) -> np.ndarray:
    """The cosine-weighted part of each pixel's hemisphere that the head itself covers, (P,) in [0, 1]."""

    def transports(toward, cosine, seen, n):
        return cosine * seen, cosine

    everywhere = np.ones((1, LIGHT_HEIGHT, LIGHT_WIDTH, 3), np.float32)
    seen, whole = _accumulate(head, normal, everywhere, 2, transports)
    return 1 - (seen / np.maximum(whole, 1e-6))[0, :, 0].clip(0, 1)


def _accumulate(
    head: BakedHead,
    normal: np.ndarray,
    lights: np.ndarray,
    count: int,
    transports: Transports,
    occluder: Occluder | None = None,
) -> list[np.ndarray]:
    """The sums over the texels of light times each transport, (K, P, 3); some pixels at a time, to stay in cache.

    Args:
        count: number of transports.
        occluder: blocks a part of each pixel's light.
    """
    toward = torch.from_numpy(directions(LIGHT_HEIGHT, LIGHT_WIDTH).reshape(-1, 3))
    weights = torch.from_numpy(solid_angles(LIGHT_HEIGHT, LIGHT_WIDTH).reshape(-1))
    radiance = torch.from_numpy(lights.astype(np.float32)).reshape(len(lights), -1, 3)
    flat = (radiance * weights[None, :, None]).permute(0, 2, 1).reshape(len(lights) * 3, -1)
    visible = head.visible()
    points = None if occluder is None else positions(head)
    results = [np.empty((len(lights), len(normal), 3), np.float32) for _ in range(count)]
    for start in range(0, len(normal), _PIXELS_AT_ONCE):
        part = slice(start, min(start + _PIXELS_AT_ONCE, len(normal)))
        n = torch.from_numpy(np.ascontiguousarray(normal[part]))
        seen = torch.from_numpy(visible[:, part].astype(np.float32))
        if points is not None:
            seen *= transmission(occluder, points[part])
        cosine = (toward @ n.T).clamp_min(0)
        for result, transport in zip(results, transports(toward, cosine, seen, n), strict=True):
            result[:, part] = (flat @ transport).reshape(len(lights), 3, -1).permute(0, 2, 1).numpy()
    return results
