"""A light's own lamps as soft boxes, and the room: what remains of the light without them.

A bundled light is drawn from lamps, so they are known. In a panorama they are its small lamps, such as suns and bulbs:
what exceeds its surroundings becomes a disc of the same irradiance, colour and second moment.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from relight_core.imaging.colour import REC709_LUMINANCE
from relight_core.lighting.environment import Environment
from relight_core.lighting.lamps import AROUND_DEG, BEYOND_DEG, MOST_LAMPS, Lamp, bright_places
from relight_core.lighting.panorama import shrink
from relight_core.lighting.rig_description import AreaLight
from relight_core.lighting.rig_render import render_rig
from relight_core.lighting.soft_box import SoftBox, moved_to, possible_size_deg
from relight_core.lighting.sphere import directions, solid_angles
from relight_core.lighting.summary import meter_reading

_MEASURED_HEIGHT = 256
"""Rows of the panorama in which lamps are measured, at most."""

_LEAST_SHARE = 0.02
"""A lamp of a panorama gives at least this share of all the light."""

_SIDES, _SIDES_OFF_DEG = 16, (AROUND_DEG + BEYOND_DEG) / 2
"""The ring around a lamp is averaged in so many sectors, whose mean angle from the lamp's centre is this."""

_RIM_DEG = 3.0
"""Over the last degrees before AROUND_DEG a lamp's light fades into its surroundings, so that no edge shows."""


def own_lamps(light: Environment) -> tuple[SoftBox, ...]:
    """The light's own lamps; for a panorama at most 4, the strongest first. Empty if it has none.

    Their intensities are multiples of the light's meter reading, like those of any soft box added to it.
    """
    find = _lamps_of_panorama if light.drawn is None else _lamps_of_rig
    return light.of_shape("own lamps", lambda shape: find(light))


def room_of(light: Environment) -> np.ndarray | None:
    """The light without its own lamps, (H, 2H, 3) in units of its shape; None if it has no lamps."""
    if not own_lamps(light):
        return None
    find = _room_of_panorama if light.drawn is None else _room_of_rig
    return light.of_shape("room", lambda shape: find(light))


def _lamps_of_rig(light: Environment) -> tuple[SoftBox, ...]:
    unit = light.drawn.level * meter_reading(light)
    return tuple(_as_box(lamp, unit) for lamp in light.drawn.rig.area_lights if not lamp.backdrop)


def _room_of_rig(light: Environment) -> np.ndarray:
    rig = light.drawn.rig
    backdrops = tuple(lamp for lamp in rig.area_lights if lamp.backdrop)
    return render_rig(replace(rig, area_lights=backdrops), light.height) / np.float32(light.drawn.level)


def _as_box(lamp: AreaLight, unit: float) -> SoftBox:
    """A rig's lamp as a soft box of the same irradiance, given that an intensity of 1 stands for `unit`.

    Its size is clamped to that of soft boxes.
    """
    box = SoftBox(
        azimuth_deg=(lamp.azimuth_deg + 180.0) % 360.0 - 180.0,
        elevation_deg=lamp.elevation_deg,
        width_deg=possible_size_deg(lamp.width_deg),
        height_deg=possible_size_deg(lamp.height_deg),
        softness=lamp.softness,
        colour=None if lamp.kelvin is not None else lamp.colour,
        intensity=float(np.dot(lamp.colour, REC709_LUMINANCE)) * lamp.intensity / unit,
        form=lamp.form,
        hole=lamp.hole_deg / lamp.width_deg,
        name=lamp.name or "lamp",
    )
    return box if lamp.kelvin is None else replace(box, kelvin=lamp.kelvin)


def _small_lamps(light: Environment) -> tuple[Lamp, ...]:
    """The small lamps of a panorama that give enough light to be worth moving, at most 4."""
    # A bright place beside a sun, such as a cloud's rim, may have hardness but give next to no light.
    return tuple(lamp for lamp in bright_places(light) if lamp.irradiance / 4 > _LEAST_SHARE)[:MOST_LAMPS]


def _lamps_of_panorama(light: Environment) -> tuple[SoftBox, ...]:
    lamps = _small_lamps(light)
    if not lamps:
        return ()
    small = shrink(light.shape, _MEASURED_HEIGHT) if light.height > _MEASURED_HEIGHT else light.shape
    names = ["lamp"] if len(lamps) == 1 else [f"lamp {number}" for number in range(1, len(lamps) + 1)]
    parts = zip(names, lamps, _without_lamps(small, lamps)[1], strict=True)
    return tuple(_disc(name, lamp, card, meter_reading(light)) for name, lamp, card in parts)


def _room_of_panorama(light: Environment) -> np.ndarray:
    return _without_lamps(light.shape, _small_lamps(light))[0]


def _disc(name: str, lamp: Lamp, card: np.ndarray, unit: float) -> SoftBox:
    """A disc in a lamp's place and of its size, under which a white card that faces it has the radiance `card` (3,)."""
    luminance = float(card @ REC709_LUMINANCE)
    size = possible_size_deg(2 * lamp.radius_deg)
    colour = tuple(float(part) for part in card / max(luminance, 1e-12))
    disc = SoftBox(0.0, 0.0, size, size, 0.2, colour=colour, intensity=luminance / unit, form="disc", name=name)
    return moved_to(disc, np.array(lamp.toward))


def _without_lamps(shape: np.ndarray, lamps: Sequence[Lamp]) -> tuple[np.ndarray, list[np.ndarray]]:
    """A panorama without its lamps, and for each lamp the radiance (3,) of a white card that faces it.

    A lamp is replaced by its surroundings, continued over it, where it is brighter than these. Lamps that are close
    together divide the texels by distance, and none is part of another's surroundings.
    """
    toward, areas = directions(*shape.shape[:2]), solid_angles(*shape.shape[:2])
    ahead = np.stack([toward @ np.array(lamp.toward, np.float32) for lamp in lamps])
    nearest, of_any = ahead.argmax(0), ahead.max(0) > math.cos(math.radians(AROUND_DEG))
    left, cards = shape.copy(), []
    for index, lamp in enumerate(lamps):
        around = of_any & (nearest == index)
        beyond = (ahead[index] > math.cos(math.radians(BEYOND_DEG))) & ~of_any
        off_deg = np.degrees(np.arccos(np.minimum(ahead[index][around], 1)))
        sides = _sides(shape[beyond], areas[beyond], _bearing(lamp, toward[beyond]))
        behind = np.minimum(shape[around], _continued(sides, _bearing(lamp, toward[around]), off_deg))
        share = np.clip((AROUND_DEG - off_deg) / _RIM_DEG, 0, 1)[:, None]
        given = share * (shape[around] - behind)
        cards.append((ahead[index] * areas)[around].astype(np.float64) @ given / np.pi)
        left[around] = behind + (1 - share) * (shape[around] - behind)
    return left, cards


def _bearing(lamp: Lamp, toward: np.ndarray) -> np.ndarray:
    """The angle around a lamp at which other directions (n, 3) lie, in turns, (n,) in [0, 1)."""
    middle = np.array(lamp.toward)
    right = np.cross((0.0, 1.0, 0.0) if abs(middle[1]) < 0.9 else (1.0, 0.0, 0.0), middle)
    return np.arctan2(toward @ np.cross(middle, right), toward @ right) / (2 * np.pi) % 1.0


def _sides(radiance: np.ndarray, areas: np.ndarray, bearing: np.ndarray) -> np.ndarray:
    """Mean radiance around a lamp by sector, (16, 3).

    Args:
        radiance, areas, bearing: (n, 3), (n,) and (n,) of the texels around it.

    Returns:
        Sectors without texels are interpolated from the others; without any texels all are black.
    """
    sector = (bearing * _SIDES).astype(int) % _SIDES
    light = np.stack([np.bincount(sector, areas * part, _SIDES) for part in radiance.T], 1)
    area = np.bincount(sector, areas, _SIDES)
    known = area > 0
    if not known.any():
        return light
    colours, places = light[known] / area[known, None], np.flatnonzero(known)
    return np.stack([np.interp(np.arange(_SIDES), places, part, period=_SIDES) for part in colours.T], 1)


def _continued(sides: np.ndarray, bearing: np.ndarray, off_deg: np.ndarray) -> np.ndarray:
    """The surroundings of a lamp continued over it: (m, 3) radiance at bearings and angles from its centre (m,)."""
    places = np.arange(_SIDES)
    rim = np.stack([np.interp(bearing * _SIDES - 0.5, places, part, period=_SIDES) for part in sides.T], 1)
    # The median, since the mean of sky and ground would be a colour that neither has.
    middle = np.median(sides, axis=0)
    return (middle + off_deg[:, None] * (rim - middle) / _SIDES_OFF_DEG).astype(np.float32)
