"""The small lamps of a light: suns, bulbs and spots, whose shadows have edges.

The light that the networks read has texels of 11 degrees, so that a sun in it is as soft as a window. Here the
places that are smaller than that are found in the panorama itself, with their direction, size and strength.
Nothing switches: a lamp that is enlarged, or dimmed against the rest, loses its `hardness` by degrees.

How: bright peaks are centred (`_places`). Each is then measured as a disc (`_measured`): what stands out within
AROUND_DEG of its centre from the mean of the ring beyond, up to `_FARTHEST_DEG`, is the lamp's light; the second
moment of that light gives the radius. Where lamps are close together, light is shared between them (`_claims`), and
no lamp is part of another's ring.
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
"""Rows of the panorama in which lamps are sought, at the most."""
MOST_LAMPS, _ROUNDS = 4, 8
"""Lamps of a light, and bright places that are looked at for them: specks are brighter than many a sun."""
_AHEAD = 1.25
"""A lamp that gives less than so many times what the first one left out gives loses hardness."""
_NO_HARDNESS = 1e-3

_CORE_DEG, AROUND_DEG, BEYOND_DEG = 6.0, 12.0, 18.0
"""How far from its centre a lamp's light counts in full, and how far at most; and up to where the ring around it, whose
mean is the background that it stands out from, counts in full."""
_FARTHEST_DEG = 2 * BEYOND_DEG - AROUND_DEG
"""Where that ring ends."""
_NEAR_DEG, _CENTRINGS = (3.0, 6.0), 6
"""How far off light counts in full, and at all, when a peak is moved to the centroid of the light about it, and how
often that is done."""

_DIMMEST = 4.0
"""Radiance of the dimmest peak, in means of the sphere."""
_RADIUS_DEG = (7.5, 4.0)
"""Radii from which down on a lamp counts as small, in part and altogether."""
_SHARE = (0.02, 0.06)
"""Shares of all light that a lamp gives from which on it counts, in part and altogether."""


@dataclass(frozen=True)
class Lamp:
    """A small bright place of a light whose mean luminance is 1.

    Attributes:
        toward: unit vector, camera space.
        radius_deg: of the even disc whose light has the same second moment.
        irradiance: that it gives a surface facing it, over pi, >= 0.
        hardness: in (0, 1], how far it counts as small; 0 would be a window or next to no light.
        alone: this lamp as a light of its own, before it was turned; None for an even disc.
        yaw_deg: by how much the lamp has been turned since.
    """

    toward: tuple[float, float, float]
    radius_deg: float
    irradiance: float
    hardness: float
    alone: Environment | None = field(default=None, compare=False, repr=False)
    yaw_deg: float = field(default=0.0, compare=False, repr=False)

    def turned(self, yaw_deg: float) -> Lamp:
        """As of the environment turned about +y; positive moves it to the right in the panorama."""
        return replace(self._moved(*turned(np.array(self.toward), yaw_deg)), yaw_deg=self.yaw_deg + yaw_deg)

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
    """How a lamp's power is spread over the texels of the light that the networks read, (16, 32) float32, sum 1.

    The lamp's own texels go through `network_light`, as the whole light does, and for a turned view through
    `roll_light` afterwards. Both orders and kernels must be the light's, or the lamp could not be subtracted from it:
    near a pole, for example, the smallest disc reaches farther around than a sun's single texel.

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
    """A light where lamps are sought: n texels of a panorama, float64.

    Attributes:
        grey: (n,) luminance of the radiance.
        toward: (n, 3) unit vectors.
        areas: (n,) solid angles in steradians.
        texel_deg_squared: (n,) squared height of the texels that the light there was drawn from, averaged by luminance
            where a coarser map is a part of it.
    """

    grey: np.ndarray
    toward: np.ndarray
    areas: np.ndarray
    texel_deg_squared: np.ndarray

    def within(self, most_deg: float, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The texels that are no farther from a direction, and how far each is, in degrees."""
        ahead = self.toward @ centre
        near = np.flatnonzero(ahead > np.cos(np.radians(most_deg)))
        return near, np.degrees(np.arccos(np.minimum(ahead[near], 1)))


@dataclass(frozen=True)
class _Place:
    """A bright place.

    Attributes:
        centre: (3,) unit vector.
        near: (m,) indices of the texels within `_FARTHEST_DEG`.
        off_deg: (m,) how far each of them is from the centre.
        power: radiance times solid angle of what lies near the centre.
    """

    centre: np.ndarray
    near: np.ndarray
    off_deg: np.ndarray
    power: float


def _sky(shape: np.ndarray, coarser: tuple[np.ndarray, ...]) -> _Sky:
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
    fine = shrink(radiance, rows) if len(radiance) != rows else radiance
    return luminance(fine).astype(np.float64)


def _find(shape: np.ndarray, coarser: tuple[np.ndarray, ...]) -> tuple[Lamp, ...]:
    """`bright_places` of a light's shape (H, 2H, 3); `coarser` as of `Environment.coarser_parts`."""
    sky = _sky(shape, coarser)
    places = _places(sky)
    around = np.zeros((len(places), sky.grey.size))
    for share, place in zip(around, places, strict=True):
        share[place.near] = _around(place.off_deg)
    of_none, lamps = np.prod(1 - around, axis=0), []
    for place, share, claim in zip(places, around, _claims(places, around), strict=True):
        near, beyond = place.near, _beyond(place.off_deg)
        # What belongs to another lamp is left out of the ring. This one's own share in `of_none` is divided out.
        lamp, radiance = _measured(sky, near, claim[near], beyond * of_none[near] / np.maximum(1 - share[near], 1e-12))
        # Measured once more as if no other place had a claim: a window's corners, whose middle is claimed by another
        # place, are no small lamps, and two lamps that share their light are as hard as if one had all of it.
        whole, _ = _measured(sky, near, share[near], beyond)
        hardness = min(lamp.hardness, _smallness(whole.radius_deg)) * ramp(whole.irradiance / 4, *_SHARE)
        if hardness > 0:
            lamps.append(replace(lamp, hardness=float(hardness), alone=_alone(sky, near, radiance)))
    return tuple(sorted(lamps, key=_given, reverse=True))


def _places(sky: _Sky) -> list[_Place]:
    """Bright places, the brightest first.

    The brightest texel of a disc may be at its rim, so each place is moved to the centroid of the light around it. Only
    light within a few degrees counts for that, so that two lamps near each other don't draw each other's centres.
    """
    left, found = np.ones(sky.grey.size), []
    for _ in range(_ROUNDS):
        peak = int((left * sky.grey).argmax())
        if left[peak] * sky.grey[peak] < _DIMMEST:
            break
        centre = sky.toward[peak]
        looked_at, from_peak_deg = sky.within(_NEAR_DEG[1], centre)
        for _ in range(_CENTRINGS):
            near, off_deg = sky.within(_NEAR_DEG[1], centre)
            power = sky.grey[near] * sky.areas[near] * (1 - ramp(off_deg, *_NEAR_DEG))
            centre = power @ sky.toward[near]
            centre /= np.linalg.norm(centre)
        place = _Place(centre, *sky.within(_FARTHEST_DEG, centre), float(power.sum()))
        left[place.near] *= 1 - _around(place.off_deg)
        left[looked_at] *= ramp(from_peak_deg, *_NEAR_DEG)
        if all(centre @ other.centre < np.cos(np.radians(_NEAR_DEG[0])) for other in found):
            found.append(place)
    return found


def _around(off_deg: np.ndarray) -> np.ndarray:
    """Share of the light at a distance from a lamp's centre that is the lamp's, [0, 1]; smooth at both ends."""
    return 1 - smooth_ramp(off_deg, _CORE_DEG, AROUND_DEG)


def _beyond(off_deg: np.ndarray) -> np.ndarray:
    """Weight of the light at a distance from a lamp's centre in the background that it stands out from, [0, 1]."""
    return (1 - _around(off_deg)) * (1 - ramp(off_deg, 2 * AROUND_DEG - _CORE_DEG, _FARTHEST_DEG))


def _claims(places: list[_Place], around: np.ndarray) -> np.ndarray:
    """(places, n) the share of each texel that is each place's, [0, 1]; several places share by their power."""
    weights = around * np.array([place.power for place in places]).reshape(-1, 1)
    return around * weights / np.maximum(weights.sum(0), 1e-12)


def _given(lamp: Lamp) -> float:
    return lamp.irradiance * lamp.hardness


def _foremost(ranked: tuple[Lamp, ...]) -> tuple[Lamp, ...]:
    """The four that give most light; those that give hardly more than the fifth lose their hardness."""
    if len(ranked) <= MOST_LAMPS:
        return ranked
    fifth = _given(ranked[MOST_LAMPS])
    kept = (
        replace(lamp, hardness=float(lamp.hardness * ramp(_given(lamp), fifth, _AHEAD * fifth)))
        for lamp in ranked[:MOST_LAMPS]
    )
    return tuple(lamp for lamp in kept if lamp.hardness > _NO_HARDNESS)


def _measured(sky: _Sky, near: np.ndarray, around: np.ndarray, beyond: np.ndarray) -> tuple[Lamp, np.ndarray]:
    """The light near a place above its background, as one lamp that is as hard as its size alone makes it.

    Args:
        near: (m,) indices of the texels.
        around, beyond: (m,) shares in [0, 1] of each that are the lamp's, and that count as its background.

    Returns:
        the lamp, and (m,) the luminance of its light in those texels.
    """
    grey, areas, toward = sky.grey[near], sky.areas[near], sky.toward[near]
    behind = (grey * areas * beyond).sum() / max((areas * beyond).sum(), 1e-12)
    radiance = np.maximum(grey - behind, 0) * around
    power = radiance * areas
    total = max(power.sum(), 1e-12)
    mean = power @ toward
    mean /= max(np.linalg.norm(mean), 1e-12)
    off_deg = np.degrees(np.arccos(np.clip(toward @ mean, -1, 1)))
    # A disc's mean squared distance from its middle is half its radius squared. What is smaller than a texel may
    # be as large as one.
    radius_deg = float(np.sqrt(2 * (power @ (off_deg**2 + sky.texel_deg_squared[near] / 4)) / total))
    toward = tuple(float(part) for part in mean)
    return Lamp(toward, radius_deg, float(total / np.pi), _smallness(radius_deg)), radiance


def _alone(sky: _Sky, near: np.ndarray, radiance: np.ndarray) -> Environment:
    """The light of a lamp, (m,) in the texels near it, and none in all others."""
    panorama = np.zeros(sky.grey.size, np.float32)
    panorama[near] = radiance
    height = math.isqrt(panorama.size // 2)
    return Environment.from_radiance(panorama.reshape(height, 2 * height))


def _smallness(radius_deg: float) -> float:
    return ramp(radius_deg, *_RADIUS_DEG)
