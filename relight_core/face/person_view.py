"""The part of a photo in which the person network looks for the person whose face has been found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from relight_core.face.crop import PADDED_PX, PADDING_PX, Crop, axes_in_photo
from relight_core.face.paste import places_of

FACE_SHARE = 1 - 2 * PADDING_PX / PADDED_PX
"""Of the paper's crop."""

_ACROSS, _WIDER_ACROSS = 3.4, 4.8
_DOWN, _LOWER = 0.35, 0.39
_MUCH_WIDER = 1.15


def person_view(crop: Crop, photo_size: tuple[float, float], faces_across: float = _ACROSS) -> Crop:
    """The view about the crop of a face (paper, section 3.2): so many faces wide, or as wide as the photo is.

    Shoulders are wider than hair is high, so its middle lies below the face's, and the lower the wider it is. It is
    turned as the crop is, and moved to stay within the photo, or the upright box about a turned one, as far as it can.

    Args:
        photo_size: (height, width).
        faces_across: at least 3.4, in which a head and shoulders are seen.
    """
    height, width = photo_size
    face = crop.side * FACE_SHARE
    right, down = axes_in_photo(crop.roll_deg)
    across, along = (float(np.abs(axis) @ [width, height]) for axis in (right, down))
    side = max(min(faces_across * face, max(across, along)), face)
    middle = np.array([width, height]) / 2
    place = np.array([crop.centre_x, crop.centre_y]) - middle
    lower = (_DOWN + _LOWER * (faces_across - _ACROSS)) * face
    aside, below = _kept_within(place @ right, side, across), _kept_within(place @ down + lower, side, along)
    x, y = middle + aside * right + below * down
    return Crop(float(x), float(y), side, crop.roll_deg)


def upright(crop: Crop) -> Crop:
    """A crop turned as the photo lies, and not as the head leans: heads lean farther than bodies do."""
    return replace(crop, roll_deg=90.0 * round(crop.roll_deg / 90))


def wider_view(crop: Crop, photo_size: tuple[float, float]) -> Crop | None:
    """A view about the crop of a face for what of a body is out of sight in its `person_view`, down to the hips.

    None where little more of the photo would be seen in it.

    Args:
        crop: an `upright` one.
        photo_size: (height, width).
    """
    view = person_view(crop, photo_size, _WIDER_ACROSS)
    return view if view.side > _MUCH_WIDER * person_view(crop, photo_size).side else None


def _kept_within(middle: float, side: float, length: float) -> float:
    """Where a window's middle goes, both counted from the middle of what it shall stay within."""
    slack = max(length - side, 0) / 2
    return min(max(middle, -slack), slack)


def inside_photo(view: Crop, photo_size: tuple[float, float], size: int) -> np.ndarray:
    """(size, size) float32: 1 where a pixel of a view lies within a photo of (height, width)."""
    height, width = photo_size
    at = view.to_photo(places_of((size, size), (size, size)), size)
    return ((at >= 0) & (at < [width, height])).all(-1).astype(np.float32)


def face_in_view(view: Crop, crop: Crop, size: int) -> np.ndarray:
    """(size, size) float32: 1 in the square of the face that is meant, which lies in the middle of its crop."""
    at = crop.from_photo(view.to_photo(places_of((size, size), (size, size)), size), 1)
    return (np.abs(at - 0.5) < FACE_SHARE / 2).all(-1).astype(np.float32)
