"""A preview of a light: a matte ball with a glossy varnish."""

from __future__ import annotations

import numpy as np

from relight_core.imaging.colour import REC709_LUMINANCE
from relight_core.lighting.environment import Environment, network_light
from relight_core.lighting.sphere import directions, solid_angles

_LIGHT_HEIGHT = 32
"""Rows of the light under which a still ball is drawn."""
_TABLE_HEIGHT = 24
"""Rows of the tables for a ball under a rotating light."""
_ALBEDO = 0.7
_REFLECTANCE = 0.05
"""Of the varnish at normal incidence (Schlick 1994)."""
_LOBE_DOUBLINGS = 7
"""The exponent of the gloss lobe is doubled so often by squaring: cos ** 128."""
_TABLE_DOUBLINGS = 6
"""The tables have a wider lobe, since their light has only 16 rows."""
_BRIGHT = 0.85
"""Luminance to which a ball is exposed."""
_DARK_LEVEL = 1e-12
"""Luminance up to which a ball counts as unlit and stays black."""
_BLOCK = 2048
"""Pixels that are shaded at once, to save memory."""


def lit_ball(environment: Environment, size: int) -> np.ndarray:
    """A glossy ball under a light, exposed for its bright parts whatever the light's level.

    The 98th percentile of its luminance becomes 0.85.

    Args:
        environment: the light.
        size: pixels along a side, at least 1.

    Returns:
        (size, size, 4) float32: linear Rec.709 radiance, and the ball's alpha in [0, 1].
    """
    coverage, normals = _ball(size)
    light = network_light(environment, height=_LIGHT_HEIGHT)
    inside = coverage > 0
    radiance = np.zeros((size, size, 3), np.float32)
    shaded = _shade(normals[inside], light)
    bright = np.percentile(shaded @ REC709_LUMINANCE.astype(np.float32), 98)
    radiance[inside] = shaded * (_BRIGHT / bright if bright > _DARK_LEVEL else 0.0)
    return np.concatenate([radiance, coverage[..., None]], axis=-1)


def ball_tables(environment: Environment) -> tuple[np.ndarray, np.ndarray]:
    """Tables for drawing a ball under a rotating light; look them up by directions rotated back by the light's yaw.

    The exposure doesn't depend on the yaw: a matte surface that faces the light has a luminance of 0.85, so a light
    behind the ball leaves it dark.

    Returns:
        Two (24, 48, 3) float32 lat-long tables for yaw 0: radiance of the matte surface by its normal, and the light,
        blurred by the varnish's lobe, by the mirrored direction (without Fresnel).
    """
    toward, power_and_area = _flat(network_light(environment))
    at = directions(_TABLE_HEIGHT, 2 * _TABLE_HEIGHT).reshape(-1, 3)
    matte = _matte(at, toward, power_and_area)
    gloss = _gloss(at, toward, power_and_area, _TABLE_DOUBLINGS)
    brightest = float((matte @ REC709_LUMINANCE.astype(np.float32)).max())
    scale = _BRIGHT / brightest if brightest > _DARK_LEVEL else 0.0
    shape = (_TABLE_HEIGHT, 2 * _TABLE_HEIGHT, 3)
    return tuple((table * scale).reshape(shape).astype(np.float32) for table in (matte, gloss))


def _flat(light: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions (N, 3) of a light's texels, and for each its rgb power and its solid angle (N, 4)."""
    height, width = light.shape[:2]
    areas = solid_angles(height, width).reshape(-1, 1)
    power_and_area = np.concatenate([light.reshape(-1, 3) * areas, areas], axis=1)
    return directions(height, width).reshape(-1, 3), power_and_area


def _ball(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Coverage (size, size) and unit normals (size, size, 3) of a ball that fills the image."""
    steps = (np.arange(size) + 0.5) * 2 / size - 1
    x, y = np.meshgrid(steps, -steps)
    radius = np.hypot(x, y)
    coverage = np.clip((1 - radius) * size / 2 + 0.5, 0, 1)
    shorten = np.minimum(1.0, 0.9999 / np.maximum(radius, 1e-6))
    x, y = x * shorten, y * shorten
    normals = np.stack([x, y, np.sqrt(np.maximum(1 - x * x - y * y, 0))], axis=-1)
    return coverage.astype(np.float32), normals.astype(np.float32)


def _shade(normals: np.ndarray, light: np.ndarray) -> np.ndarray:
    """Radiance (N, 3) toward the camera of a matte surface under a varnish, without occlusion."""
    toward, power_and_area = _flat(light)
    blocks = np.split(normals, range(_BLOCK, len(normals), _BLOCK))
    return np.concatenate([_shade_block(block, toward, power_and_area) for block in blocks])


def _shade_block(normals: np.ndarray, toward: np.ndarray, power_and_area: np.ndarray) -> np.ndarray:
    """`_shade` of a few normals, with the light as `_flat` returns it."""
    mirrored = 2 * normals[:, 2:3] * normals - np.array([0, 0, 1], np.float32)
    fresnel = _REFLECTANCE + (1 - _REFLECTANCE) * (1 - normals[:, 2:3]) ** 5
    return _matte(normals, toward, power_and_area) + fresnel * _gloss(mirrored, toward, power_and_area, _LOBE_DOUBLINGS)


def _matte(normals: np.ndarray, toward: np.ndarray, power_and_area: np.ndarray) -> np.ndarray:
    """Lambertian radiance (N, 3) at normals (N, 3)."""
    return np.maximum(normals @ toward.T, 0) @ power_and_area[:, :3] * (_ALBEDO / np.pi)


def _gloss(mirrored: np.ndarray, toward: np.ndarray, power_and_area: np.ndarray, doublings: int) -> np.ndarray:
    """The light around each direction (N, 3), averaged over a lobe of cos ** (2 ** doublings)."""
    lobe = np.maximum(mirrored @ toward.T, 0)
    for _ in range(doublings):
        np.square(lobe, out=lobe)
    gathered = lobe @ power_and_area
    return gathered[:, :3] / np.maximum(gathered[:, 3:], 1e-6)
