"""Where a face's irises are, to a pixel of the photo.

The parsing sees an eye in some ten pixels; the photo often has ten times as many. There an iris is a disc that is
darker than the white of the eye to its left and right (Daugman 1993: the circle across which the light changes
most). Lids cover its top and often its bottom, so only its sides are asked.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache, partial

import cv2
import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.eyeballs import EyePlace, eye_place
from relight_core.face.parsing import EYES, INDEX
from relight_core.imaging.colour import luminance, srgb_encode

_HALF_PX, _SIDE_PX = 40, 176
"""Half an eye's width in the square view in which an iris is looked for, and that view's side."""
_RADII_PX = np.arange(11.0, 23.5)
"""Radii of irises that are tried in that view."""
_USUAL_RADIUS, _RADIUS_DOUBT = 0.45, 0.16
"""An iris's radius in half-widths of its eye as the parsing sees that, and by how much it may be off."""
_ARC_DEG = (-25.0, 50.0)
"""The part of each side of an iris's edge that is looked at, from above its middle to below: lids cover the rest."""
_STEP_PX, _RING_PX = 2.0, 1.5
"""How far outside and inside of an iris's edge brightness is compared, and half the width of the rings there."""
_SPECK_PX = 9
"""Catchlights are smaller, and would be edges of their own: what is brighter and as small is taken out."""
_OFF_MIDDLE = (0.75, 0.25)
"""Half-widths of an eye to the side and up or down that an iris may be off its middle. Further up are lashes and brows.
"""

_BOTH_SIDES, _DARKNESS, _RADIUS_WEIGHT = 0.25, 0.5, 0.12
"""Weights in the score, beside the contrast of the edge's fainter side: of both sides' mean contrast, of how dark the
disc is, and of how unusual the radius is."""
_LEAST_SCORE = 0.5
"""The score both eyes need at the least: else there is a veil, or hair, and the other eye is doubtful too."""
_LEAST_EDGE, _LEAST_BESIDE = 0.2, 0.1
"""Contrast that the edge's fainter side needs, as a share of the brightness around: of one iris, and of the other."""
_LEAST_RADIUS_PX = 5.0
"""Pixels of the photo."""


@dataclass(frozen=True)
class Iris:
    """A disc in a photo, all in pixels of it."""

    x: float
    y: float
    radius: float


def find_irises(linear: np.ndarray, exposure: float, parsing: np.ndarray, view: Crop) -> tuple[Iris, ...]:
    """The irises of a face, as far as they are seen well enough.

    Both are as large as each other, which tells an iris from its pupil where one of them has a pale rim.

    Args:
        linear: (H, W, 3) the photo.
        exposure: of it.
        parsing: (classes, S, S) probabilities in the face's view.
        view: where that lies.

    Returns:
        none to two of them.
    """
    places = [eye_place(parsing[INDEX[name]]) for name in EYES]
    places = [place for place in places if place is not None]
    if not places:
        return ()
    scale = view.side / parsing.shape[-1]
    half_width = max(place.half_width for place in places) * scale
    if half_width * _RADII_PX[-1] / _HALF_PX < _LEAST_RADIUS_PX:
        return ()
    crops = [_around(place, view, parsing.shape[-1], half_width) for place in places]
    looks = [_Look.at(srgb_encode(luminance(crop.extract(linear, _SIDE_PX)) * np.float32(exposure))) for crop in crops]
    usual = ((_RADII_PX / _HALF_PX - _USUAL_RADIUS) / _RADIUS_DOUBT) ** 2
    best = int((sum(look.scores for look in looks) / len(looks) - _RADIUS_WEIGHT * usual).argmax())
    radius = float(_RADII_PX[best] * half_width / _HALF_PX)
    if radius < _LEAST_RADIUS_PX or min(look.scores[best] for look in looks) < _LEAST_SCORE:
        return ()
    edges = [look.edges[best] for look in looks]
    least = _LEAST_BESIDE if max(edges) >= _LEAST_EDGE else np.inf
    middles = [
        crop.to_photo(look.middles[best] + 0.5, _SIDE_PX)
        for crop, look in zip(crops, looks, strict=True)
        if look.edges[best] >= least
    ]
    return tuple(Iris(float(x), float(y), radius) for x, y in middles)


def _around(place: EyePlace, view: Crop, size: int, half_width: float) -> Crop:
    x, y = view.to_photo(np.array([place.middle_x, place.middle_y]) + 0.5, size)
    return Crop(float(x), float(y), half_width * _SIDE_PX / _HALF_PX, view.roll_deg)


@dataclass(frozen=True)
class _Look:
    """The best disc of every radius in one eye.

    Attributes:
        scores: (radii,) how much each is like an iris.
        middles: (radii, 2) x, y of pixels.
        edges: (radii,) by how much of the brightness around it is darker than what is beside it, on its fainter side.
    """

    scores: np.ndarray
    middles: np.ndarray
    edges: np.ndarray

    @classmethod
    def at(cls, seen: np.ndarray) -> _Look:
        """Look at an eye (176, 176), sRGB."""
        speck = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (_SPECK_PX, _SPECK_PX))
        seen = cv2.morphologyEx(np.clip(seen, 0, 1), cv2.MORPH_OPEN, speck)
        middle = _SIDE_PX // 2
        rows, columns = slice(middle - 25, middle + 25), slice(middle - 45, middle + 45)
        seen = seen / max(float(np.percentile(seen[rows, columns], 80)), 1e-3)
        across, down = (int(_HALF_PX * most) for most in _OFF_MIDDLE)
        right, below = np.arange(-across, across + 1), np.arange(-down, down + 1)[:, None]
        possible = np.hypot(right / _OFF_MIDDLE[0], below / _OFF_MIDDLE[1]) < _HALF_PX
        found = []
        for left, right, disc in _kernels():
            at = partial(_filtered, seen, (down, across))
            sides = at(left), at(right)
            fainter = np.minimum(*sides)
            score = fainter + _BOTH_SIDES * (sides[0] + sides[1]) / 2 + _DARKNESS * (1 - at(disc))
            row, column = np.unravel_index(np.where(possible, score, -np.inf).argmax(), score.shape)
            place = middle - across + column, middle - down + row
            found.append((score[row, column], place, fainter[row, column]))
        scores, middles, edges = zip(*found, strict=True)
        return cls(np.array(scores), np.array(middles, np.float64), np.array(edges))


def _filtered(seen: np.ndarray, most: tuple[int, int], kernel: np.ndarray) -> np.ndarray:
    """An eye through a kernel, at most so far down and across from its middle."""
    middle, half = _SIDE_PX // 2, len(kernel) // 2
    rows, columns = (slice(middle - off - half, middle + off + half + 1) for off in most)
    return cv2.filter2D(seen[rows, columns], -1, kernel)[half:-half, half:-half]


@lru_cache(maxsize=1)
def _kernels() -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """For every radius: outside less inside of its left and of its right edge, and the mean of what is within."""
    return [(*(_edge(radius, side) for side in (-1, 1)), _disc(0.8 * radius)) for radius in _RADII_PX]


def _edge(radius: float, side: int) -> np.ndarray:
    x, y = _grid(radius + 2 * _STEP_PX)
    angle, distance = np.degrees(np.arctan2(y, np.abs(x))), np.hypot(x, y)
    asked = (angle > _ARC_DEG[0]) & (angle < _ARC_DEG[1]) & (side * x > 0)
    rings = [asked * np.clip(1 - np.abs(distance - radius - step) / _RING_PX, 0, 1) for step in (_STEP_PX, -_STEP_PX)]
    outside, inside = (ring / ring.sum() for ring in rings)
    return (outside - inside).astype(np.float32)


def _disc(radius: float) -> np.ndarray:
    within = np.hypot(*_grid(radius)) <= radius
    return (within / within.sum()).astype(np.float32)


def _grid(reach: float) -> tuple[np.ndarray, np.ndarray]:
    steps = np.arange(-int(np.ceil(reach)), int(np.ceil(reach)) + 1)
    return np.meshgrid(steps, steps)
