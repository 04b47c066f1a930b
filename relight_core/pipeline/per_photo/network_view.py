"""What the networks see of a photo: the picture within its frame, which goes on beyond it."""

from __future__ import annotations

import math

import numpy as np

from relight_core.face.crop import Crop
from relight_core.imaging.colour import without_colour
from relight_core.imaging.photo import Photo

_REACH, _TAPS_PX = math.sqrt(0.5), 4
"""How far a turned view reaches from its middle, in its sides, and what its resampling reads beyond."""


def network_view(photo: Photo, view: Crop, size: int, exposure: float) -> np.ndarray:
    """A view (size, size, 3) of a photo, linear; see `as_networks_see`."""
    return as_networks_see(picture_view(photo, view, size), photo.monochrome, exposure)


def picture_view(photo: Photo, view: Crop, size: int) -> np.ndarray:
    """A view (size, size, 3) of a photo's picture, linear, whose edge pixels are continued over a frame."""
    pixels, within = picture_pixels(photo), in_picture(photo, view)
    if pixels.flags.c_contiguous:
        return within.extract(pixels, size)
    # Resampling copies what does not lie in one piece, which would be all of a large photo.
    rows, columns = (
        _about(middle, _REACH * view.side + _TAPS_PX, length)
        for middle, length in zip((within.centre_y, within.centre_x), pixels.shape[:2], strict=True)
    )
    return within.moved(-columns.start, -rows.start).extract(pixels[rows, columns], size)


def _about(middle: float, reach: float, length: int) -> slice:
    """The pixels of a side of `length` that lie no farther from its middle; the nearest one where there are none."""
    start = min(max(math.floor(middle - reach), 0), length - 1)
    return slice(start, max(min(math.ceil(middle + reach), length), start + 1))


def picture_pixels(photo: Photo) -> np.ndarray:
    """(h, w, 3) linear: a photo within its frame, a cut-out before grey."""
    x0, y0, x1, y1 = photo.picture
    return photo.seen.linear[y0:y1, x0:x1]


def picture_size(photo: Photo) -> tuple[int, int]:
    """(height, width) of `picture_pixels`."""
    x0, y0, x1, y1 = photo.picture
    return y1 - y0, x1 - x0


def in_picture(photo: Photo, crop: Crop) -> Crop:
    """A crop of a photo, counted from the corner of `picture_pixels`."""
    x0, y0, *_ = photo.picture
    return crop.moved(-x0, -y0)


def in_photo(photo: Photo, crop: Crop) -> Crop:
    """The inverse of `in_picture`."""
    x0, y0, *_ = photo.picture
    return crop.moved(x0, y0)


def as_networks_see(view: np.ndarray, monochrome: bool, exposure: float) -> np.ndarray:
    """A view (S, S, 3) of a photo (a cut-out before grey), linear: a toned photo as the grey one it was, exposed."""
    seen = without_colour(view) if monochrome else view
    return seen if exposure == 1.0 else seen * np.float32(exposure)
