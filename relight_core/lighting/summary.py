"""A light in a few numbers: its mean direction, and what a light meter reads."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from relight_core.imaging.colour import REC709_LUMINANCE
from relight_core.lighting.environment import Environment, network_light
from relight_core.lighting.sphere import directions, solid_angles

METERED_READING = 1.5
"""The meter's reading, in the photo's units, of a light that suits a photo without metering, as bundled rigs do."""

_FACES_TILT_AT_MOST = math.sin(math.radians(30.0))
"""As |n_y|: little of an upright face looks further up or down."""

MOST_STOPS = 16.0
"""Metering changes a level by at most so many stops."""


def average_direction(environment: Environment, yaw_deg: float = 0.0) -> np.ndarray:
    """Mean direction of a light, weighted by luminance.

    Returns:
        (3,) float32 in camera space. Its length tells how directional the light is: near 1 for a single lamp, 0 for
        light that is balanced from all sides, or for no light.
    """
    light = network_light(environment, yaw_deg)
    height, width = light.shape[:2]
    power = (light @ REC709_LUMINANCE) * solid_angles(height, width)
    total = power.sum()
    if total <= 0:
        return np.zeros(3, np.float32)
    return (np.einsum("hw,hwc->c", power, directions(height, width)) / total).astype(np.float32)


def meter_reading(environment: Environment) -> float:
    """The luminance of a white matte card that faces the light's brightest side, as an incident-light meter reads it.

    Only cards that look at most 30 degrees up or down count, as most of an upright face does. So light that only
    reaches the top of a head, like most of a grey sky, is not metered.

    Returns:
        The reading in units of the light's level, independent of its yaw; 0 for a map without light.
    """
    light = network_light(environment)
    height, width = light.shape[:2]
    upright = np.abs(directions(height, width)[..., 1].ravel()) <= _FACES_TILT_AT_MOST
    return float((_relative_cosines(height, width)[upright] @ (light @ REC709_LUMINANCE).ravel()).max())


def metered_level_ev(environment: Environment) -> float:
    """The change of level that makes a light's brightest side as bright as that of the bundled rigs.

    Panoramas are in arbitrary units; the rigs are made to suit a photo as they are.

    Returns:
        Stops in [-16, 16]; 0 for a map without light. Twice the light gives one stop less.
    """
    if environment.level <= 0:
        return 0.0
    stops = math.log2(METERED_READING) - math.log2(meter_reading(environment)) - math.log2(environment.level)
    return min(max(stops, -MOST_STOPS), MOST_STOPS)


@lru_cache(maxsize=2)
def _relative_cosines(height: int, width: int) -> np.ndarray:
    """Clamped cosine times solid angle, (normals, texels), with rows that sum to 1, so that even light reads as 1."""
    toward = directions(height, width).reshape(-1, 3).astype(np.float64)
    areas = solid_angles(height, width).ravel().astype(np.float64)
    cosines = np.maximum(toward @ toward.T, 0.0) * areas
    return cosines / cosines.sum(axis=1, keepdims=True)
