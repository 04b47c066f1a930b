"""The small lamps of a light: suns, bulbs and spots, whose shadows have edges.

The light that the networks read has texels of 11 degrees, in which a sun is as soft as a window. So smaller bright
places are found in the panorama itself, with their direction, size and strength. Nothing switches abruptly: a lamp
that is enlarged, or dimmed relative to the rest, loses its `hardness` gradually.

How: bright peaks are moved to the centroid of the light around them (`_places`). Each is then measured as a disc
(`_measured`). Its background is the mean of a ring around it; what exceeds the background within AROUND_DEG of the
centre is the lamp's light, and the second moment of that light gives the radius. Lamps that are close together share
the light between them (`_claims`), and no lamp is part of another's ring.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from relight_core.imaging.colour import luminance
from relight_core.imaging.ramp import ramp, smooth_ramp
from relight_core.lighting.enlarge import draw_finer
from relight_core.lighting.environment import NETWORK_HEIGHT, Environment, network_light
from relight_core.lighting.panorama import shrink
from relight_core.lighting.roll import roll_light
from relight_core.lighting.sphere import directions, place_on_map, solid_angles, turned

_ROWS = 128
"""Lamps are searched for in a panorama of at most so many rows."""
MOST_LAMPS, _ROUNDS = 4, 8
"""Lamps that a light has at most, and bright places that are examined for them: a speck may be brighter than a sun."""
_AHEAD = 1.25
"""A lamp must give so many times as much light as the strongest one left out to keep its full hardness, so that nothing
jumps when two lamps swap ranks."""
_NO_HARDNESS = 1e-3
"""Lamps with no more hardness than this are dropped."""

_CORE_DEG, AROUND_DEG, BEYOND_DEG = 6.0, 12.0, 18.0
"""Angles from a lamp's centre: up to the first, light is wholly the lamp's; from the second on, not at all. The ring
around it, whose mean is its background, has its full weight up to the third."""
_FARTHEST_DEG = 2 * BEYOND_DEG - AROUND_DEG
"""Where that ring ends."""
_NEAR_DEG, _CENTRINGS = (3.0, 6.0), 6
"""A peak is moved six times to the centroid of the light around it. Light counts in full up to 3 degrees from it, and
not at all from 6 on."""

_DIMMEST = 4.0
"""Radiance of the dimmest peak, as a multiple of the mean over the sphere."""
_RADIUS_DEG = (7.5, 4.0)
"""Ramp of radii: from the first one down a lamp begins to count as small, from the second one down it is."""
_SHARE = (0.02, 0.06)
"""Ramp of a lamp's share of all light: from the first one on it begins to count, from the second one on it does."""


@dataclass(frozen=True)
class Lamp:
    """A small bright place of a light whose mean luminance is 1.

    Attributes:
        toward: unit vector, camera space.
        radius_deg: of a uniform disc whose light has the same second moment.
        irradiance: on a surface that faces it, over pi, >= 0.
        hardness: in (0, 1], to what degree it counts as a small lamp; large or faint ones approach 0.
        alone: a light with only this lamp, before it was rotated; None for a uniform disc.
        yaw_deg: by how much the lamp has been rotated since.
    """

    toward: tuple[float, float, float]
    radius_deg: float
    irradiance: float
    hardness: float
    alone: Environment | None = field(default=None, compare=False, repr=False)
    yaw_deg: float = field(default=0.0, compare=False, repr=False)

    def turned(self, yaw_deg: float) -> Lamp:
        """The lamp in the environment rotated about +y; positive moves it to the right in the panorama."""
        return replace(self._moved(*turned(np.array(self.toward), yaw_deg)), yaw_deg=self.yaw_deg + yaw_deg)

    def rolled(self, roll_deg: float) -> Lamp:
        """The lamp in the camera space of a camera rolled counterclockwise, seen in viewing direction (see `roll`)."""
        x, y, z = self.toward
        angle = np.radians(roll_deg)
        return self._moved(x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle), z)

    def _moved(self, x: float, y: float, z: float) -> Lamp:
        return replace(self, toward=(float(x), float(y), float(z)))


def lamps_of(environment: Environment, yaw_deg: float = 0.0) -> tuple[Lamp, ...]:
    """The small lamps of a light, at most 4, the strongest first; searched for once per shape."""
    return tuple(lamp.turned(yaw_deg) for lamp in _strongest(bright_places(environment)))


def bright_places(environment: Environment) -> tuple[Lamp, ...]:
    """All that may be a small lamp, the strongest first, each with its hardness before lamps compete for the 4."""
    return environment.of_shape("bright places", lambda shape: _find(shape, environment.coarser_parts))


def footprint(lamp: Lamp, roll_deg: float = 0.0) -> np.ndarray:
    """How a lamp's power is distributed over the texels of the networks' light, (16, 32) float32 of sum 1.

    The lamp's own texels go through `network_light` and, for a rolled view, then through `roll_light`, exactly as the
    whole light does. With other kernels or another order the lamp could not be subtracted from the light: near a
    pole, for example, even the smallest disc covers a wider range of azimuths than a sun's single texel.

    Args:
        lamp: in the camera space of the photo.
        roll_deg: of the view.
    """
    areas = solid_angles(NETWORK_HEIGHT, 2 * NETWORK_HEIGHT)
    if lamp.alone is None:
        share = _footprint_of_disc(lamp, NETWORK_HEIGHT)
    else:
        share = network_light(lamp.alone, lamp.yaw_deg)[..., 0] * areas
    if roll_deg:
        share = roll_light(np.repeat((share / areas)[..., None], 3, -1), roll_deg)[..., 0] * areas
    return share / share.sum()


def _footprint_of_disc(lamp: Lamp, height: int) -> np.ndarray:
    """`footprint` of a uniform disc: points on it, each divided bilinearly among four texels of (height, 2 height)."""
    share = np.zeros((height, 2 * height), np.float32)
    for across, down in zip(*place_on_map(*_disc(lamp).T), strict=True):
        column, row = across * 2 * height - 0.5, min(max(down * height - 0.5, 0.0), height - 1.0)
        left, top = int(np.floor(column)), min(int(row), height - 2)
        for line, part in ((top, 1 - (row - top)), (top + 1, row - top)):
            share[line, left % (2 * height)] += part * (1 - (column - left))
            share[line, (left + 1) % (2 * height)] += part * (column - left)
    return share


def _disc(lamp: Lamp) -> np.ndarray:
    """(16, 3) unit vectors spread evenly over a lamp's disc, in the spiral of a sunflower's seeds."""
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
    """The panorama in which lamps are searched for, as n texels, float64.

    Attributes:
        grey: (n,) luminance of the radiance.
        toward: (n, 3) unit vectors.
        areas: (n,) solid angles in steradians.
        texel_deg_squared: (n,) squared height of a texel in the map that the light came from: an average weighted by
            luminance where a coarser map is part of the sum.
    """

    grey: np.ndarray
    toward: np.ndarray
    areas: np.ndarray
    texel_deg_squared: np.ndarray

    def within(self, most_deg: float, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Indices of the texels within an angle of a direction, and the angle of each, in degrees."""
        ahead = self.toward @ centre
        near = np.flatnonzero(ahead > np.cos(np.radians(most_deg)))
        return near, np.degrees(np.arccos(np.minimum(ahead[near], 1)))


@dataclass(frozen=True)
class _Place:
    """A bright place that may be a lamp.

    Attributes:
        centre: (3,) unit vector.
        near: (m,) indices of the texels within `_FARTHEST_DEG`.
        off_deg: (m,) angle of each of them from the centre.
        power: radiance times solid angle, summed over the light that counted for the centroid.
    """

    centre: np.ndarray
    near: np.ndarray
    off_deg: np.ndarray
    power: float


def _sky(shape: np.ndarray, coarser: tuple[np.ndarray, ...]) -> _Sky:
    """The panorama to search, from a light's shape and its `Environment.coarser_parts`."""
    grey = _grey(shape, min(len(shape), _ROWS))
    own = (180 / len(grey)) ** 2
    squared = np.full(grey.shape, own)
    for part in coarser:
        if len(part) < len(grey):
            share = luminance(draw_finer(part, len(grey))) / np.maximum(grey, 1e-12)
            squared += np.minimum(share, 1) * ((180 / len(part)) ** 2 - own)
    toward, areas = directions(*grey.shape).astype(np.float64), solid_angles(*grey.shape).astype(np.float64)
    return _Sky(grey.ravel(), toward.reshape(-1, 3), areas.ravel(), squared.ravel())


def _grey(radiance: np.ndarray, rows: int) -> np.ndarray:
    """Luminance of a panorama at so many rows, float64."""
    fine = shrink(radiance, rows) if len(radiance) != rows else radiance
    return luminance(fine).astype(np.float64)


def _find(shape: np.ndarray, coarser: tuple[np.ndarray, ...]) -> tuple[Lamp, ...]:
    """`bright_places` of a light's shape (H, 2H, 3), with its `Environment.coarser_parts`."""
    sky = _sky(shape, coarser)
    places = _places(sky)
    around = np.zeros((len(places), sky.grey.size))
    for share, place in zip(around, places, strict=True):
        share[place.near] = _core_weight(place.off_deg)
    of_no_lamp, lamps = np.prod(1 - around, axis=0), []
    for place, share, claim in zip(places, around, _claims(places, around), strict=True):
        near, beyond = place.near, _ring_weight(place.off_deg)
        # The ring excludes what belongs to other lamps: `of_no_lamp`, from which this lamp's own share is divided out.
        ring = beyond * of_no_lamp[near] / np.maximum(1 - share[near], 1e-12)
        lamp, radiance = _measured(sky, near, claim[near], ring)
        # Measured again as if no other place had a claim. A window's corner is not a small lamp only because another
        # place claims the window's middle. And two lamps that share their light stay as hard as one with all of it.
        whole, _ = _measured(sky, near, share[near], beyond)
        hardness = min(lamp.hardness, _smallness(whole.radius_deg)) * ramp(whole.irradiance / 4, *_SHARE)
        if hardness > 0:
            lamps.append(replace(lamp, hardness=float(hardness), alone=_alone(sky, near, radiance)))
    return tuple(sorted(lamps, key=_strength, reverse=True))


def _places(sky: _Sky) -> list[_Place]:
    """Bright places, the brightest first.

    The brightest texel of a disc may be at its rim, so each place is moved to the centroid of the light around it. Only
    light within a few degrees counts for that, so that two neighbouring lamps don't attract each other's centres.
    """
    left, found = np.ones(sky.grey.size), []
    for _ in range(_ROUNDS):
        peak = int((left * sky.grey).argmax())
        if left[peak] * sky.grey[peak] < _DIMMEST:
            break
        centre = sky.toward[peak]
        around_peak, from_peak_deg = sky.within(_NEAR_DEG[1], centre)
        for _ in range(_CENTRINGS):
            near, off_deg = sky.within(_NEAR_DEG[1], centre)
            power = sky.grey[near] * sky.areas[near] * (1 - ramp(off_deg, *_NEAR_DEG))
            centre = power @ sky.toward[near]
            centre /= np.linalg.norm(centre)
        place = _Place(centre, *sky.within(_FARTHEST_DEG, centre), float(power.sum()))
        left[place.near] *= 1 - _core_weight(place.off_deg)
        left[around_peak] *= ramp(from_peak_deg, *_NEAR_DEG)
        if all(centre @ other.centre < np.cos(np.radians(_NEAR_DEG[0])) for other in found):
            found.append(place)
    return found


def _core_weight(off_deg: np.ndarray) -> np.ndarray:
    """Share of the light that may be the lamp's, [0, 1], by angle from its centre; smooth at both ends."""
    return 1 - smooth_ramp(off_deg, _CORE_DEG, AROUND_DEG)


def _ring_weight(off_deg: np.ndarray) -> np.ndarray:
    """Weight of the light in the ring that gives a lamp's background, [0, 1], by angle from its centre."""
    return (1 - _core_weight(off_deg)) * (1 - ramp(off_deg, 2 * AROUND_DEG - _CORE_DEG, _FARTHEST_DEG))


def _claims(places: list[_Place], around: np.ndarray) -> np.ndarray:
    """Share of each texel's light that belongs to each place, (places, n) in [0, 1]: divided in proportion to power."""
    weights = around * np.array([place.power for place in places]).reshape(-1, 1)
    return around * weights / np.maximum(weights.sum(0), 1e-12)


def _strength(lamp: Lamp) -> float:
    """What lamps are ranked by: their light, weighted by hardness."""
    return lamp.irradiance * lamp.hardness


def _strongest(ranked: tuple[Lamp, ...]) -> tuple[Lamp, ...]:
    """The four strongest lamps; those that are hardly stronger than the fifth lose some hardness."""
    if len(ranked) <= MOST_LAMPS:
        return ranked
    fifth = _strength(ranked[MOST_LAMPS])
    kept = (
        replace(lamp, hardness=float(lamp.hardness * ramp(_strength(lamp), fifth, _AHEAD * fifth)))
        for lamp in ranked[:MOST_LAMPS]
    )
    return tuple(lamp for lamp in kept if lamp.hardness > _NO_HARDNESS)


def _measured(sky: _Sky, near: np.ndarray, around: np.ndarray, beyond: np.ndarray) -> tuple[Lamp, np.ndarray]:
    """Measure the light near a place above its background as one lamp, whose hardness follows from its size alone.

    Args:
        near: (m,) indices of the texels.
        around, beyond: (m,) in [0, 1], each texel's share that may be the lamp's, and its weight in the background.

    Returns:
        The lamp, and the luminance of its light in those texels, (m,).
    """
    grey, areas, toward = sky.grey[near], sky.areas[near], sky.toward[near]
    behind = (grey * areas * beyond).sum() / max((areas * beyond).sum(), 1e-12)
    radiance = np.maximum(grey - behind, 0) * around
    power = radiance * areas
    total = max(power.sum(), 1e-12)
    mean = power @ toward
    mean /= max(np.linalg.norm(mean), 1e-12)
    off_deg = np.degrees(np.arccos(np.clip(toward @ mean, -1, 1)))
    # A disc's mean squared distance from its centre is half its squared radius. What is smaller than a texel can't be
    # told from a lamp of a texel's size, so half a texel's height is added in quadrature.
    radius_deg = float(np.sqrt(2 * (power @ (off_deg**2 + sky.texel_deg_squared[near] / 4)) / total))
    toward = tuple(float(part) for part in mean)
    return Lamp(toward, radius_deg, float(total / np.pi), _smallness(radius_deg)), radiance


def _alone(sky: _Sky, near: np.ndarray, radiance: np.ndarray) -> Environment:
    """A light that has a lamp's radiance (m,) in the texels near it, and is black elsewhere."""
    panorama = np.zeros(sky.grey.size, np.float32)
    panorama[near] = radiance
    height = math.isqrt(panorama.size // 2)
    return Environment.from_radiance(panorama.reshape(height, 2 * height))


def _smallness(radius_deg: float) -> float:
    """The hardness in [0, 1] that follows from a lamp's size alone."""
    return ramp(radius_deg, *_RADIUS_DEG)
