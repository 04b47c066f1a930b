"""At which exposure the networks see a photo: the photo's own, unless that is unlike any they have learnt from.

Of the photos in training, 90 in a hundred have the brightest tenth of their skin between 0.12 and 0.9 of white, and 98
between 0.065 and 0.97. A photo that is underexposed by several stops is darker, and a floating-point
one comes in units of its own: in these the networks would find black skin, or a photo that is clipped all over. What
they see is therefore multiplied, and what they find is counted back; the photo itself keeps its level.
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
"""Of the brightest tenth of a face, at the least, and of a fiftieth of it where that is brighter than white."""
_GLARE = 2.0
"""What is brighter than the brightest third of a face by more than this is no skin."""
_OF_CROP = 0.6
"""The middle of a face's crop, which is skin, as a share of its side."""
_LOOKS = 48
_ABOUT_PX = 128
_NEARNESS_POWER = 4
_BLACK = 1e-12
_MOST = {8: 2.0**5, 16: 2.0**10, 32: 2.0**40}
"""By the photo's bits: what is darker still is a few codes, and noise between them."""


def exposure_of_face(photo: Photo, crop: Crop) -> float:
    """What the networks see of a face is the photo times this; 1 for all but very dark and very bright photos.

    Args:
        crop: the paper's square around the face (section 3.2).
    """
    middle = Crop(crop.centre_x, crop.centre_y, _OF_CROP * crop.side)
    seen = luminance(looked_at(photo, middle))
    third, tenth, fiftieth = (float(found) for found in np.percentile(seen, (70, 90, 98)))
    return _exposure(tenth, min(fiftieth, _GLARE * third), _MOST[photo.bits])


def exposure_of_view(photo: Photo, view: Crop) -> float:
    """The same of a view that may hold a face anywhere: it is dark all over, or half of it is brighter than white."""
    seen = luminance(looked_at(photo, view))
    return _exposure(float(np.percentile(seen, 95)), float(np.median(seen)), _MOST[photo.bits])


def exposure_about_faces(
    exposures: Sequence[float], crops: Sequence[Crop], photo_size: tuple[int, int]
) -> float | np.ndarray:
    """The exposure of a photo's surroundings of faces that may have one each: that of the nearest, by degrees.

    Args:
        exposures, crops: of the faces, at least one.

    Returns:
        a number where they have the same, else a map (k, l, 1) float32 over the whole photo.
    """
    if len(set(exposures)) == 1:
        return exposures[0]
    places = places_of(shrunk_size(photo_size, _ABOUT_PX), photo_size)
    far = [np.linalg.norm(places - (crop.centre_x, crop.centre_y), axis=-1) / crop.side for crop in crops]
    nearness = np.stack([(1 / (0.1 + distance)) ** _NEARNESS_POWER for distance in far], axis=-1)
    # Exposures are factors, between which the way leads over their logarithms.
    return np.exp(nearness @ np.log(exposures) / nearness.sum(-1))[..., None].astype(np.float32)


def exposed(linear: np.ndarray, exposure: float | np.ndarray, band: Band) -> np.ndarray:
    """Some of a photo (h, w, 3) times an exposure that may differ from place to place, see `exposure_about_faces`.

    Args:
        band: which pixels they are.
    """
    if isinstance(exposure, np.ndarray):
        return linear * spread_window(exposure, whole_photo(band.photo_size), band)
    return linear if exposure == 1.0 else linear * np.float32(exposure)


def looked_at(photo: Photo, window: Crop) -> np.ndarray:
    """(N, 3) pixels of a window of a photo, spread evenly over what of it is inside its picture."""
    image = picture_pixels(photo)
    x0, y0, x1, y1 = in_picture(photo, window).window
    height, width = image.shape[:2]
    rows, columns = (
        np.clip(np.linspace(start, end, _LOOKS + 1)[:-1] + (end - start) / (2 * _LOOKS), 0, length - 1).astype(int)
        for start, end, length in ((y0, y1, height), (x0, x1, width))
    )
    return image[np.ix_(np.unique(rows), np.unique(columns))].reshape(-1, 3)


def _exposure(dark_below: float, bright_above: float, most: float) -> float:
    if bright_above > _WHITE:
        # The brighter, the farther from where the networks count skin as clipped, and none of it at once.
        return max(_BRIGHTEST, 2 * _WHITE - bright_above) / bright_above
    return min(max(_DARKEST / max(dark_below, _BLACK), 1.0), most)
