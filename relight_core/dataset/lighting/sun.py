"""The sun, or a bare bulb: a head's own shadows with edges, which the baked light transport is too coarse for.

It knows 512 directions 11 degrees apart, and the sun is half a degree wide.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from relight_core.dataset.baking.bake import BakedHead
from relight_core.dataset.lighting.appearance import Appearance
from relight_core.dataset.lighting.illumination import Illumination
from relight_core.dataset.lighting.lights import lamp_colour
from relight_core.lighting.environment import NETWORK_HEIGHT
from relight_core.lighting.horizon import Horizon
from relight_core.lighting.sphere import directions, place_on_map

_USUALLY_FROM = np.array([0.0, 0.5, 0.7])
_NARROWEST_DEG, _WIDEST_DEG = 0.15, 2.0
"""Radii."""
_BEHIND = 0.1
"""Cosine to the camera's axis below which a head's outline hides a lamp, of which a height field knows nothing."""
_WARMTH = 0.3


def sample_sun(rng: np.random.Generator) -> np.ndarray:
    """A light (16, 32, 3) of one texel, more often before a person than behind."""
    while (direction := rng.standard_normal(3) + _USUALLY_FROM)[2] < _BEHIND * np.linalg.norm(direction):
        pass
    u, v = place_on_map(*direction)
    light = np.zeros((NETWORK_HEIGHT, 2 * NETWORK_HEIGHT, 3), np.float32)
    light[int(v * NETWORK_HEIGHT), int(u * 2 * NETWORK_HEIGHT) % (2 * NETWORK_HEIGHT)] = lamp_colour(rng, _WARMTH)
    return light


def in_sun(
    appearance: Appearance,
    head: BakedHead,
    light: np.ndarray,
    illumination: Illumination,
    k: int,
    rng: np.random.Generator,
) -> Appearance:
    """The same head with edges on its shadows under one light.

    Args:
        light: (16, 32, 3), light `k` of the appearance, as of `sample_sun`.
        illumination: what the same lights do to the head.
    """
    toward = directions(*light.shape[:2])[np.unravel_index(light.sum(-1).argmax(), light.shape[:2])]
    radius_deg = np.exp(rng.uniform(np.log(_NARROWEST_DEG), np.log(_WIDEST_DEG)))
    horizon = Horizon(head.scatter(head.depth), head.covered)
    reached = horizon.visibility(tuple(toward), radius_deg)[head.covered][:, None]
    irradiance, specular = appearance.irradiance.copy(), appearance.specular.copy()
    irradiance[k] = illumination.irradiance_open[k] * reached
    specular[k] = specular[k] * reached
    return replace(appearance, irradiance=irradiance, specular=specular)
