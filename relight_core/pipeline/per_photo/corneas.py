"""The corneas in a photo, and the catchlights in them.

A catchlight is the reflection of a lamp in the eye. It is the one highlight that networks with pixels of 3 mm can't
move, and a relit face whose eyes still show the studio gives itself away. So the photo's own catchlights are found in
the irises, to be replaced by those of the new light (`per_light.catchlights`).

Lengths are in radii of the iris unless stated otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.irises import Iris
from relight_core.imaging.colour import luminance, srgb_encode
from relight_core.imaging.masks import disc
from relight_core.imaging.ramp import ramp
from relight_core.lighting.sphere import place_on_map

_LARGEST_PX = 384
"""Largest side of an eye's square. Smaller eyes have the photo's own pixels, or the rim of the hole that a catchlight
leaves would show."""
_FEWEST_NORMALS, _MOST_NORMALS = 96, 128
"""Normals across that square: more than pixels in a small eye, where a pixel mirrors more than a lamp."""
_REACH = 1.25
"""Half the side of an eye's square."""
_SPECK = 0.3
"""Half the width of the widest catchlight that can be distinguished from the iris."""
_FILL_ACROSS, _FILL_DOWN = 0.32, 0.14
"""Standard deviations, across and down, of the blur that fills a catchlight's place with the iris's own colour. Pixels
on the same level lie as deep in the shadow of the upper lid; those further down may be far paler."""
_HALO, _HALO_BLUR, _UNTOUCHED = 0.12, 0.05, 0.02
"""A catchlight is dilated and blurred by this much; pixels with a lower share of it count as untouched."""
_BRIGHTER, _BRIGHTER_BY, _BRIGHT = (1.5, 2.5), 0.02, (0.3, 0.6)
"""Ramps over which a pixel becomes a catchlight: its brightness over that of the ground, each plus the second number;
and its brightness over that of the pixels around the iris."""
_AROUND_PERCENTILES, _GLARING = (75, 95), (1.5, 2.0)
"""Percentiles of the pixels around the iris that stand for all of them and for the white of the eye; and the ramp of
brightness, as a multiple of the latter, over which something can only be a lamp."""
_PALE_PERCENTILE, _PALEST = 80, 0.7
"""Percentile of the iris's pixels that stands for its pale parts, beside the pupil; and its largest plausible value, as
a share of the brightness around."""
_RIM, _INNER = 0.93, 0.6
"""Where the iris's rim begins, and where its middle ends."""
_MOST, _MOST_UNTOLD = 0.25, 0.1
"""Largest shares of the iris's middle that may be bright, and that may be bright without being distinguished from lid
and white of the eye. Studio lamps take up to a fifth; if more is bright, what it hides isn't known."""
_LID, _BETWEEN_LIDS = (0.35, 0.65), 0.4
"""Ramp of brightness, from that of the iris (0) to that around it (1), over which a pixel becomes lid; and how far
above and below the centre there are few lids."""
_REFLECTANCE = 0.025
"""Of tears, with a refractive index of 1.376, at normal incidence."""
_CURVATURE = 1.33
"""The cornea's radius of curvature, 7.8 mm; the visible iris has a radius of 5.9 mm."""


@dataclass(frozen=True, eq=False)
class Cornea:
    """The front of an eye, in a square of E pixels.

    Attributes:
        iris: in the middle of the square.
        view: the square in the photo, with edges on whole pixels.
        bare: (E, E) in [0, 1], the share of each pixel that is iris and not covered by a lid.
        mirrored: (E, E, 3) float32 radiance of the photo's own catchlights, linear, in the photo's units.
        normal: (3, N, N) unit vectors, camera space; N is more than E in a small eye and less in a large one.
    """

    iris: Iris
    view: Crop
    bare: np.ndarray
    mirrored: np.ndarray
    normal: np.ndarray

    @cached_property
    def mirrored_places(self) -> tuple[np.ndarray, np.ndarray]:
        """Where each normal's mirrored direction lies on a panorama, as shares of its width and height, (N, N) each."""
        x, y, z = self.normal
        # Seen from a distant camera at +z the mirrored direction is 2 (n . v) n - v.
        return tuple(place.astype(np.float32) for place in place_on_map(2 * z * x, 2 * z * y, 2 * z * z - 1))

    @cached_property
    def reflectance(self) -> np.ndarray:
        """The share of light that is mirrored, (N, N) float32 (Schlick 1994)."""
        return _REFLECTANCE + (1 - _REFLECTANCE) * (1 - self.normal[2]) ** 5


def find_cornea(linear: np.ndarray, exposure: float, iris: Iris) -> Cornea | None:
    """Separate an eye from its catchlights.

    Args:
        linear: (H, W, 3) the photo.
        exposure: the gain at which it is viewed.
        iris: of the eye.

    Returns:
        None if so much of the iris is bright that what lies below can't be known, or if it is too pale to be real, as
        in a drawing.
    """
    view = _square(iris)
    size = min(int(view.side), _LARGEST_PX)
    colour = view.extract(linear, size)
    per_px = size / view.side
    middle, radius = view.from_photo(np.array([iris.x, iris.y]), size), iris.radius * per_px
    place = np.arange(size) + 0.5
    right, down = (place[None, :] - middle[0]) / radius, (place[:, None] - middle[1]) / radius
    away = np.hypot(right, down)
    within = np.clip((1 - away) * radius + 0.5, 0, 1)
    seen = luminance(colour) * np.float32(exposure)
    around, white = np.maximum(np.percentile(seen[within < 0.5], _AROUND_PERCENTILES), 1e-3).tolist()
    pale = float(np.percentile(seen[(within > 0.5) & (np.abs(down) < _BETWEEN_LIDS)], _PALE_PERCENTILE))
    ground = cv2.morphologyEx(seen, cv2.MORPH_OPEN, disc(_SPECK * radius))
    bright = _bright(seen / around, np.maximum(ground, pale) / around)
    open_iris = _bare(ground, within, radius, down)
    on_lid = np.where(np.abs(down) > np.abs(right), 1 - open_iris, 0)
    glaring = bright * ramp(seen / white, *_GLARING).astype(np.float32)
    specks = np.maximum(_islands(bright, away), _islands(glaring, away)) * (1 - on_lid)
    of_middle, untold = bright[away < _INNER].mean(), (bright - specks)[away < _INNER].mean()
    if pale > _PALEST * around or of_middle > _MOST or untold > _MOST_UNTOLD:
        return None
    bright = np.maximum(specks, open_iris * _with_halo(specks, radius))
    own = _filled(colour, open_iris * ((away < _RIM) & (bright < _UNTOUCHED)), radius)
    mirrored = (bright * within)[..., None] * np.maximum(colour - own, 0)
    left = luminance(colour - mirrored) * np.float32(exposure)
    return Cornea(
        iris, view, _bare(left, within, radius, down), mirrored.astype(np.float32), _normal(middle, radius, size)
    )


def _square(iris: Iris) -> Crop:
    """The square around an iris, with edges on whole pixels."""
    half = int(np.ceil(_REACH * iris.radius))
    return Crop(round(iris.x), round(iris.y), 2 * half)


def _bright(seen: np.ndarray, ground: np.ndarray) -> np.ndarray:
    """The degree to which each pixel is a catchlight, a bright speck on darker ground, (E, E) in [0, 1].

    Args:
        seen, ground: (E, E) luminance of the eye, and of what surrounds each pixel, over that around the iris.
    """
    brighter = ramp((seen + _BRIGHTER_BY) / (ground + _BRIGHTER_BY), *_BRIGHTER)
    return (brighter * ramp(seen, *_BRIGHT)).astype(np.float32)


def _islands(bright: np.ndarray, away: np.ndarray) -> np.ndarray:
    """The bright parts (E, E) that lie wholly within the iris; what touches its rim is lid or white of the eye."""
    _, parts = cv2.connectedComponents(((bright > 0.1) & (away < 1)).astype(np.uint8))
    not_of_iris = np.append(parts[(away > _RIM) & (away < 1)], 0)
    return np.where(np.isin(parts, np.unique(not_of_iris)), 0, bright)


def _with_halo(bright: np.ndarray, radius: float) -> np.ndarray:
    """Bright parts (E, E) with the halo that the lens spreads around them."""
    reach = 2 * (round(_HALO * radius) + 1) + 1
    return cv2.GaussianBlur(
        cv2.dilate(bright, np.ones((reach, reach), np.uint8)), (0, 0), max(_HALO_BLUR * radius, 0.4)
    )


def _filled(colour: np.ndarray, known: np.ndarray, radius: float) -> np.ndarray:
    """The mean colour of the known pixels around each pixel, (E, E, 3); `known` is (E, E) >= 0."""
    weight = known.astype(np.float32)
    across, down = (max(reach * radius, 0.8) for reach in (_FILL_ACROSS, _FILL_DOWN))
    total = cv2.GaussianBlur(weight, (0, 0), across, sigmaY=down)[..., None]
    return cv2.GaussianBlur(colour * weight[..., None], (0, 0), across, sigmaY=down) / np.maximum(total, 1e-4)


def _bare(seen: np.ndarray, within: np.ndarray, radius: float, down: np.ndarray) -> np.ndarray:
    """The share of each pixel that is iris and not lid, which is brighter, (E, E) in [0, 1].

    Args:
        seen: (E, E) luminance without catchlights.
    """
    code = srgb_encode(cv2.GaussianBlur(seen, (0, 0), max(0.06 * radius, 0.4)))
    iris = float(np.percentile(code[(within > 0.5) & (np.abs(down) < _BETWEEN_LIDS)], _PALE_PERCENTILE))
    around = max(float(np.percentile(code[within < 0.5], 75)), iris + 0.05)
    lid = ramp((code - iris) / (around - iris), *_LID)
    return (within * (1 - lid)).astype(np.float32)


def _normal(middle: np.ndarray, radius: float, size: int) -> np.ndarray:
    """Normals (3, N, N) of a cornea centred on a place in a square of `size` pixels."""
    count = min(size * int(np.ceil(_FEWEST_NORMALS / size)), _MOST_NORMALS)
    place = (np.arange(count) + 0.5) * (size / count)
    x, y = np.meshgrid((place - middle[0]) / (_CURVATURE * radius), (middle[1] - place) / (_CURVATURE * radius))
    steep = np.minimum(1, 0.95 / np.maximum(np.hypot(x, y), 1e-6))
    x, y = x * steep, y * steep
    return np.stack([x, y, np.sqrt(1 - x * x - y * y)]).astype(np.float32)
