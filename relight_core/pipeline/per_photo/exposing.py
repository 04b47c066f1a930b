"""The exposure at which the networks see a photo: its own, unless that is far outside the range of training.

In training, the brightest tenth of the skin begins between 0.12 and 0.9 of white in 90 % of the photos, and between
0.065 and 0.97 in 98 %. A photo that is underexposed by several stops is darker, and floating-point photos are in
arbitrary units. In these the networks would see black skin, or a photo that is clipped everywhere. So they see the
photo times a gain, and their results are scaled back; the photo itself keeps its level.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.paste import Band, places_of, spread_window, whole_photo
from relight_core.imaging.colour import luminance
from relight_core.imaging.photo import Photo
from relight_core.imaging.resampling import shrunk_size
from relight_core.pipeline.per_photo.network_view import in_picture, picture_pixels

_DARKEST, _BRIGHTEST, _WHITE = 0.15, 0.85, 1.0
"""The 90th percentile of a face is raised to the first; the 98th, if it is above white, is lowered toward the second.
"""
_GLARE = 2.0
"""What exceeds the 70th percentile of a face by more than this factor isn't skin."""
_OF_CROP = 0.6
"""The middle of a face's crop, which is mostly skin, as a share of its side."""
_LOOKS = 48
"""Pixels that are sampled along each side of a window."""
_ABOUT_PX = 128
"""Longer side of a map of exposures."""
_NEARNESS_POWER = 4
"""A face's weight in such a map falls with this power of the distance."""
_BLACK = 1e-12
"""Smallest divisor."""
_MOST = {8: 2.0**5, 16: 2.0**10, 32: 2.0**40}
"""Largest gain by the photo's bits: a darker photo has only a few codes, with noise between them."""


def exposure_of_face(photo: Photo, crop: Crop) -> float:
    """The gain at which the networks see a face: 1 for all but very dark and very bright photos.

    Args:
        photo: of the face.
        crop: the paper's square around the face (section 3.2).
    """
    middle = Crop(crop.centre_x, crop.centre_y, _OF_CROP * crop.side)
    seen = luminance(sampled_pixels(photo, middle))
    third, tenth, fiftieth = (float(found) for found in np.percentile(seen, (70, 90, 98)))
    return _exposure(tenth, min(fiftieth, _GLARE * third), _MOST[photo.bits])


def exposure_of_view(photo: Photo, view: Crop) -> float:
    """The same for a view in which a face may be anywhere: not 1 only if all of it is dark, or half is above white."""
    seen = luminance(sampled_pixels(photo, view))
    return _exposure(float(np.percentile(seen, 95)), float(np.median(seen)), _MOST[photo.bits])


def exposure_about_faces(
    exposures: Sequence[float], crops: Sequence[Crop], photo_size: tuple[int, int]
) -> float | np.ndarray:
    """The exposure of all of a photo whose faces have different exposures: a smooth mix in which the nearest dominates.

    Args:
        exposures, crops: of the faces, at least one.
        photo_size: (height, width).

    Returns:
        A number if all have the same, otherwise a map (k, l, 1) float32 over the whole photo.
    """
    if len(set(exposures)) == 1:
        return exposures[0]
    places = places_of(shrunk_size(photo_size, _ABOUT_PX), photo_size)
    far = [np.linalg.norm(places - (crop.centre_x, crop.centre_y), axis=-1) / crop.side for crop in crops]
    nearness = np.stack([(1 / (0.1 + distance)) ** _NEARNESS_POWER for distance in far], axis=-1)
    # Exposures are factors, so their logarithms are averaged.
    return np.exp(nearness @ np.log(exposures) / nearness.sum(-1))[..., None].astype(np.float32)


def exposed(linear: np.ndarray, exposure: float | np.ndarray, band: Band) -> np.ndarray:
    """A part of a photo (h, w, 3) times an exposure, a number or a map (see `exposure_about_faces`).

    Args:
        band: the pixels of that part.
    """
    if isinstance(exposure, np.ndarray):
        return linear * spread_window(exposure, whole_photo(band.photo_size), band)
    return linear if exposure == 1.0 else linear * np.float32(exposure)


def sampled_pixels(photo: Photo, window: Crop) -> np.ndarray:
    """Pixels (N, 3) of a window of a photo, spaced evenly over the part of it that is inside the photo's frame."""
    image = picture_pixels(photo)
    x0, y0, x1, y1 = in_picture(photo, window).window
    height, width = image.shape[:2]
    rows, columns = (
        np.clip(np.linspace(start, end, _LOOKS + 1)[:-1] + (end - start) / (2 * _LOOKS), 0, length - 1).astype(int)
        for start, end, length in ((y0, y1, height), (x0, x1, width))
    )
    return image[np.ix_(np.unique(rows), np.unique(columns))].reshape(-1, 3)


def _exposure(dark_below: float, bright_above: float, most: float) -> float:
    """The gain for skin whose bright parts reach `dark_below`, and whose brightest reach `bright_above`."""
    if bright_above > _WHITE:
        # Away from white, where the networks take skin to be clipped, but gradually, so that the gain has no jump.
        return max(_BRIGHTEST, 2 * _WHITE - bright_above) / bright_above
    return min(max(_DARKEST / max(dark_below, _BLACK), 1.0), most)
