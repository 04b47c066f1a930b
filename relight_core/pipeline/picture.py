"""The finished picture, a band of rows at a time: every pixel is a function of the photo's own and of small maps.

So a picture of any size, a preview of the screen's size, and a file too large to hold twice in memory are
all the same computation, and how it is cut changes nothing.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.paste import Band, bands, spread_crop, spread_window, whole_photo
from relight_core.imaging.matte import Matte, guide_of, own_colour
from relight_core.imaging.photo import Photo
from relight_core.imaging.resampling import resize_area
from relight_core.pipeline.backdrop import Backdrop
from relight_core.pipeline.channels import ViewChange

_WORKERS = min(os.cpu_count() or 1, 4)
_LIGHT_WRAP = 0.25


@dataclass(frozen=True, eq=False)
class Canvas:
    """The photo at the picture's size.

    Attributes:
        linear: (h, w, 3) linear.
        alpha: (h, w) the photo's own, or None.
        photo_size: (height, width) of the photo.
    """

    linear: np.ndarray
    alpha: np.ndarray | None
    photo_size: tuple[int, int]

    @property
    def size(self) -> tuple[int, int]:
        """(height, width) of the picture."""
        return self.linear.shape[:2]


def canvas_of(photo: Photo, longest_side_px: int | None = None) -> Canvas:
    """The photo itself, or a copy of it that is no longer than so many pixels."""
    size = photo.linear.shape[:2]
    if longest_side_px is None or max(size) <= longest_side_px:
        return Canvas(photo.linear, photo.alpha, size)
    small = tuple(max(round(length * longest_side_px / max(size)), 1) for length in size)
    alpha = None if photo.alpha is None else resize_area(photo.alpha, small)
    return Canvas(resize_area(photo.linear, small), alpha, size)


@dataclass(frozen=True, eq=False)
class Person:
    """What no light changes: the matte and the person's own colour at every pixel of a canvas.

    Attributes:
        share: (h, w) in [0, 1]
        colour: (h, w, 3) linear.
    """

    share: np.ndarray
    colour: np.ndarray


def person_in(canvas: Canvas, matte: Matte, band: Band) -> Person:
    """The person in a band of a canvas."""
    linear = canvas.linear[band.rows]
    if matte.own_alpha:
        return Person(np.clip(np.nan_to_num(canvas.alpha[band.rows]), 0, 1), linear)
    everywhere = whole_photo(canvas.photo_size)
    share = spread_window(matte.slope, everywhere, band)
    share *= guide_of(linear)
    share += spread_window(matte.level, everywhere, band)
    np.clip(share, 0, 1, out=share)
    sides = (spread_window(side, everywhere, band) for side in (matte.person, matte.behind))
    return Person(share, own_colour(linear, share, *sides))


def whole_person(canvas: Canvas, matte: Matte) -> Person:
    """The person in all of a canvas, for a picture that is made many times."""
    parts = _in_parallel(lambda band: person_in(canvas, matte, band), bands(canvas.size, canvas.photo_size))
    return Person(np.concatenate([p.share for p in parts]), np.concatenate([p.colour for p in parts]))


@dataclass(frozen=True, eq=False)
class PlacedChange:
    """What a light makes of one face's view, and where it counts.

    Attributes:
        change: of the view.
        view: where it lies.
        weight: (k, l) over the whole photo, in [0, 1]; those of all faces sum to at most 1.
    """

    change: ViewChange
    view: Crop
    weight: np.ndarray


@dataclass(frozen=True, eq=False)
class Picture:
    """A relit picture that is computed where it is asked for.

    Attributes:
        canvas: the photo at the picture's size.
        matte: of the photo.
        changes: one for each face.
        rest: (h, w, 3) gain over the whole photo where no view counts, at the light's level.
        backdrop: what is behind the person.
        person: of the whole canvas, where it is kept; else it is worked out band by band.
    """

    canvas: Canvas
    matte: Matte
    changes: tuple[PlacedChange, ...]
    rest: np.ndarray
    backdrop: Backdrop
    person: Person | None = field(default=None, repr=False)

    @property
    def size(self) -> tuple[int, int]:
        """(height, width)."""
        return self.canvas.size

    @property
    def has_alpha(self) -> bool:
        """Whether the background is taken away."""
        return self.backdrop.transparent

    def render(self) -> tuple[np.ndarray, np.ndarray | None]:
        """All of it: (H, W, 3) float32 linear, and (H, W) alpha or None."""
        image = np.empty((*self.size, 3), np.float32)
        alpha = np.empty(self.size, np.float32) if self.has_alpha else None

        def make(band: Band) -> None:
            image[band.rows], share = self.band(band)
            if alpha is not None:
                alpha[band.rows] = share

        _in_parallel(make, bands(self.size, self.canvas.photo_size))
        return image, alpha

    def in_bands(self, rows: int = 256) -> Iterator[tuple[slice, np.ndarray, np.ndarray | None]]:
        """Rows, image and alpha of one band after the other, from the top."""
        for band in bands(self.size, self.canvas.photo_size, rows):
            yield (band.rows, *self.band(band))

    def band(self, band: Band) -> tuple[np.ndarray, np.ndarray | None]:
        """Some rows: (h, W, 3) float32 linear, and (h, W) alpha or None."""
        linear = self.canvas.linear[band.rows]
        if self.person is None:
            person = person_in(self.canvas, self.matte, band)
        else:
            person = Person(self.person.share[band.rows], self.person.colour[band.rows])
        if self.backdrop.kept:
            return self._beside_the_photo(linear, person, band), None
        relit = self._relit(person.colour, band)
        if self.backdrop.transparent:
            return relit, person.share
        return self._over(relit, linear, person, band), None

    def _beside_the_photo(self, linear: np.ndarray, person: Person, band: Band) -> np.ndarray:
        """The person in the new light before the photo's own background; only the person's columns are computed."""
        result = linear.copy()
        held = np.flatnonzero(person.share.any(axis=0))
        if not held.size:
            return result
        first, last = int(held[0]), int(held[-1]) + 1
        colour, share = person.colour[:, first:last], person.share[:, first:last, None]
        relit = self._relit(colour, replace(band, columns=(first, last)))
        relit -= colour
        relit *= share
        relit += linear[:, first:last]
        np.maximum(relit, 0, out=result[:, first:last])
        return result

    def _relit(self, colour: np.ndarray, band: Band) -> np.ndarray:
        """The person's own colour (h, W, 3) in the new light."""
        everywhere = whole_photo(self.canvas.photo_size)
        gain, offset, known = None, None, np.zeros(colour.shape[:2], np.float32)
        for placed in self.changes:
            weight = spread_window(placed.weight, everywhere, band)
            if not weight.any():
                continue
            parts = (spread_crop(part, placed.view, band) for part in (placed.change.gain, placed.change.offset))
            if weight.min() == 1:
                gain, offset = parts
                known = weight
                break
            weighted = [part * weight[..., None] for part in parts]
            gain, offset = weighted if gain is None else (gain + weighted[0], offset + weighted[1])
            known = known + weight
        if gain is None:
            return spread_window(self.rest, everywhere, band) * colour
        if known.min() < 1:
            gain = gain + spread_window(self.rest, everywhere, band) * (1 - known[..., None])
        relit = gain * colour
        relit += offset
        return relit

    def _over(self, relit: np.ndarray, linear: np.ndarray, person: Person, band: Band) -> np.ndarray:
        """The person over another background, whose light wraps round the edge a little."""
        share = person.share[..., None]
        if self.backdrop.gain is not None:
            behind = np.maximum(linear - share * person.colour, 0.0)
            return share * relit + behind * self.backdrop.gain
        everywhere = whole_photo(self.canvas.photo_size)
        picture, soft = (
            spread_window(layer, everywhere, band) if layer.ndim == 3 else layer
            for layer in (self.backdrop.picture, self.backdrop.soft)
        )
        near = share if self.matte.own_alpha else spread_window(self.matte.nearby, everywhere, band)[..., None]
        wrap = _LIGHT_WRAP * share * (1.0 - near)
        return share * relit + (1.0 - share) * picture + wrap * soft


def _in_parallel(work, parts: list[Band]) -> list:
    if len(parts) == 1 or _WORKERS == 1:
        return [work(part) for part in parts]
    with ThreadPoolExecutor(_WORKERS) as pool:
        return list(pool.map(work, parts))
