"""Light rigs drawn into lat-long panoramas."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from relight_core.imaging.ramp import smooth_ramp
from relight_core.lighting.panorama import shrink
from relight_core.lighting.rig_description import AreaLight, Glow, Rig, Room, Sky
from relight_core.lighting.sphere import directions, solid_angles

_DRAWN_HEIGHT = 512
"""Rows that a rig is drawn with at least, before it is averaged."""
_HORIZON_BLUR = 0.03
"""Height, as the sine of elevation, over which ground fades into sky."""


@dataclass(frozen=True)
class Drawn:
    """The rig that a light was rendered from.

    Attributes:
        rig: its description.
        level: radiance in the rig's units that corresponds to 1 in the light's shape.
    """

    rig: Rig
    level: float


def render_rig(rig: Rig, height: int = 64) -> np.ndarray:
    """Draw a rig, antialiased: at several times the resolution and then averaged.

    Args:
        rig: what to draw.
        height: rows of the result, at least 1.

    Returns:
        (height, 2 * height, 3) float32 linear Rec.709 radiance, where 1 is the radiance of a white
        matte card under a lamp of intensity 1.
    """
    drawn_height = height * max(1, -(-_DRAWN_HEIGHT // height))
    toward = directions(drawn_height, 2 * drawn_height)
    areas = solid_angles(drawn_height, 2 * drawn_height)
    surround = _sky if isinstance(rig.surround, Sky) else _room
    radiance = surround(rig.surround, toward)
    for light in rig.area_lights:
        radiance += area_light_radiance(light, toward, areas)
    return shrink(radiance, height)


def direction_of(azimuth_deg: float, elevation_deg: float) -> np.ndarray:
    """Unit vector from the face toward a lamp, in camera space.

    Azimuth 0 is the camera's own side (+z), positive azimuth the right of the image (+x), positive
    elevation above (+y).
    """
    azimuth, elevation = np.radians([azimuth_deg, elevation_deg])
    level = np.cos(elevation)
    return np.array([level * np.sin(azimuth), np.sin(elevation), level * np.cos(azimuth)], np.float32)


def area_light_radiance(light: AreaLight, toward: np.ndarray, areas: np.ndarray) -> np.ndarray:
    """Radiance of one lamp on a map; a white card facing its centre reflects colour * intensity.

    Args:
        light: the lamp.
        toward, areas: (H, W, 3) directions and (H, W) solid angles of the map's texels.

    Returns:
        (H, W, 3) float32 linear Rec.709.
    """
    forward = direction_of(light.azimuth_deg, light.elevation_deg)
    ahead = toward @ forward
    cover = _disc_cover(light, ahead) if light.form == "disc" else _rectangle_cover(light, toward, ahead)
    card = np.sum(cover * np.maximum(ahead, 0.0) * areas, dtype=np.float64) / np.pi
    return cover[..., None] * (np.array(light.colour) * (light.intensity / card)).astype(np.float32)


def _rectangle_cover(light: AreaLight, toward: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """Coverage (H, W) in [0, 1] of each direction by a flat rectangle that faces the subject."""
    azimuth = np.radians(light.azimuth_deg)
    right = np.array([np.cos(azimuth), 0.0, -np.sin(azimuth)], np.float32)
    up = np.cross(direction_of(light.azimuth_deg, light.elevation_deg), right)
    across = np.degrees(np.arctan2(np.abs(toward @ right), ahead))
    along = np.degrees(np.arctan2(np.abs(toward @ up), ahead))
    texel_deg = 180.0 / toward.shape[0]
    fade = max(light.softness * min(light.width_deg, light.height_deg) / 2, texel_deg)
    return _inside(across, light.width_deg / 2, fade) * _inside(along, light.height_deg / 2, fade)


def _disc_cover(light: AreaLight, ahead: np.ndarray) -> np.ndarray:
    """Coverage (H, W) in [0, 1] of each direction by a disc or ring that faces the subject."""
    from_centre = np.degrees(np.arccos(np.clip(ahead, -1.0, 1.0)))
    texel_deg = 180.0 / ahead.shape[0]
    outer, inner = light.width_deg / 2, light.hole_deg / 2
    fade = max(light.softness * (outer - inner), texel_deg)
    cover = _inside(from_centre, outer, fade)
    return cover - _inside(from_centre, inner, fade) if inner > 0 else cover


def _inside(distance: np.ndarray, edge: float, fade: float) -> np.ndarray:
    """1 inside an edge and 0 outside, with a smooth step of width `fade` centred on it."""
    return smooth_ramp((edge - distance) / fade, -0.5, 0.5)


def _room(room: Room, toward: np.ndarray) -> np.ndarray:
    brightness = room.intensity * (1.0 + room.gradient * toward[..., 1:2])
    return (brightness * np.array(room.colour)).astype(np.float32)


def _sky(sky: Sky, toward: np.ndarray) -> np.ndarray:
    height = toward[..., 1:2]
    rise = np.maximum(height, 0.0) ** sky.haze
    zenith, horizon, ground = (np.array(c, np.float32) for c in (sky.zenith, sky.horizon, sky.ground))
    above = horizon + (zenith - horizon) * rise
    if sky.glow is not None:
        above = above + _glow(sky.glow, toward)
    share = smooth_ramp(height / _HORIZON_BLUR, -0.5, 0.5)
    return (sky.intensity * (ground + (above - ground) * share)).astype(np.float32)


def _glow(glow: Glow, toward: np.ndarray) -> np.ndarray:
    centre = direction_of(glow.azimuth_deg, glow.elevation_deg)
    from_centre = np.degrees(np.arccos(np.clip(toward @ centre, -1.0, 1.0)))
    falloff = np.exp2(-((2.0 * from_centre / glow.width_deg) ** 2))
    return falloff[..., None] * np.array(glow.colour, np.float32) * glow.intensity
