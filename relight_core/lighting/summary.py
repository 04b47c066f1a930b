"""A light in a few numbers: where it comes from and how bright it is."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from relight_core.imaging.colour import REC709_LUMINANCE
from relight_core.lighting.environment import Environment, network_light
from relight_core.lighting.sphere import directions, solid_angles

METERED_READING = 1.5
"""What the meter reads, in the photo's units, of light that suits it as it is, such as the bundled rigs'."""

_FACES_TILT_AT_MOST = math.sin(math.radians(30.0))

MOST_STOPS = 16.0


def average_direction(environment: Environment, yaw_deg: float = 0.0) -> np.ndarray:
    """Mean direction of the light, every direction weighted by the luminance that comes from it.

    Returns:
        (3,) float32 in camera space. Its length tells how much the light agrees with itself: near 1
        for a lone lamp, 0 for light that is balanced from all sides or for no light.
    """
    light = network_light(environment, yaw_deg)
    height, width = light.shape[:2]
    power = (light @ REC709_LUMINANCE) * solid_angles(height, width)
    total = power.sum()
    if total <= 0:
        return np.zeros(3, np.float32)
    return (np.einsum("hw,hwc->c", power, directions(height, width)) / total).astype(np.float32)


def meter_reading(environment: Environment) -> float:
    """What an incident-light meter reads before a face on the light's brightest side: a white matte card's luminance.

    A face is upright, and little of it looks more than 30 degrees up or down: what only lights the top of a head,
    as most of a grey sky does, is not metered.

    In units of the light's level; 0 for a map without light. Does not change with the yaw.
    """
    light = network_light(environment)
    height, width = light.shape[:2]
    upright = np.abs(directions(height, width)[..., 1].ravel()) <= _FACES_TILT_AT_MOST
    return float((_relative_cosines(height, width)[upright] @ (light @ REC709_LUMINANCE).ravel()).max())


def metered_level_ev(environment: Environment) -> float:
    """By how much the light's level has to change for its brightest side to be as bright as that of the bundled rigs.

    A panorama comes in units of its own; the rigs are made to suit a photo as it is.

    Returns:
        stops in [-16, 16]; 0 for a map without light. Twice the light gives one stop less.
    """
    if environment.level <= 0:
        return 0.0
    stops = math.log2(METERED_READING) - math.log2(meter_reading(environment)) - math.log2(environment.level)
    return min(max(stops, -MOST_STOPS), MOST_STOPS)


@lru_cache(maxsize=2)
def _relative_cosines(height: int, width: int) -> np.ndarray:
    """Clamped cosine times solid angle, (normals, texels); rows sum to 1 and keep even light even."""
    toward = directions(height, width).reshape(-1, 3).astype(np.float64)
    areas = solid_angles(height, width).ravel().astype(np.float64)
    cosines = np.maximum(toward @ toward.T, 0.0) * areas
    return cosines / cosines.sum(axis=1, keepdims=True)
