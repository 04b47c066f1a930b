"""The sun, or a bare bulb: a head's own shadows with edges, which the baked light transport is too coarse for.

It knows 512 directions 11 degrees apart, and the sun is half a degree wide.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from relight_core.dataset.baking.bake import BakedHead
from relight_core.dataset.lighting.appearance import Appearance
from relight_core.dataset.lighting.illumination import Illumination
from relight_core.dataset.lighting.lights import lamp_colour
from relight_core.lighting.environment import NETWORK_HEIGHT
from relight_core.lighting.sphere import directions, place_on_map

_USUALLY_FROM = np.array([0.0, 0.5, 0.7])
_REACH, _STEPS = 1.3, 72
"""Half-widths of the view, and looks on the way to there."""
_NARROWEST_DEG, _WIDEST_DEG = 0.3, 4.0
_BEHIND = 0.1
"""Cosine to the camera's axis below which a head's outline hides a lamp, of which a height field knows nothing."""
_WARMTH = 0.3
_NOTHING = -1e3


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
    height = np.full(head.covered.shape, _NOTHING, np.float32)
    height[head.covered] = head.depth
    wide_deg = np.exp(rng.uniform(np.log(_NARROWEST_DEG), np.log(_WIDEST_DEG)))
    reached = sunlit(height, toward, wide_deg)[head.covered][:, None]
    irradiance, specular = appearance.irradiance.copy(), appearance.specular.copy()
    irradiance[k] = illumination.irradiance_open[k] * reached
    specular[k] = specular[k] * reached
    return replace(appearance, irradiance=irradiance, specular=specular)


def sunlit(height: np.ndarray, toward: np.ndarray, wide_deg: float) -> np.ndarray:
    """How much of a round lamp each point of a height field sees, (S, S) float32 in [0, 1].

    Args:
        height: (S, S) toward the camera, in half-widths of the view.
        toward: (3,) the unit vector to the lamp's middle.
        wide_deg: the angle that it fills.
    """
    size = len(height)
    pixel = 2 / size
    x, y = np.meshgrid(*2 * (np.arange(size, dtype=np.float32),))
    across = max(float(np.hypot(*toward[:2])), 1e-3)
    least = np.ones((size, size), np.float32)
    for way in np.geomspace(1.5 * pixel, _REACH, _STEPS):
        reached = way / across
        there = cv2.remap(
            height,
            x + np.float32(toward[0] * reached / pixel),
            y - np.float32(toward[1] * reached / pixel),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=_NOTHING,
        )
        above = there - (height + np.float32(toward[2] * reached)) - pixel / 2
        blur = reached * np.radians(wide_deg) + pixel / 2
        least = np.minimum(least, 0.5 - above / np.float32(blur))
    return least.clip(0, 1)
