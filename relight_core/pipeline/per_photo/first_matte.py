"""The first matte of a photo, from networks' probabilities and colours; its edges are still coarse."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.paste import fade, window_of
from relight_core.imaging.closed_form import closed_form_matte
from relight_core.imaging.photo_frame import Inside, going_on
from relight_core.imaging.resampling import resize_area, resize_smooth, shrunk_size
from relight_core.pipeline.per_photo.likely_person import (
    Look,
    attached,
    likely_person,
    near_views,
    place_faces,
    place_masks,
    without_holes,
    without_lookalikes,
)
from relight_core.pipeline.per_photo.strands import Hair

_MATTING_PX = 224
"""Longer side of the copy in which closed-form matting is done."""
_NEAR_FROM, _LEAST_NEAR_PX = 1.25, 32
"""A window around a person is matted again at a higher resolution if the scale grows by at least this factor and the
window has at least so many pixels."""
_EDGE_SHARE = 0.15
"""Share of such a window's side over which it fades toward its edge."""
_EVEN_PX, _EVEN = 5, 0.15
"""Side of the window in which a matte's standard deviation tells whether it is even, and the deviation at which it is
hardly even any more."""
_STEEP = 3.0
"""Slope, around one half, of the curve that decides an even matte."""


@dataclass(frozen=True, eq=False)
class SeenPeople:
    """The networks' looks at the people in a photo.

    Attributes:
        people: looks at each person, hair and clothes included, from the nearest to the widest (see `place_masks`).
        faces: a look at each face, with the probability of face instead of person.
        others: looks at each of those who are not to be relit, as at the people.
        hair: of each head, as far as known.
    """

    people: Sequence[list[Look]]
    faces: Sequence[Look] = ()
    others: Sequence[list[Look]] = ()
    hair: Sequence[Hair] = ()

    def moved(self, x: float, y: float) -> SeenPeople:
        """The looks shifted by pixels of the photo, without the hair."""

        def move(looks: Iterable[Look]) -> list[Look]:
            return [(mask, view.moved(x, y)) for mask, view in looks]

        people, others = ([move(looks) for looks in of_each] for of_each in (self.people, self.others))
        return SeenPeople(people, move(self.faces), others)


def first_matte(guide: np.ndarray, seen: SeenPeople, photo_size: tuple[float, float]) -> np.ndarray:
    """The matte (h, w) of a picture (h, w, 3), sRGB, from networks and colours; see `matte.draft_matte`."""
    size = shrunk_size(guide.shape[:2], _MATTING_PX)
    placed = place_masks(seen.people, size, photo_size, seen.others)
    face, near = place_faces(seen.faces, size, photo_size), near_views(seen.people, size, photo_size)
    coarse = _matted(guide, placed, face, near, size)
    return _seen_nearer(coarse, guide, seen, photo_size)


def first_matte_within(cells: Inside, guide: np.ndarray, seen: SeenPeople, photo_size: tuple[int, int]) -> np.ndarray:
    """`first_matte` of only the part of a picture within some cells; its edge values are continued outside."""
    (rows, columns), (height, width) = cells, guide.shape[:2]
    down, across = photo_size[0] / height, photo_size[1] / width
    part, within = np.ascontiguousarray(guide[cells]), seen.moved(-columns.start * across, -rows.start * down)
    share = first_matte(part, within, (part.shape[0] * down, part.shape[1] * across))
    return going_on(share, cells, (height, width))


def _matted(
    guide: np.ndarray, placed: list[np.ndarray], face: np.ndarray, near: np.ndarray, size: tuple[int, int]
) -> np.ndarray:
    """The matte (h, w) of a picture (h, w, 3), sRGB, computed in a copy of `size`.

    Args:
        placed, face, near: masks of that size, as of `likely_person`.
    """
    seen = np.clip(resize_area(guide, size), 0, 1)
    likely = likely_person(seen, placed, face, near)
    soft = attached(closed_form_matte(seen, likely), placed)
    # Attached again: deciding an even grey may cut off what it had connected to a person.
    whole = without_holes(soft, placed, likely)
    decided = without_lookalikes(_decided(whole), seen, whole)
    return resize_smooth(attached(decided, placed), guide.shape[:2])


def _seen_nearer(
    coarse: np.ndarray, guide: np.ndarray, seen: SeenPeople, photo_size: tuple[float, float]
) -> np.ndarray:
    """A matte (h, w) that is computed again at a higher resolution where people are small in the photo.

    In the copy of the whole photo an ear or a strand of a small person is less than a pixel, and mixes with what is
    beside it. Where several windows overlap, the smallest counts, in whatever order the people come.
    """
    windows = [window for looks in seen.people if (window := _near_window(looks[0][1], photo_size, guide.shape[:2]))]
    if not windows:
        return coarse
    placed = place_masks(seen.people, guide.shape[:2], photo_size, seen.others)
    face = place_faces(seen.faces, guide.shape[:2], photo_size)
    for window in sorted(windows, key=_widest_first):
        size = shrunk_size(coarse[window].shape, _MATTING_PX)
        *masks, face_mask = (resize_area(mask[window], size) for mask in (*placed, face))
        nearer = _matted(guide[window], masks, face_mask, np.ones(size, np.float32), size)
        coarse[window] += _weight(window, coarse.shape) * (nearer - coarse[window])
    return coarse


def _near_window(crop: Crop, photo_size: tuple[int, int], size: tuple[int, int]) -> tuple[slice, slice] | None:
    """`window_of` a crop; None if its resolution would hardly be higher than that of the whole copy."""
    rows, columns = window = window_of(crop, photo_size, size)
    sides = rows.stop - rows.start, columns.stop - columns.start
    if min(sides) < _LEAST_NEAR_PX:
        return None
    finer = max(max(size), _MATTING_PX) / max(max(sides), _MATTING_PX)
    return window if finer >= _NEAR_FROM else None


def _widest_first(window: tuple[slice, slice]) -> tuple[int, ...]:
    """A key that sorts windows by their longer side, the largest first, then by the other side and their place."""
    rows, columns = window
    height, width = rows.stop - rows.start, columns.stop - columns.start
    return -max(height, width), -min(height, width), rows.start, columns.start


def _weight(window: tuple[slice, slice], size: tuple[int, int]) -> np.ndarray:
    """The weight of a window at each of its pixels, (h, w); it fades toward its sides but not toward the picture's."""
    down, across = (_fading(part, length) for part, length in zip(window, size, strict=True))
    return down[:, None] * across[None]


def _fading(part: slice, length: int) -> np.ndarray:
    """`fade` along a part of an axis of `length`."""
    count = part.stop - part.start
    return fade((np.arange(count) + 0.5) / count, _EDGE_SHARE, part.start / count, (length - part.stop) / count)


def _decided(matte: np.ndarray) -> np.ndarray:
    """The matte, decided toward 0 or 1 in areas where it is an even grey.

    Strands of hair and blurred edges vary from pixel to pixel. An even grey is a trunk or a wall in the colours of the
    person in front of it, and would be partly relit.
    """
    window = (_EVEN_PX, _EVEN_PX)
    mean = cv2.blur(matte, window)
    deviation = np.sqrt(np.maximum(cv2.blur(matte * matte, window) - mean**2, 0.0))
    even = np.exp(-((deviation / _EVEN) ** 2))
    return matte + even * (np.clip(_STEEP * (matte - 0.5) + 0.5, 0.0, 1.0) - matte)
