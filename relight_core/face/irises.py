"""Where a face's irises are, to a pixel of the photo.

The parsing has some ten pixels of an eye, the photo often ten times as many. In it an iris is a disc that is darker
than the white of the eye on its left and right (Daugman 1993: the circle across which brightness changes most). Lids
cover its top and often its bottom, so only the sides of its edge are used.
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
"""Half an eye's width in the square view in which its iris is searched for, and that view's side."""
_RADII_PX = np.arange(11.0, 23.5)
"""Radii of irises that are tried in that view."""
_USUAL_RADIUS, _RADIUS_DOUBT = 0.45, 0.16
"""Typical radius of an iris in half-widths of its eye in the parsing, and its spread."""
_ARC_DEG = (-25.0, 50.0)
"""The arc on each side of an iris's edge that is used, from above its centre to below; lids cover the rest."""
_STEP_PX, _RING_PX = 2.0, 1.5
"""Brightness is compared so far outside and inside of an iris's edge, in rings of twice the second width."""
_SPECK_PX = 9
"""Bright spots up to this size are removed first: catchlights, which would have edges of their own."""
_OFF_MIDDLE = (0.75, 0.25)
"""How far an iris may be from the centre of its eye, sideways and up or down, in the eye's half-widths. Further up are
lashes and brows."""

_BOTH_SIDES, _DARKNESS, _RADIUS_WEIGHT = 0.25, 0.5, 0.12
"""Weights in the score, relative to the contrast of the edge's fainter side: of the mean contrast of both sides, of how
dark the disc is, and of how unusual the radius is."""
_LEAST_SCORE = 0.5
"""Score that both eyes need. Otherwise there is a veil or hair over one of them, and the other is doubtful too."""
_LEAST_EDGE, _LEAST_BESIDE = 0.2, 0.1
"""Contrast of the edge's fainter side, as a share of the brightness around, that one iris needs, and then the other."""
_LEAST_RADIUS_PX = 5.0
"""In pixels of the photo."""


@dataclass(frozen=True)
class Iris:
    """An iris as a disc: centre and radius in pixels of the photo."""

    x: float
    y: float
    radius: float


def find_irises(linear: np.ndarray, exposure: float, parsing: np.ndarray, view: Crop) -> tuple[Iris, ...]:
    """The irises of a face that are seen clearly enough, 0 to 2.

    Both have the same radius. That distinguishes an iris from its pupil if one of them has a pale rim.

    Args:
        linear: (H, W, 3) the photo.
        exposure: the gain at which it is viewed.
        parsing: (classes, S, S) probabilities in the face's view.
        view: where that lies in the photo.
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
    """The square view around an eye, whose half-width, in photo pixels, takes `_HALF_PX` of it."""
    x, y = view.to_photo(np.array([place.middle_x, place.middle_y]) + 0.5, size)
    return Crop(float(x), float(y), half_width * _SIDE_PX / _HALF_PX, view.roll_deg)


@dataclass(frozen=True)
class _Look:
    """The best disc of every radius in one eye.

    Attributes:
        scores: (radii,) the similarity of each to an iris.
        middles: (radii, 2) column and row of its centre, in the eye's view.
        edges: (radii,) contrast across the fainter side of its edge, as a share of the brightness around the eye.
    """

    scores: np.ndarray
    middles: np.ndarray
    edges: np.ndarray

    @classmethod
    def at(cls, seen: np.ndarray) -> _Look:
        """Search the view of an eye, (176, 176) sRGB."""
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
    """The view of an eye, filtered, at places up to `most` pixels down and across from its centre."""
    middle, half = _SIDE_PX // 2, len(kernel) // 2
    rows, columns = (slice(middle - off - half, middle + off + half + 1) for off in most)
    return cv2.filter2D(seen[rows, columns], -1, kernel)[half:-half, half:-half]


@lru_cache(maxsize=1)
def _kernels() -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Three kernels for every radius: brightness outside minus inside of its left and its right edge; mean inside."""
    return [(*(_edge(radius, side) for side in (-1, 1)), _disc(0.8 * radius)) for radius in _RADII_PX]


def _edge(radius: float, side: int) -> np.ndarray:
    """The mean of a ring just outside minus that of one just inside a circle's arc, left (-1) or right (1)."""
    x, y = _grid(radius + 2 * _STEP_PX)
    angle, distance = np.degrees(np.arctan2(y, np.abs(x))), np.hypot(x, y)
    on_arc = (angle > _ARC_DEG[0]) & (angle < _ARC_DEG[1]) & (side * x > 0)
    rings = [on_arc * np.clip(1 - np.abs(distance - radius - step) / _RING_PX, 0, 1) for step in (_STEP_PX, -_STEP_PX)]
    outside, inside = (ring / ring.sum() for ring in rings)
    return (outside - inside).astype(np.float32)


def _disc(radius: float) -> np.ndarray:
    within = np.hypot(*_grid(radius)) <= radius
    return (within / within.sum()).astype(np.float32)


def _grid(reach: float) -> tuple[np.ndarray, np.ndarray]:
    steps = np.arange(-int(np.ceil(reach)), int(np.ceil(reach)) + 1)
    return np.meshgrid(steps, steps)
