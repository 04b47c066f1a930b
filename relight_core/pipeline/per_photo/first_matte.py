"""Where in a photo people are, as far as networks and colours tell: a matte whose edges are still coarse."""

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
"""A window about a person is matted again, from near, if it is enlarged by as much and is no smaller than that."""
_EDGE_SHARE = 0.15
"""Share of such a window's side over which it fades toward its edge."""
_EVEN_PX, _EVEN = 5, 0.15
"""Side of the window in which a matte may be even, and by how much it deviates there if it is hardly so."""
_STEEP = 3.0
"""The contrast about one half by which an even matte is decided."""


@dataclass(frozen=True, eq=False)
class SeenPeople:
    """What networks see of the people in a photo.

    Attributes:
        people: looks at each, hair and clothes included, from the nearest to the widest (see `place_masks`).
        faces: a look at each face, its probability instead of the person's.
        others: looks, as at the people, at whoever is known not to be meant.
        hair: what is known of each head's.
    """

    people: Sequence[list[Look]]
    faces: Sequence[Look] = ()
    others: Sequence[list[Look]] = ()
    hair: Sequence[Hair] = ()

    def moved(self, x: float, y: float) -> SeenPeople:
        """The same in a photo that begins elsewhere, by pixels of it; of the hair nothing."""

        def move(looks: Iterable[Look]) -> list[Look]:
            return [(mask, view.moved(x, y)) for mask, view in looks]

        people, others = ([move(looks) for looks in of_each] for of_each in (self.people, self.others))
        return SeenPeople(people, move(self.faces), others)


def first_matte(guide: np.ndarray, seen: SeenPeople, photo_size: tuple[float, float]) -> np.ndarray:
    """The matte (h, w) of a picture (h, w, 3), sRGB, as networks and colours have it; see `draft_matte`."""
    size = shrunk_size(guide.shape[:2], _MATTING_PX)
    placed = place_masks(seen.people, size, photo_size, seen.others)
    face, near = place_faces(seen.faces, size, photo_size), near_views(seen.people, size, photo_size)
    coarse = _matted(guide, placed, face, near, size)
    return _seen_nearer(coarse, guide, seen, photo_size)


def first_matte_within(cells: Inside, guide: np.ndarray, seen: SeenPeople, photo_size: tuple[int, int]) -> np.ndarray:
    """`first_matte` of some cells of a picture alone, whose edges go on around them."""
    (rows, columns), (height, width) = cells, guide.shape[:2]
    down, across = photo_size[0] / height, photo_size[1] / width
    part, within = np.ascontiguousarray(guide[cells]), seen.moved(-columns.start * across, -rows.start * down)
    share = first_matte(part, within, (part.shape[0] * down, part.shape[1] * across))
    return going_on(share, cells, (height, width))


def _matted(
    guide: np.ndarray, placed: list[np.ndarray], face: np.ndarray, near: np.ndarray, size: tuple[int, int]
) -> np.ndarray:
    """The matte (h, w) of a picture (h, w, 3), sRGB, made in a copy of `size`.

    Args:
        placed, face, near: masks of that size, see `likely_person`.
    """
    seen = np.clip(resize_area(guide, size), 0, 1)
    likely = likely_person(seen, placed, face, near)
    soft = attached(closed_form_matte(seen, likely), placed)
    # What an even grey tied to somebody may hang together with nobody once that is decided.
    whole = without_holes(soft, placed, likely)
    decided = without_lookalikes(_decided(whole), seen, whole)
    return resize_smooth(attached(decided, placed), guide.shape[:2])


def _seen_nearer(
    coarse: np.ndarray, guide: np.ndarray, seen: SeenPeople, photo_size: tuple[float, float]
) -> np.ndarray:
    """A matte (h, w) made again, from near, where people are small in the photo.

    In a copy of all of it an ear or a strand is less than a pixel there, and mixes with whatever is beside it. Where
    several windows meet, the nearest look counts, in whichever order the people come.
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
    """`window_of` a crop; None where little more would be seen from near."""
    rows, columns = window = window_of(crop, photo_size, size)
    sides = rows.stop - rows.start, columns.stop - columns.start
    if min(sides) < _LEAST_NEAR_PX:
        return None
    finer = max(max(size), _MATTING_PX) / max(max(sides), _MATTING_PX)
    return window if finer >= _NEAR_FROM else None


def _widest_first(window: tuple[slice, slice]) -> tuple[int, ...]:
    """What sorts windows by their longer side, and by their place where that is the same."""
    rows, columns = window
    height, width = rows.stop - rows.start, columns.stop - columns.start
    return -max(height, width), -min(height, width), rows.start, columns.start


def _weight(window: tuple[slice, slice], size: tuple[int, int]) -> np.ndarray:
    """(h, w) how much a window counts at each of its pixels: less toward its sides but for those of the picture."""
    down, across = (_fading(part, length) for part, length in zip(window, size, strict=True))
    return down[:, None] * across[None]


def _fading(part: slice, length: int) -> np.ndarray:
    """`fade` along a part of an axis of `length`."""
    count = part.stop - part.start
    return fade((np.arange(count) + 0.5) / count, _EDGE_SHARE, part.start / count, (length - part.stop) / count)


def _decided(matte: np.ndarray) -> np.ndarray:
    """The matte, but where it is half and half over a whole area it says what is likelier.

    Strands of hair and blurred edges change from pixel to pixel; an even grey is a trunk or a wall of the colours
    of the person before it, and would take on a third of every light.
    """
    window = (_EVEN_PX, _EVEN_PX)
    mean = cv2.blur(matte, window)
    deviation = np.sqrt(np.maximum(cv2.blur(matte * matte, window) - mean**2, 0.0))
    even = np.exp(-((deviation / _EVEN) ** 2))
    return matte + even * (np.clip(_STEEP * (matte - 0.5) + 0.5, 0.0, 1.0) - matte)
