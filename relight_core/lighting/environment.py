"""A light as a lat-long panorama: its shape and level, turned about +y and shrunk without losing energy.

Rows run from +y (row 0) to -y; the centre column looks along -z and the right of the map is +x.
A texel stands for constant radiance over its own patch of the sphere, which is what makes the
averages below exact.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from relight_core.errors import InputError
from relight_core.imaging.colour import REC709_LUMINANCE

if TYPE_CHECKING:
    from relight_core.lighting.rig_render import Drawn

WORKING_HEIGHT = 1024
"""Rows a map keeps at most: enough for a background, small enough to turn while the user drags."""

NETWORK_HEIGHT = 16
"""Rows of the light that the networks read (paper, sec. 3.2: 16 x 32)."""

_BLOCK_ROWS = 64
_BALANCINGS = 300

_T = TypeVar("_T")


@dataclass(frozen=True, eq=False)
class Environment:
    """A light, split into what it looks like and how strong it is.

    Two environments are equal only if they are the same object; `fingerprint` compares contents.

    Attributes:
        shape: (H, 2H, 3) float32 linear Rec.709 radiance whose mean luminance over the sphere is 1;
            all zero for a map without light. Read-only where this module made it.
        level: that mean in the map's own units; shape * level is the map. At least 0, which is no light.
        name: for messages and the window.
        drawn: what it was drawn from, of which `own_lamps` knows its lamps; None for any other light.
    """

    shape: np.ndarray = field(repr=False)
    level: float
    name: str = ""
    drawn: Drawn | None = field(default=None, repr=False)
    _found: dict[Hashable, Any] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        if not self.level >= 0:
            raise InputError(f"{self.name or 'the light'}: a light's level is a number from 0 on, not {self.level:g}")

    @classmethod
    def from_radiance(
        cls, radiance: np.ndarray, name: str = "", max_height: int | None = WORKING_HEIGHT
    ) -> Environment:
        """Split a panorama into shape and level.

        NaN, negative and -inf values become 0 and +inf the largest finite value, with a warning that
        counts them.

        Args:
            radiance: (H, 2H, 3), (H, 2H, 1) or (H, 2H) linear radiance of any number type.
            name: for messages and the window.
            max_height: larger maps are shrunk by area to this many rows; None keeps them.

        Raises:
            InputError: not a 2:1 panorama, or not one finite value in it.
        """
        cleaned = _clean(_as_panorama(np.asarray(radiance), name), name)
        if max_height is not None and cleaned.shape[0] > max_height:
            cleaned = shrink(cleaned, max_height)
        level = mean_luminance(cleaned)
        scale = np.float64(0.0 if level == 0.0 else 1.0 / level)
        shape = (cleaned * scale).astype(np.float32)
        shape.setflags(write=False)
        return cls(shape, level, name)

    @classmethod
    def of_parts(cls, radiance: np.ndarray, parts: Sequence[np.ndarray], name: str = "") -> Environment:
        """As `from_radiance`, of a map that is the sum of others.

        Args:
            radiance: (H, 2H, 3) linear, no more than 1024 rows.
            parts: those maps as they are, some of them coarser: the networks' light is the sum of each one's, and
                not that of a coarse map drawn finer, and no lamp is smaller than the texels that it comes from.
        """
        whole = cls.from_radiance(radiance, name)
        scale = 1.0 / whole.level if whole.level > 0.0 else 0.0
        seen = tuple(scale * _column_sums(part, NETWORK_HEIGHT) for part in parts)
        whole.of_shape(("column sums", NETWORK_HEIGHT), lambda _: seen)
        coarser = tuple(np.float32(scale) * part for part in parts if part.shape[0] < whole.height)
        whole.of_shape("coarser parts", lambda _: coarser)
        return whole

    @property
    def coarser_parts(self) -> tuple[np.ndarray, ...]:
        """(h, 2h, 3) maps of fewer rows than the shape that were drawn finer to be a part of it, in its units."""
        return self.of_shape("coarser parts", lambda _: ())

    @property
    def height(self) -> int:
        """Rows of the map."""
        return self.shape.shape[0]

    def at_level(self, level: float) -> Environment:
        """The same light at another level; what is found of its shape is shared."""
        other = replace(self, level=level)
        object.__setattr__(other, "_found", self._found)
        return other

    def of_shape(self, name: Hashable, find: Callable[[np.ndarray], _T]) -> _T:
        """What `find` makes of the shape, found once for all levels of it.

        Args:
            name: of what is found.
        """
        if name not in self._found:
            self._found[name] = find(self.shape)
        return self._found[name]

    @property
    def fingerprint(self) -> str:
        """Names shape and level by their contents, for keeping results under."""
        return f"{self.of_shape('digest', _digest)} at {self.level!r}"


def _digest(shape: np.ndarray) -> str:
    digest = blake2b(repr(shape.shape).encode(), digest_size=16)
    digest.update(np.ascontiguousarray(shape))
    return digest.hexdigest()


def read_environment(path: str | Path) -> Environment:
    """Read a lat-long panorama from an .hdr or .exr file, shrunk by area to at most 1024 rows.

    Raises:
        InputError: the file can't be read, or isn't a 2:1 panorama.
    """
    from relight_core.imaging.read import read_radiance

    path = Path(path)
    return Environment.from_radiance(read_radiance(path), path.name)


def rotate(radiance: np.ndarray, yaw_deg: float) -> np.ndarray:
    """Turn a panorama about +y; positive moves its content to the right.

    A turn by part of a texel is the linear mix of the two whole-texel turns beside it: it keeps every
    row's sum, and changes evenly with the angle. 360 degrees is the identity, bit for bit.

    Args:
        radiance: (H, W, C) or (H, W).
        yaw_deg: any finite angle in degrees.

    Returns:
        A new array of the same shape and type.

    Raises:
        ValueError: the angle is NaN or infinite.
    """
    width = radiance.shape[1]
    shift = _turn_fraction(yaw_deg) * width
    whole = math.floor(shift)
    part = shift - whole
    turned = np.roll(radiance, whole, axis=1)
    if part == 0.0:
        return turned
    further = np.roll(turned, 1, axis=1)
    mixed = turned * np.float64(1.0 - part) + further * np.float64(part)
    return mixed.astype(radiance.dtype)


def shrink(radiance: np.ndarray, height: int) -> np.ndarray:
    """Average a panorama over the texels of a smaller one, by exact solid angle.

    Fractional overlaps count exactly (a band between two latitudes by its difference of cosines), so
    the energy, the sum of radiance times solid angle, is kept for any ratio. A larger height works
    too and repeats texels.

    Args:
        radiance: (H, W, C) linear.
        height: rows of the result, at least 1.

    Returns:
        (height, 2 * height, C) float32.
    """
    whole = radiance.shape[1] // (2 * height)
    if whole * 2 * height == radiance.shape[1]:
        return _shrink_rows(radiance, height, whole).astype(np.float32)
    rows = _shrink_rows(radiance, height)
    overlaps = _column_overlaps(rows.shape[1], 2 * height)
    return np.einsum("ij,hjc->hic", overlaps, rows, optimize=True).astype(np.float32)


def network_light(environment: Environment, yaw_deg: float = 0.0, height: int = NETWORK_HEIGHT) -> np.ndarray:
    """The light as the networks read it: turned at its own resolution, then averaged to few texels.

    A texel narrower than the new ones is first spread to their width along its row, and to their height, so that a
    small lamp passes from one new texel to the next evenly over the whole turn, or rise, from one to the other, where
    averages alone would hold it still and then let it jump. The mean direction of a row's light is kept, and a map
    of the result's own resolution is not spread. The rows are averaged and spread once per shape;
    each angle then costs only the sums between its new texel edges.

    Returns:
        (height, 2 * height, 3) float32, mean luminance over the sphere 1.

    Raises:
        ValueError: the angle is NaN or infinite.
    """
    turn = _turn_fraction(yaw_deg)
    parts = environment.of_shape(("column sums", height), lambda shape: (_column_sums(shape, height),))
    edges, means = np.arange(2 * height + 1) / (2 * height) - turn, 0.0
    for sums in parts:
        width = sums.shape[1] - 1
        means = means + np.diff(_sum_up_to(sums, edges * width), axis=1) * (2 * height / width)
    return np.maximum(means, 0.0).astype(np.float32)


def mean_luminance(radiance: np.ndarray) -> float:
    """Mean Rec.709 luminance of an (H, W, 3) panorama over the sphere."""
    return float(_row_shares(radiance) @ (radiance.mean(axis=1, dtype=np.float64) @ REC709_LUMINANCE))


def mean_radiance(radiance: np.ndarray) -> np.ndarray:
    """Mean colour (3,) of an (H, W, 3) panorama over the sphere, float64."""
    return _row_shares(radiance) @ radiance.mean(axis=1, dtype=np.float64)


def _row_shares(radiance: np.ndarray) -> np.ndarray:
    """How much of the sphere every row of a panorama is; sums to 1."""
    height = radiance.shape[0]
    return -np.diff(np.cos(np.pi * np.arange(height + 1) / height)) / 2


def _as_panorama(radiance: np.ndarray, name: str) -> np.ndarray:
    """(H, 2H, 3) float32 view or copy of a grey or colour panorama."""
    label = name or "the light"
    if radiance.ndim == 2:
        radiance = radiance[..., None]
    if radiance.ndim != 3 or radiance.shape[2] not in (1, 3) or radiance.dtype.kind not in "fiub":
        raise InputError(f"{label}: a light is an image with 1 or 3 channels, this is {radiance.shape}")
    height, width, channels = radiance.shape
    if height == 0 or width != 2 * height:
        raise InputError(
            f"{label}: a light is a lat-long panorama twice as wide as high, this is {width} x {height}; "
            "choose a full 360 x 180 degree map, or crop or resize it to 2:1"
        )
    with np.errstate(over="ignore"):
        radiance = radiance.astype(np.float32, copy=False)
    return np.repeat(radiance, 3, axis=2) if channels == 1 else radiance


def _clean(radiance: np.ndarray, name: str) -> np.ndarray:
    """Replace values that no light can have; returns its argument where there are none."""
    if radiance.min() >= 0 and radiance.max() < np.inf:
        return radiance
    label = name or "the light"
    finite = np.isfinite(radiance)
    if not finite.any():
        raise InputError(f"{label}: no finite value in the map; export it again or choose another light")
    brightest = max(float(radiance.max(initial=0.0, where=finite)), 0.0)
    not_a_number = int(np.isnan(radiance).sum())
    negative = int((radiance < 0).sum())
    infinite = int(np.isposinf(radiance).sum())
    warnings.warn(
        f"{label}: {not_a_number} NaN and {negative} negative values set to 0, "
        f"{infinite} infinite ones to {brightest:g}",
        stacklevel=3,
    )
    cleaned = np.nan_to_num(radiance, nan=0.0, posinf=brightest, neginf=0.0)
    return np.maximum(cleaned, 0.0, out=cleaned)


def _turn_fraction(yaw_deg: float) -> float:
    """The angle as a fraction of a turn in [0, 1)."""
    if not math.isfinite(yaw_deg):
        raise ValueError(f"yaw_deg must be a finite angle in degrees, not {yaw_deg}")
    return (float(yaw_deg) % 360.0) / 360.0 % 1.0


def _overlap_weights(edges: np.ndarray, new_edges: np.ndarray) -> np.ndarray:
    """How much of every new interval each old one covers; edges ascend and share their ends.

    Returns:
        (new, old) float64, rows sum to 1.
    """
    low = np.maximum(edges[None, :-1], new_edges[:-1, None])
    high = np.minimum(edges[None, 1:], new_edges[1:, None])
    overlaps = np.maximum(high - low, 0.0)
    return overlaps / overlaps.sum(axis=1, keepdims=True)


@lru_cache(maxsize=16)
def _row_overlaps(height: int, new_height: int) -> np.ndarray:
    def edges(count: int) -> np.ndarray:
        return -np.cos(np.pi * np.arange(count + 1) / count)

    return _overlap_weights(edges(height), edges(new_height))


@lru_cache(maxsize=16)
def _column_overlaps(width: int, new_width: int) -> np.ndarray:
    return _overlap_weights(np.arange(width + 1) / width, np.arange(new_width + 1) / new_width)


def _shrink_rows(radiance: np.ndarray, height: int, columns: int = 1) -> np.ndarray:
    """(H, W, C) to (height, W / columns, C) float64; a few rows at a time, since a map may fill gigabytes.

    Args:
        columns: how many are averaged into one; divides W.
    """
    return _block_sums(radiance, _row_overlaps(radiance.shape[0], height), columns)


def _block_sums(radiance: np.ndarray, overlaps: np.ndarray, columns: int = 1) -> np.ndarray:
    """Rows (H, W, C) weighted by `overlaps` (height, H), a few at a time."""
    (height, old_height), (_, width, channels) = overlaps.shape, radiance.shape
    width //= columns
    result = np.zeros((height, width * channels))
    for start in range(0, old_height, _BLOCK_ROWS):
        block = slice(start, min(start + _BLOCK_ROWS, old_height))
        touched = np.flatnonzero(overlaps[:, block].any(axis=1))
        rows = radiance[block].reshape(-1, width, columns, channels).mean(axis=2, dtype=np.float64)
        result[touched] += overlaps[touched, block] @ rows.reshape(-1, width * channels)
    return result.reshape(height, width, channels)


def _column_sums(radiance: np.ndarray, height: int) -> np.ndarray:
    """(H, W, C) to (height, W + 1, C) float64: running sums of what `network_light` averages."""
    return _running_sums(_spread(_evenly_shrunk_rows(radiance, height), 2 * height))


def _evenly_shrunk_rows(radiance: np.ndarray, height: int) -> np.ndarray:
    """(H, W, C) to (height, W, C) float64, every row spread to the height of a new one where that is higher."""
    if radiance.shape[0] <= height:
        return _shrink_rows(radiance, height)
    return _block_sums(radiance, _spread_row_overlaps(radiance.shape[0], height))


@lru_cache(maxsize=16)
def _spread_row_overlaps(height: int, new_height: int) -> np.ndarray:
    """As `_row_overlaps`, of rows spread to the height of a new one and folded back at the poles.

    Weights are balanced until even light stays even and no row loses energy (Sinkhorn and Knopp, 1967).
    """
    edges, half = np.linspace(0.0, np.pi, new_height + 1), np.pi / new_height / 2
    middles = (np.arange(height) + 0.5) * np.pi / height
    centres = np.concatenate([middles, -middles, 2 * np.pi - middles])
    overlaps = np.minimum(centres + half, edges[1:, None]) - np.maximum(centres - half, edges[:-1, None])
    energy = np.maximum(overlaps, 0.0).reshape(new_height, 3, height).sum(1)
    given, wanted = (-np.diff(np.cos(np.linspace(0.0, np.pi, count + 1))) for count in (height, new_height))
    for _ in range(_BALANCINGS):
        energy *= (wanted / energy.sum(1))[:, None]
        energy *= given / energy.sum(0)
    return energy / energy.sum(1, keepdims=True)


def _spread(rows: np.ndarray, new_width: int) -> np.ndarray:
    """Every texel of (H, W, C) spread along its row to the width of one of `new_width`, where that is wider."""
    span = rows.shape[1] / new_width
    if span <= 1:
        return rows
    sums, centres = _running_sums(rows), np.arange(rows.shape[1]) + 0.5
    return (_sum_up_to(sums, centres + span / 2) - _sum_up_to(sums, centres - span / 2)) / span


def _running_sums(rows: np.ndarray) -> np.ndarray:
    """(H, W + 1, C) sums of the columns to the left of each texel edge."""
    return np.concatenate([np.zeros_like(rows[:, :1]), np.cumsum(rows, axis=1)], axis=1)


def _sum_up_to(sums: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Integral over columns from 0 to each position, of a function constant in texels and periodic.

    Args:
        sums: (H, W + 1, C) running sums, starting with 0.
        positions: (N,) in texels, any sign.

    Returns:
        (H, N, C).
    """
    width = sums.shape[1] - 1
    turns = np.floor(positions / width)
    within = np.clip(positions - turns * width, 0.0, width)
    left = np.minimum(within.astype(np.intp), width - 1)
    part = (within - left)[None, :, None]
    inside = sums[:, left] * (1.0 - part) + sums[:, left + 1] * part
    return inside + turns[None, :, None] * sums[:, -1:]
