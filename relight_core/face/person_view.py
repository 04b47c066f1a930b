"""The part of a photo that the person network sees of the person whose face has been found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from relight_core.face.crop import PADDED_PX, PADDING_PX, Crop, axes_in_photo
from relight_core.face.paste import places_of

FACE_SHARE = 1 - 2 * PADDING_PX / PADDED_PX
"""Share of the paper's crop, along a side, that the face takes."""

_ACROSS, _WIDER_ACROSS = 3.4, 4.8
"""Widths of the two views, in faces."""
_DOWN, _LOWER = 0.35, 0.39
"""A view's centre lies below the face's by the first number of faces, and by the second more for each face of width
beyond 3.4."""
_MUCH_WIDER = 1.15
"""A wider view is worth looking at if it is at least so many times as wide."""


def person_view(crop: Crop, photo_size: tuple[float, float], faces_across: float = _ACROSS) -> Crop:
    """The view around a face: `faces_across` faces wide, or as wide as the photo if that is less.

    Its centre lies below the face's, since there is more to see of shoulders than of hair, and the lower the wider it
    is. It has the crop's roll, and is shifted so that as much of it as possible lies within the photo, or within the
    box around the photo that has the same roll.

    Args:
        crop: the paper's crop of the face (section 3.2).
        photo_size: (height, width).
        faces_across: at least 3.4, which shows head and shoulders.
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
    """The crop with its roll rounded to a quarter turn, as the photo is oriented: bodies lean less than heads."""
    return replace(crop, roll_deg=90.0 * round(crop.roll_deg / 90))


def wider_view(crop: Crop, photo_size: tuple[float, float]) -> Crop | None:
    """A view around a face that shows the body down to the hips, more than `person_view` does.

    Args:
        crop: an `upright` one.
        photo_size: (height, width).

    Returns:
        None if it would show little more of the photo.
    """
    view = person_view(crop, photo_size, _WIDER_ACROSS)
    return view if view.side > _MUCH_WIDER * person_view(crop, photo_size).side else None


def _kept_within(middle: float, side: float, length: float) -> float:
    """A window's centre, shifted so that its side stays within a length; positions count from the length's middle."""
    slack = max(length - side, 0) / 2
    return min(max(middle, -slack), slack)


def inside_photo(view: Crop, photo_size: tuple[float, float], size: int) -> np.ndarray:
    """(size, size) float32: 1 where a view's pixel lies within a photo of (height, width), elsewhere 0."""
    height, width = photo_size
    at = view.to_photo(places_of((size, size), (size, size)), size)
    return ((at >= 0) & (at < [width, height])).all(-1).astype(np.float32)


def face_in_view(view: Crop, crop: Crop, size: int) -> np.ndarray:
    """(size, size) float32 over a view: 1 in the square of the face in the middle of `crop`, elsewhere 0.

    It tells the person network which of several people is meant.
    """
    at = crop.from_photo(view.to_photo(places_of((size, size), (size, size)), size), 1)
    return (np.abs(at - 0.5) < FACE_SHARE / 2).all(-1).astype(np.float32)
