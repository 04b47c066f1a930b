"""A light as a lat-long panorama: its shape and level, and what of it the networks read.

Rows run from +y (row 0) to -y; the centre column looks along -z and the right of the map is +x.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field, replace
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from relight_core.errors import InputError
from relight_core.lighting.panorama import column_sums, mean_luminance, shrink, turned_means

if TYPE_CHECKING:
    from relight_core.lighting.rig_render import Drawn

WORKING_HEIGHT = 1024
"""Rows a map keeps at most: enough for a background, small enough to turn while the user drags."""

NETWORK_HEIGHT = 16
"""Rows of the light that the networks read (paper, sec. 3.2: 16 x 32)."""

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
        seen = tuple(scale * column_sums(part, NETWORK_HEIGHT) for part in parts)
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
    parts = environment.of_shape(("column sums", height), lambda shape: (column_sums(shape, height),))
    return np.maximum(sum(turned_means(sums, yaw_deg) for sums in parts), 0.0).astype(np.float32)


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
