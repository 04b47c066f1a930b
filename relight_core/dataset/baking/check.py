"""How far baked light is from the truth: the same head through a path tracer."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from relight_core.dataset.baking.pathtrace import PathTracer
from relight_core.dataset.recipe import Casting, ScanCasting
from relight_core.dataset.samples import LitHead, channels_of, light_head
from relight_core.face.parsing import FACE_LABELS
from relight_core.imaging.colour import srgb_encode

_REFLECTANCE = (0.50, 0.36, 0.29)
"""Linear, of the whole head while it is checked: what is compared is light, not paint."""

_BOUNCES = 4
_SIZE = 128
_RAYS_PER_PIXEL = 128


@dataclass(frozen=True)
class Difference:
    """RMSE on the face, sRGB in [0, 1], of a baked image against a path-traced one.

    Attributes:
        direct: baked direct light against traced direct light: what baking itself gets wrong.
        without_bounce: baked direct light against light traced through four bounces.
        with_bounce: the image that training sees against light traced through four bounces.
    """

    seed: int
    light: int
    direct: float
    without_bounce: float
    with_bounce: float


def check_heads(casting: Casting | ScanCasting, seeds: range, lights: np.ndarray) -> Iterator[Difference]:
    """Render heads both ways under lights (K, 16, 32, 3), one difference per head and light."""
    for seed in seeds:
        posed = casting.pose_head(seed)
        head = posed.bake(_SIZE)
        lit = light_head(head, head.normal, lights, dull=False)
        albedo = np.tile(np.float32(_REFLECTANCE), (len(head.normal), 1))
        tracers = [PathTracer(posed.scene, _REFLECTANCE, bounces) for bounces in (1, _BOUNCES)]
        face = head.scatter(np.isin(head.label, FACE_LABELS))
        for k, light in enumerate(lights):
            direct = [tracers[0].render(light, posed.framing, _SIZE, _RAYS_PER_PIXEL, noise) for noise in (0, 1)]
            bounced = [tracers[1].render(light, posed.framing, _SIZE, _RAYS_PER_PIXEL, noise) for noise in (2, 3)]
            once, full = _direct_image(lit, albedo, k), channels_of(lit, albedo, k)["image"]
            yield Difference(seed, k, _rmse(once, direct, face), _rmse(once, bounced, face), _rmse(full, bounced, face))


def _direct_image(lit: LitHead, albedo: np.ndarray, k: int) -> np.ndarray:
    return lit.head.scatter(albedo * lit.illumination.irradiance[k] + lit.illumination.specular[k])


def _rmse(baked: np.ndarray, traced: list[np.ndarray], where: np.ndarray) -> float:
    """Root mean square error against two renderings whose noise is independent.

    The product of both errors has the square of the baked image's error as its mean: the path tracer's own
    noise, many times larger at rays one can afford, drops out.
    """
    first, second = (_encoded(baked)[where] - _encoded(image)[where] for image in traced)
    return float(np.sqrt(max(np.mean(first * second), 0.0)))


def _encoded(image: np.ndarray) -> np.ndarray:
    return srgb_encode(np.clip(image, 0, 1))
