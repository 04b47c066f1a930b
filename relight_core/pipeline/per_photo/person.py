"""The person in a photo at any size of picture: matte and colour, which don't depend on the light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from relight_core.face.paste import Band, bands, spread_window, whole_photo
from relight_core.imaging.black_level import Black
from relight_core.imaging.in_order import in_order
from relight_core.imaging.photo import Photo, without_black
from relight_core.imaging.photo_frame import Inside
from relight_core.imaging.resampling import resize_area, shrunk_size
from relight_core.pipeline.per_photo.exposing import exposed
from relight_core.pipeline.per_photo.matte import Matte, guide_of
from relight_core.pipeline.per_photo.mixed_pixels import MixedPixels

_LEAST_ALPHA = 1e-12


@dataclass(frozen=True, eq=False)
class Canvas:
    """The photo at the picture's size.

    Attributes:
        linear: (h, w, 3) linear, not premultiplied.
        alpha: (h, w) the photo's own, or None.
        photo_size: (height, width) of the photo.
        beyond: (h, w, 3) float16, the part of colours outside Rec.709 (see `Photo`), or None. Smaller copies have none.
        black: the lifted black that has been subtracted from `linear`, or None. Where the photo is darker than it,
            `linear` is below 0.
    """

    linear: np.ndarray
    alpha: np.ndarray | None
    photo_size: tuple[int, int]
    beyond: np.ndarray | None = None
    black: Black | None = None

    @property
    def size(self) -> tuple[int, int]:
        """(height, width) of the picture."""
        return self.linear.shape[:2]


def canvas_of(photo: Photo, longest_side_px: int | None = None, black: Black | None = None) -> Canvas:
    """The photo, or a copy whose longer side has at most so many pixels, with its lifted black subtracted."""
    linear = without_black(photo.linear, black)
    whole = Canvas(linear, photo.alpha, photo.linear.shape[:2], photo.beyond, black)
    return shrunk(whole, longest_side_px)


def shrunk(canvas: Canvas, longest_side_px: int | None) -> Canvas:
    """A canvas, or a copy whose longer side has at most so many pixels; black where it is fully transparent."""
    if longest_side_px is None or max(canvas.size) <= longest_side_px:
        return canvas
    size = shrunk_size(canvas.photo_size, longest_side_px)
    if canvas.alpha is None:
        return Canvas(resize_area(canvas.linear, size), None, canvas.photo_size, black=canvas.black)
    share = np.clip(np.nan_to_num(canvas.alpha), 0, 1)
    alpha = resize_area(share, size)
    # Weighted by alpha, so that the colours of transparent pixels don't mix into those of the edge.
    colour = resize_area(canvas.linear * share[..., None], size) / np.maximum(alpha, _LEAST_ALPHA)[..., None]
    return Canvas(colour, alpha, canvas.photo_size, black=canvas.black)


@dataclass(frozen=True, eq=False)
class Person:
    """The matte and the person's own colour at every pixel of a canvas or of a band of it.

    Attributes:
        share: (h, w) in [0, 1], the matte (alpha).
        colour: (h, w, 3) linear, the foreground's, not premultiplied.
    """

    share: np.ndarray
    colour: np.ndarray


def person_in(canvas: Canvas, matte: Matte, band: Band) -> Person:
    """The person in a band of a canvas."""
    linear = canvas.linear[band.pixels]
    if matte.own_alpha:
        return Person(np.clip(np.nan_to_num(canvas.alpha[band.pixels]), 0, 1), linear)
    everywhere = whole_photo(canvas.photo_size)
    share = spread_window(matte.slope, everywhere, band)
    share *= guide_of(exposed(linear, matte.exposure, band))
    share += spread_window(matte.level, everywhere, band)
    np.clip(share, 0, 1, out=share)
    if matte.ends is not None:
        within = _within(matte.ends, band)
        share *= within
        if matte.beyond is not None:
            share += ~within * spread_window(matte.beyond, everywhere, band)
    if not ((share > 0) & (share < 1)).any():
        return Person(share, linear)
    sides = (spread_window(side, everywhere, band) for side in (matte.person, matte.behind))
    mixed = MixedPixels.of(linear, share, *sides)
    if matte.crisp is not None:
        share = mixed.refined(share, spread_window(matte.crisp, everywhere, band))
    return Person(share, mixed.own_colour(linear, share))


def _within(ends: Inside, band: Band) -> np.ndarray:
    """Which pixels of a band have their centres within some rows and columns of the photo, (h, w) bool."""
    rows = np.arange(band.top, band.bottom, band.step)
    within = [
        (middles >= span.start) & (middles < span.stop)
        for span, at, few, many in zip(ends, (rows, np.arange(*band.span)), band.size, band.photo_size, strict=True)
        for middles in [(at + 0.5) * (many / few)]
    ]
    return within[0][:, None] & within[1]


def whole_person(canvas: Canvas, matte: Matte) -> Person:
    """The person in the whole canvas, for pictures that are made many times."""
    parts = list(in_order(lambda band: person_in(canvas, matte, band), bands(canvas.size, canvas.photo_size)))
    return Person(np.concatenate([p.share for p in parts]), np.concatenate([p.colour for p in parts]))
