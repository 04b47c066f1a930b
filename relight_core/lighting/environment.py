"""A light as a lat-long panorama, split into shape and level, and the coarse version of it that the networks read.

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
"""Rows a map keeps at most: enough for a background, few enough to rotate while the user drags."""

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
        level: that mean in the map's own units, >= 0; shape * level is the map.
        name: for messages and the window.
        drawn: the rig that it was rendered from, in which `own_lamps` finds its lamps; None for any other light.
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
        """As `from_radiance`, for a map that is the sum of others.

        Args:
            radiance: (H, 2H, 3) linear, no more than 1024 rows.
            parts: the maps before they were brought to one size, some of them coarser. The networks' light is
                averaged from these, so that it doesn't depend on the upsampling, and no lamp is measured as smaller
                than the texels that it comes from.
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
        """(h, 2h, 3) parts of the sum that had fewer rows before they were upsampled, in units of the shape."""
        return self.of_shape("coarser parts", lambda _: ())

    @property
    def height(self) -> int:
        """Rows of the map."""
        return self.shape.shape[0]

    def at_level(self, level: float) -> Environment:
        """The same light at another level; both share what has been computed from the shape."""
        other = replace(self, level=level)
        object.__setattr__(other, "_found", self._found)
        return other

    def of_shape(self, name: Hashable, find: Callable[[np.ndarray], _T]) -> _T:
        """`find(shape)`, computed once and cached for this light at all levels.

        Args:
            name: the cache's key for it.
            find: a function of the shape.
        """
        if name not in self._found:
            self._found[name] = find(self.shape)
        return self._found[name]

    @property
    def fingerprint(self) -> str:
        """Identifies shape and level by their contents: a cache key."""
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
    """The light as the networks read it: rotated at its own resolution, then averaged over few large texels.

    Averaging alone would let a small lamp stand still while it crosses a large texel, and then jump to the next. So
    a texel that is narrower or lower than the large ones is first spread to their width along its row and to their
    height: the lamp then passes evenly from one to the next, while it rotates or rises. This keeps the mean
    direction of each row's light. A map that has the result's resolution is not spread. Averaging over rows and
    spreading are done once per shape; each angle then only costs the sums between the edges of the large texels.

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
    """Replace values that no light can have; without any, returns its argument."""
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
