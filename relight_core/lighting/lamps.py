"""The small lamps of a light: suns, bulbs and spots, whose shadows have edges.

The light that the networks read has texels of 11 degrees, so that a sun in it is as soft as a window. Here the
places that are smaller than that are found in the panorama itself, with their direction, size and strength.
Nothing switches: a lamp that is enlarged, or dimmed against the rest, loses its `hardness` evenly.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from relight_core.imaging.colour import luminance
from relight_core.lighting.enlarge import draw_finer
from relight_core.lighting.environment import NETWORK_HEIGHT, Environment, shrink
from relight_core.lighting.roll import roll_light
from relight_core.lighting.sphere import directions, place_on_map, solid_angles, turned

_ROWS = 128
MOST_LAMPS, _ROUNDS = 4, 8
"""Lamps of a light, and bright places that are looked at for them: specks are brighter than many a sun."""
_AHEAD, _NO_HARDNESS = 1.25, 1e-3
_CORE_DEG, AROUND_DEG, BEYOND_DEG = 6.0, 12.0, 18.0
"""How far from its middle a lamp reaches in full, how far at most, and up to where its surroundings count."""

_DIMMEST = 4.0
_CENTRINGS = 3
_RADIUS_DEG = (7.5, 4.0)
_SHARE = (0.02, 0.06)


@dataclass(frozen=True)
class Lamp:
    """A small bright place of a light whose mean luminance is 1.

    Attributes:
        toward: unit vector, camera space.
        radius_deg: of a disc as spread out as it is.
        irradiance: that it gives a surface facing it, over pi.
        hardness: in (0, 1], how far it counts as small; 0 would be a window or next to no light.
    """

    toward: tuple[float, float, float]
    radius_deg: float
    irradiance: float
    hardness: float

    def turned(self, yaw_deg: float) -> Lamp:
        """As of the environment turned about +y; positive moves it to the right in the panorama."""
        return self._moved(*turned(np.array(self.toward), yaw_deg))

    def rolled(self, roll_deg: float) -> Lamp:
        """As a camera sees it that is turned counterclockwise as it looks (see `lighting.roll`)."""
        x, y, z = self.toward
        angle = np.radians(roll_deg)
        return self._moved(x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle), z)

    def _moved(self, x: float, y: float, z: float) -> Lamp:
        return replace(self, toward=(float(x), float(y), float(z)))


def lamps_of(environment: Environment, yaw_deg: float = 0.0) -> tuple[Lamp, ...]:
    """The small lamps of a light, those that give most first, at most 4; sought once per shape."""
    return tuple(lamp.turned(yaw_deg) for lamp in _foremost(bright_places(environment)))


def bright_places(environment: Environment) -> tuple[Lamp, ...]:
    """All that may be a small lamp, those that give most first, each with the hardness that it has by itself."""
    return environment.of_shape("bright places", lambda shape: _find(shape, environment.coarser_parts))


def footprint(lamp: Lamp, roll_deg: float = 0.0) -> np.ndarray:
    """Where a lamp's light lies in the light that the networks read, (16, 32) float32, sum 1.

    As `network_light` spreads it: over the width and height of a texel, and over the texels that it touches; and where
    a view is turned, as `roll_light` spreads that once more. Of a lamp that had been turned before, it would lie in
    other texels than the light does.

    Args:
        lamp: in the camera space of the photo.
        roll_deg: of the view.
    """
    share = _footprint(lamp, NETWORK_HEIGHT)
    if roll_deg:
        areas = solid_angles(*share.shape)
        share = roll_light(np.repeat((share / areas)[..., None], 3, -1), roll_deg)[..., 0] * areas
    return share / share.sum()


def _footprint(lamp: Lamp, height: int) -> np.ndarray:
    share = np.zeros((height, 2 * height), np.float32)
    for across, down in zip(*place_on_map(*_disc(lamp).T), strict=True):
        column, row = across * 2 * height - 0.5, min(max(down * height - 0.5, 0.0), height - 1.0)
        left, top = int(np.floor(column)), min(int(row), height - 2)
        for line, part in ((top, 1 - (row - top)), (top + 1, row - top)):
            share[line, left % (2 * height)] += part * (1 - (column - left))
            share[line, (left + 1) % (2 * height)] += part * (column - left)
    return share


def _disc(lamp: Lamp) -> np.ndarray:
    """(16, 3) unit vectors spread over a lamp's disc, as a sunflower spreads its seeds."""
    toward = np.array(lamp.toward)
    across = np.cross(toward, (0.0, 1.0, 0.0) if abs(toward[1]) < 0.9 else (1.0, 0.0, 0.0))
    across /= np.linalg.norm(across)
    seed = np.arange(16)
    distance = np.tan(np.radians(lamp.radius_deg)) * np.sqrt((seed + 0.5) / 16)
    angle = seed * np.pi * (3 - np.sqrt(5))
    points = toward + (distance * np.cos(angle))[:, None] * across
    points += (distance * np.sin(angle))[:, None] * np.cross(toward, across)
    return points / np.linalg.norm(points, axis=1, keepdims=True)


@dataclass(frozen=True)
class _Sky:
    """A light where lamps are sought, (h, 2h) float64 and (h, 2h, 3).

    Attributes:
        grey: luminance.
        toward: unit vectors.
        areas: solid angles.
        texel_deg_squared: height squared of the texels that the light there comes from, by shares of luminance.
    """

    grey: np.ndarray
    toward: np.ndarray
    areas: np.ndarray
    texel_deg_squared: np.ndarray


def _sky(shape: np.ndarray, coarser: tuple[np.ndarray, ...]) -> _Sky:
    grey = _grey(shape, min(len(shape), _ROWS))
    own = (180 / len(grey)) ** 2
    squared = np.full(grey.shape, own)
    for part in coarser:
        share = _grey(draw_finer(part, len(shape)), len(grey)) / np.maximum(grey, 1e-12)
        squared += np.minimum(share, 1) * max((180 / len(part)) ** 2 - own, 0)
    size = grey.shape
    return _Sky(grey, directions(*size).astype(np.float64), solid_angles(*size).astype(np.float64), squared)


def _grey(radiance: np.ndarray, rows: int) -> np.ndarray:
    fine = shrink(radiance, rows) if len(radiance) != rows else radiance
    return luminance(fine).astype(np.float64)


def _find(shape: np.ndarray, coarser: tuple[np.ndarray, ...]) -> tuple[Lamp, ...]:
    sky = _sky(shape, coarser)
    grey, toward = sky.grey, sky.toward
    left, lamps = np.ones(grey.shape), []
    for _ in range(_ROUNDS):
        peak = np.unravel_index((left * grey).argmax(), grey.shape)
        if left[peak] * grey[peak] < _DIMMEST:
            break
        centre = toward[peak]
        # The brightest texel of a disc may be at its rim: what lies around it is sought anew around its middle.
        # What belongs to one lamp is no part of another: the haze around a sun would be that sun once more.
        # All of it fades with distance, or another lamp that comes near would be drawn in all at once.
        for _ in range(_CENTRINGS):
            off_deg = np.degrees(np.arccos(np.clip(toward @ centre, -1, 1)))
            around = 1 - _ramp(off_deg, _CORE_DEG, AROUND_DEG)
            beyond = (1 - around) * (1 - _ramp(off_deg, 2 * AROUND_DEG - _CORE_DEG, 2 * BEYOND_DEG - AROUND_DEG))
            lamp = _measured(sky, left * around, left * beyond)
            centre = np.array(lamp.toward)
        # The corners of a window, of which the middle has been taken, are no lamps of their own.
        whole = _measured(sky, around, beyond)
        lamp = replace(lamp, hardness=min(lamp.hardness, _smallness(whole.radius_deg)))
        if lamp.hardness > 0:
            lamps.append(lamp)
        left *= 1 - around
        left[peak] = 0
    return tuple(sorted(lamps, key=_given, reverse=True))


def _given(lamp: Lamp) -> float:
    return lamp.irradiance * lamp.hardness


def _foremost(ranked: tuple[Lamp, ...]) -> tuple[Lamp, ...]:
    """The four that give most light; those that give hardly more than the fifth lose their hardness."""
    if len(ranked) <= MOST_LAMPS:
        return ranked
    fifth = _given(ranked[MOST_LAMPS])
    kept = (
        replace(lamp, hardness=float(lamp.hardness * _ramp(_given(lamp), fifth, _AHEAD * fifth)))
        for lamp in ranked[:MOST_LAMPS]
    )
    return tuple(lamp for lamp in kept if lamp.hardness > _NO_HARDNESS)


def _measured(sky: _Sky, around: np.ndarray, beyond: np.ndarray) -> Lamp:
    """What stands out `around` a place from what is `beyond` it, shares of every texel in [0, 1], as one lamp."""
    behind = (sky.grey * sky.areas * beyond).sum() / max((sky.areas * beyond).sum(), 1e-12)
    near = around > 0
    power = np.maximum(sky.grey - behind, 0)[near] * (sky.areas * around)[near]
    total = max(power.sum(), 1e-12)
    mean = power @ sky.toward[near]
    mean /= max(np.linalg.norm(mean), 1e-12)
    off_deg = np.degrees(np.arccos(np.clip(sky.toward[near] @ mean, -1, 1)))
    # A disc's mean squared distance from its middle is half its radius squared. What is smaller than a texel may
    # be as large as one.
    radius_deg = float(np.sqrt(2 * (power @ (off_deg**2 + sky.texel_deg_squared[near] / 4)) / total))
    hardness = float(_smallness(radius_deg) * _ramp(total / (4 * np.pi), *_SHARE))
    return Lamp(tuple(float(part) for part in mean), radius_deg, float(total / np.pi), hardness)


def _smallness(radius_deg: float) -> float:
    return float(_ramp(radius_deg, *_RADIUS_DEG))


def _ramp(value: float | np.ndarray, none: float, full: float) -> float | np.ndarray:
    return np.clip((value - none) / (full - none), 0, 1)
