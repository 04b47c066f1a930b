"""The wet fronts of a photo's eyes, and the photo without the lights that were mirrored in them.

A catchlight is where the eye mirrors a lamp. It is the one highlight that networks at 3 mm a pixel cannot move: a
relit face whose eyes still show the studio gives itself away. Here the photo's own are found in the irises, so that
those of the new light can take their place (`per_light.catchlights`).
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
"""Of an eye's square: those of the photo, or the hole that a catchlight leaves would show its rim."""
_FEWEST_NORMALS, _MOST_NORMALS = 96, 128
"""Across that square: lamps are smaller than what a pixel of a small eye mirrors, and not so in a large one."""
_REACH = 1.25
"""Half the square about an iris, in its radii."""
_SPECK = 0.3
"""Radii of an iris: half of the widest catchlight that is told from the iris."""
_FILL_ACROSS, _FILL_DOWN = 0.32, 0.14
"""Radii of an iris from which its own colour is taken where a catchlight was. What is level with it lies as deep in
the shadow of the upper lid; what is further down may be far paler.
"""
_HALO, _HALO_BLUR, _UNTOUCHED = 0.12, 0.05, 0.02
_BRIGHTER, _BRIGHTER_BY, _BRIGHT = (1.5, 2.5), 0.02, (0.3, 0.6)
_AROUND_PERCENTILES, _GLARING = (75, 95), (1.5, 2.0)
"""Which pixels about an iris stand for all of them, and which for the white of the eye; and how much brighter than the
latter only lamps are."""
_PALE_PERCENTILE, _PALEST = 80, 0.7
"""Which of an iris's pixels stand for its pale parts, beside its pupil; and the palest there are, of what is around."""
_RIM, _INNER = 0.93, 0.6
"""Radii of an iris: where its rim begins, and its middle ends."""
_MOST, _MOST_UNTOLD = 0.25, 0.1
"""Shares of its middle that may be bright, and that may be so without being told from lid and white of the eye.
Studio lamps take up to a fifth of it; of more it isn't known what it hides."""
_LID, _BETWEEN_LIDS = (0.35, 0.65), 0.4
"""How bright lids are, from iris to what is around; and how far up and down from its middle few lids are, in radii."""
_REFLECTANCE = 0.025
"""Of tears, refractive index 1.376, for light that comes straight on."""
_CURVATURE = 1.33
"""The cornea's radius, 7.8 mm, in those of the iris as it is seen, 5.9 mm."""


@dataclass(frozen=True, eq=False)
class Cornea:
    """The front of an eye, E pixels square.

    Attributes:
        iris: the disc in its middle.
        view: where it lies, with edges on whole pixels of the photo.
        bare: (E, E) in [0, 1] how far each pixel is iris and no lid.
        mirrored: (E, E, 3) float32, linear and in the photo's units, of the photo's own catchlights.
        normal: (3, N, N) unit vectors, camera space; more than pixels in a small eye, fewer in a large one.
    """

    iris: Iris
    view: Crop
    bare: np.ndarray
    mirrored: np.ndarray
    normal: np.ndarray

    @cached_property
    def mirrored_places(self) -> tuple[np.ndarray, np.ndarray]:
        """(N, N) each, float32: what of a light is mirrored, as shares of a panorama's width and height."""
        x, y, z = self.normal
        # Seen from a distant camera at +z the mirrored direction is 2 (n . v) n - v.
        return tuple(place.astype(np.float32) for place in place_on_map(2 * z * x, 2 * z * y, 2 * z * z - 1))

    @cached_property
    def reflectance(self) -> np.ndarray:
        """(N, N) float32, the share of light that is mirrored (Schlick 1994)."""
        return _REFLECTANCE + (1 - _REFLECTANCE) * (1 - self.normal[2]) ** 5


def find_cornea(linear: np.ndarray, exposure: float, iris: Iris) -> Cornea | None:
    """Take an eye apart; None where so much of the iris is bright that what it hides can't be told, or it is drawn.

    Args:
        linear: (H, W, 3) the photo.
        exposure: of it.
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
    half = int(np.ceil(_REACH * iris.radius))
    return Crop(round(iris.x), round(iris.y), 2 * half)


def _bright(seen: np.ndarray, ground: np.ndarray) -> np.ndarray:
    """(E, E) in [0, 1] how far each pixel of an eye's luminance is a catchlight: a bright speck on darker ground."""
    brighter = ramp((seen + _BRIGHTER_BY) / (ground + _BRIGHTER_BY), *_BRIGHTER)
    return (brighter * ramp(seen, *_BRIGHT)).astype(np.float32)


def _islands(bright: np.ndarray, away: np.ndarray) -> np.ndarray:
    """Those bright parts that lie in the iris altogether: what reaches its rim is lid or white of the eye."""
    _, parts = cv2.connectedComponents(((bright > 0.1) & (away < 1)).astype(np.uint8))
    not_of_iris = np.append(parts[(away > _RIM) & (away < 1)], 0)
    return np.where(np.isin(parts, np.unique(not_of_iris)), 0, bright)


def _with_halo(bright: np.ndarray, radius: float) -> np.ndarray:
    """Bright parts with what the lens has spread of them."""
    reach = 2 * (round(_HALO * radius) + 1) + 1
    return cv2.GaussianBlur(
        cv2.dilate(bright, np.ones((reach, reach), np.uint8)), (0, 0), max(_HALO_BLUR * radius, 0.4)
    )


def _filled(colour: np.ndarray, known: np.ndarray, radius: float) -> np.ndarray:
    """(E, E, 3) each pixel's surroundings as far as they are known."""
    weight = known.astype(np.float32)
    across, down = (max(reach * radius, 0.8) for reach in (_FILL_ACROSS, _FILL_DOWN))
    total = cv2.GaussianBlur(weight, (0, 0), across, sigmaY=down)[..., None]
    return cv2.GaussianBlur(colour * weight[..., None], (0, 0), across, sigmaY=down) / np.maximum(total, 1e-4)


def _bare(seen: np.ndarray, within: np.ndarray, radius: float, down: np.ndarray) -> np.ndarray:
    """(E, E) how far each pixel, without its catchlights, is iris: lids are brighter."""
    code = srgb_encode(cv2.GaussianBlur(seen, (0, 0), max(0.06 * radius, 0.4)))
    iris = float(np.percentile(code[(within > 0.5) & (np.abs(down) < _BETWEEN_LIDS)], _PALE_PERCENTILE))
    around = max(float(np.percentile(code[within < 0.5], 75)), iris + 0.05)
    lid = ramp((code - iris) / (around - iris), *_LID)
    return (within * (1 - lid)).astype(np.float32)


def _normal(middle: np.ndarray, radius: float, size: int) -> np.ndarray:
    """Of a ball about a place in a square of so many pixels."""
    count = min(size * int(np.ceil(_FEWEST_NORMALS / size)), _MOST_NORMALS)
    place = (np.arange(count) + 0.5) * (size / count)
    x, y = np.meshgrid((place - middle[0]) / (_CURVATURE * radius), (middle[1] - place) / (_CURVATURE * radius))
    steep = np.minimum(1, 0.95 / np.maximum(np.hypot(x, y), 1e-6))
    x, y = x * steep, y * steep
    return np.stack([x, y, np.sqrt(1 - x * x - y * y)]).astype(np.float32)
