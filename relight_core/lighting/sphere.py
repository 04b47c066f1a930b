"""The lat-long parametrisation of the sphere: directions and exact solid angles."""

from __future__ import annotations

import math

import numpy as np


def directions(height: int, width: int) -> np.ndarray:
    """Unit vectors toward the texel centres of a lat-long map.

    Row 0 is +y, the centre column looks along -z, the right of the map is +x (camera space).

    Returns:
        (height, width, 3) float32.
    """
    theta = np.pi * (np.arange(height) + 0.5) / height
    phi = 2 * np.pi * ((np.arange(width) + 0.5) / width - 0.5)
    sin_theta = np.sin(theta)[:, None]
    x = sin_theta * np.sin(phi)[None, :]
    y = np.broadcast_to(np.cos(theta)[:, None], (height, width))
    z = -sin_theta * np.cos(phi)[None, :]
    return np.stack([x, y, z], axis=-1).astype(np.float32)


def place_on_map(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where directions of any length lie on a lat-long map, the inverse of `directions`.

    Returns:
        Distances from the map's left as a share of its width, and from its top as a share of its height, in [0, 1].
    """
    return np.arctan2(x, -z) / (2 * np.pi) + 0.5, np.arctan2(np.hypot(x, z), y) / np.pi


def uv_of(direction: np.ndarray) -> tuple[float, float]:
    """Where a direction (3,) lies on a panorama: u in [0, 1), v in [0, 1]."""
    u, v = place_on_map(*direction)
    # Twice, since a tiny negative u % 1 rounds to 1.
    return float(u) % 1.0 % 1.0, float(v)


def direction_at(u: float, v: float) -> np.ndarray:
    """(3,) unit vector toward a point of a panorama; u is periodic, v in [0, 1]."""
    theta, phi = math.pi * v, 2 * math.pi * (u - 0.5)
    level = math.sin(theta)
    return np.array([level * math.sin(phi), math.cos(theta), -level * math.cos(phi)])


def without_whole_turns(yaw_deg: float) -> float:
    """The same angle in [-180, 180] degrees, exactly: of many turns, rounding would leave no part of one.

    Raises:
        ValueError: the angle is NaN or infinite.
    """
    if not math.isfinite(yaw_deg):
        raise ValueError(f"yaw_deg must be a finite angle in degrees, not {yaw_deg}")
    return math.remainder(yaw_deg, 360.0)


def turn_fraction(yaw_deg: float) -> float:
    """The angle as a fraction of a full turn, in [0, 1); raises as `without_whole_turns`."""
    # A tiny negative angle is a whole turn after % 360.
    return without_whole_turns(yaw_deg) % 360.0 / 360.0 % 1.0


def turned(direction: np.ndarray, yaw_deg: float) -> np.ndarray:
    """A light's direction (3,) in camera space after a rotation of the light by yaw_deg, as by `panorama.rotate`."""
    angle = np.radians(without_whole_turns(yaw_deg))
    x, y, z = (float(value) for value in direction)
    return np.array([x * np.cos(angle) - z * np.sin(angle), y, x * np.sin(angle) + z * np.cos(angle)])


def off_axis(off_axis_deg: float, around_deg: float) -> np.ndarray:
    """A direction (3,) in camera space from its angle to the camera's axis and its angle around that axis.

    Args:
        off_axis_deg: 0 is toward the camera, 90 beside the person, 180 behind.
        around_deg: 0 is the right of the image, 90 its top.
    """
    off, around = np.radians([off_axis_deg, around_deg])
    return np.array([np.sin(off) * np.cos(around), np.sin(off) * np.sin(around), np.cos(off)])


def solid_angles(height: int, width: int) -> np.ndarray:
    """Exact solid angle of every texel in steradians; they sum to 4 pi.

    Returns:
        (height, width) float32.
    """
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    rows = (2 * np.pi / width) * (edges[:-1] - edges[1:])
    return np.broadcast_to(rows[:, None], (height, width)).astype(np.float32)


def even_rows(height: int, width: int) -> np.ndarray:
    """Matrices that average each row of a lat-long map over the width that a texel has at the equator.

    Toward the poles texels become slivers, too narrow for a network or a measurement to distinguish.

    Returns:
        (height, width, width) float32: row r of a map times matrix r is that row, averaged. Each matrix is symmetric,
        and its rows and columns sum to 1, so that a row keeps its mean.
    """
    theta = np.pi * (np.arange(height) + 0.5) / height
    reach = np.minimum(width, 1 / np.sin(theta))[:, None] / 2
    apart = np.arange(width)
    apart = np.minimum(apart, width - apart)
    overlap = np.clip(np.minimum(apart + 0.5, reach) - np.maximum(apart - 0.5, -reach), 0, 1)
    overlap /= overlap.sum(axis=1, keepdims=True)
    around = (np.arange(width)[:, None] - np.arange(width)) % width
    return overlap[:, around].astype(np.float32)
