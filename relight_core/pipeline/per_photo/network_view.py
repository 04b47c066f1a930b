"""What the networks see of a photo: the picture within its frame, whose edge pixels are repeated outside."""

from __future__ import annotations

import math

import numpy as np

from relight_core.face.crop import Crop
from relight_core.imaging.colour import without_colour
from relight_core.imaging.photo import Photo

_REACH, _TAPS_PX = math.sqrt(0.5), 4
"""Distance of a rotated view's corners from its centre, in its sides; and pixels that its resampling reads beyond."""


def network_view(photo: Photo, view: Crop, size: int, exposure: float) -> np.ndarray:
    """A view (size, size, 3) of a photo, linear; see `as_networks_see`."""
    return as_networks_see(picture_view(photo, view, size), photo.monochrome, exposure)


def picture_view(photo: Photo, view: Crop, size: int) -> np.ndarray:
    """A view (size, size, 3) of the picture within a photo's frame, linear; its edge pixels are repeated outside."""
    pixels, within = picture_pixels(photo), in_picture(photo, view)
    if pixels.flags.c_contiguous:
        return within.extract(pixels, size)
    # Resampling copies arrays that aren't contiguous, so only the part around the view is passed to it.
    rows, columns = (
        _about(middle, _REACH * view.side + _TAPS_PX, length)
        for middle, length in zip((within.centre_y, within.centre_x), pixels.shape[:2], strict=True)
    )
    return within.moved(-columns.start, -rows.start).extract(pixels[rows, columns], size)


def _about(middle: float, reach: float, length: int) -> slice:
    """The pixels, out of `length`, within `reach` of a position; the nearest one if there are none."""
    start = min(max(math.floor(middle - reach), 0), length - 1)
    return slice(start, max(min(math.ceil(middle + reach), length), start + 1))


def picture_pixels(photo: Photo) -> np.ndarray:
    """The photo within its frame, (h, w, 3) linear; a cut-out is composited over grey."""
    x0, y0, x1, y1 = photo.picture
    return photo.seen.linear[y0:y1, x0:x1]


def picture_size(photo: Photo) -> tuple[int, int]:
    """(height, width) of `picture_pixels`."""
    x0, y0, x1, y1 = photo.picture
    return y1 - y0, x1 - x0


def in_picture(photo: Photo, crop: Crop) -> Crop:
    """A crop of a photo in coordinates of `picture_pixels`."""
    x0, y0, *_ = photo.picture
    return crop.moved(-x0, -y0)


def in_photo(photo: Photo, crop: Crop) -> Crop:
    """The inverse of `in_picture`."""
    x0, y0, *_ = photo.picture
    return crop.moved(x0, y0)


def as_networks_see(view: np.ndarray, monochrome: bool, exposure: float) -> np.ndarray:
    """A view (S, S, 3), linear, as the networks see it: exposed, and without the tone of a monochrome photo."""
    seen = without_colour(view) if monochrome else view
    return seen if exposure == 1.0 else seen * np.float32(exposure)
