"""A face in a photo and its framing: the paper's crop, and the wider view that the networks see."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, replace
from functools import cached_property

import numpy as np

from relight_core.errors import InputError
from relight_core.face.crop import Crop, box_from_parsing, crop_for_face, crop_with_padding
from relight_core.face.find import FaceBox
from relight_core.face.lean import remaining_roll
from relight_core.imaging.colour import srgb_encode
from relight_core.imaging.photo import Photo
from relight_core.imaging.toning import is_grey, is_mostly_grey
from relight_core.pipeline.per_photo.exposing import exposure_of_face
from relight_core.pipeline.per_photo.network_view import in_photo, in_picture, picture_size, picture_view

SURROUNDINGS = 1.7
"""The networks' view is up to this many times the paper's crop: hair, neck and shoulders change with the light too."""

_TURNED_FROM_DEG = 10.0
"""A head that leans by less keeps an upright view, since the networks were trained on such heads."""

_FINER_FROM_DEG = 3.0
"""A view that is rotated already is corrected from this angle on."""

_LARGEST_BOX = 4
"""Longest side of a box in longer sides of the photo; what lies outside the photo only repeats its border, and takes
memory."""

_LOOKS = 3
"""Views in which a face is located, each nearer than the one before."""

_LOOKED_AT_PX = 128
"""Side of the copy in which it is decided whether a face is grey."""

_MIDDLE = 0.75
"""Side of the middle of a face, in sides of its box."""


@dataclass(frozen=True, eq=False)
class Portrait:
    """A photo with one of its faces chosen.

    Attributes:
        photo: the whole photo.
        found: the box of the face finder.
        face: the face's box, refined by the parsing once that is known.
        crop: the paper's square around the face.
        view: the wider square that the networks see.
        exposure: the gain at which they see it, see `per_photo.exposing`.
    """

    photo: Photo
    found: FaceBox
    face: FaceBox
    crop: Crop
    view: Crop
    exposure: float = 1.0

    @cached_property
    def monochrome(self) -> bool:
        """Whether the face has no colour and gets none: in a black-and-white or toned photo, or if the face is grey.

        A grey face may be in a photo with colours elsewhere, such as a stamped date, a watermark or a coloured page,
        and have some itself: lips or eyes that kept theirs when the colours of all else were removed.
        """
        return self.photo.monochrome or self._is_grey()

    def _is_grey(self) -> bool:
        """Whether the crop of the face has no colour, or most of the middle of the face."""
        return is_grey(self._codes(self.crop)) or is_mostly_grey(self._codes(_middle_of(self.face)))

    def _codes(self, crop: Crop) -> np.ndarray:
        seen = picture_view(self.photo, crop, _LOOKED_AT_PX) * np.float32(self.exposure)
        return srgb_encode(np.clip(seen, 0, 1))


def _middle_of(face: FaceBox) -> Crop:
    """A square within a face: eyes, nose, cheeks and mouth, but hardly hair, a hat or a collar."""
    middle = (face.x0 + face.x1) / 2, (face.y0 + face.y1) / 2
    return Crop(*middle, _MIDDLE * max(face.width, face.height), face.roll_deg)


def located(photo: Photo, view: Crop, parsed: Callable[[Crop], np.ndarray]) -> FaceBox | None:
    """Find a face in a view by its parsing, and again in a view that is framed around what was found.

    Args:
        photo: to search.
        view: of the photo.
        parsed: returns the parsing of a view, (classes, S, S) probabilities.

    Returns:
        None if there is none in the first view.
    """
    place = None
    for _ in range(_LOOKS):
        nearer = box_from_parsing(parsed(view), view)
        if nearer is None:
            break
        place, view = nearer, frame(photo, nearer).view
    return place


def frame(photo: Photo, found: FaceBox) -> Portrait:
    """The first framing, from the finder's box alone."""
    crop = crop_for_face(found)
    return Portrait(photo, found, found, crop, _view_around(crop, photo), exposure_of_face(photo, crop))


def checked_boxes(photo: Photo, boxes: Sequence[FaceBox]) -> Sequence[FaceBox]:
    """The boxes that a user drew.

    Raises:
        InputError: a box that is empty, outside the photo, or many times as large.
    """
    height, width = photo.linear.shape[:2]
    name = photo.path or "the photo"
    for box in boxes:
        inside = box.x1 > 0 and box.y1 > 0 and box.x0 < width and box.y0 < height
        if not (np.isfinite(astuple(box)).all() and box.width >= 1 and box.height >= 1 and inside):
            raise InputError(f"{name}: the box of a face is empty or outside; draw it over the face")
        if max(box.width, box.height) > _LARGEST_BOX * max(width, height):
            raise InputError(f"{name}: the box of a face is much larger than the photo; draw it over the face")
    return boxes


def refine(portrait: Portrait, parsing: np.ndarray) -> Portrait:
    """The framing from the face's box in the parsing of the view (paper, section 3.2).

    If that differs too much from the finder's box, the portrait is returned unchanged.

    Args:
        portrait: so far.
        parsing: (classes, S, S) probabilities, of the view.
    """
    box = box_from_parsing(parsing, portrait.view)
    if box is None or not _plausible(box, portrait.found):
        return portrait
    crop = crop_with_padding(box)
    return replace(portrait, face=box, crop=crop, view=_view_around(crop, portrait.photo))


def straightened(portrait: Portrait, labels: np.ndarray) -> Portrait | None:
    """The first framing, rotated by the angle at which the head still leans in the view.

    Args:
        portrait: so far.
        labels: (S, S) parsing labels of the view.

    Returns:
        None if the angle is small.
    """
    roll_deg = remaining_roll(labels)
    if abs(roll_deg) < (_TURNED_FROM_DEG if portrait.found.roll_deg == 0 else _FINER_FROM_DEG):
        return None
    return frame(portrait.photo, replace(portrait.found, roll_deg=portrait.found.roll_deg + roll_deg))


def framed(photo: Photo, box: FaceBox, parsed: Callable[[Crop], np.ndarray]) -> Portrait:
    """A face framed by its parsing, and rotated upright if the parsing shows that it leans.

    Args:
        photo: of the face.
        box: of the finder.
        parsed: returns the parsing of a view, (classes, S, S) probabilities.
    """
    portrait = frame(photo, box)
    portrait = straightened(portrait, parsed(portrait.view).argmax(0)) or portrait
    return refine(portrait, parsed(portrait.view))


def _view_around(crop: Crop, photo: Photo) -> Crop:
    """The networks' view around a crop, shifted and shrunk to lie within the photo and its frame as far as possible.

    Outside, border pixels are repeated as streaks, which the networks were not trained on. The view is at least as
    large as the crop.
    """
    height, width = picture_size(photo)
    side = float(round(max(min(crop.side * SURROUNDINGS, height, width), crop.side, 1)))
    if crop.roll_deg:
        return replace(crop, side=side)
    within = in_picture(photo, crop)
    x0 = _kept_inside(within.centre_x - side / 2, side, width)
    y0 = _kept_inside(within.centre_y - side / 2, side, height)
    return in_photo(photo, Crop(x0 + side / 2, y0 + side / 2, side))


def _kept_inside(start: float, side: float, length: int) -> float:
    """The start of a window on whole pixels, shifted to lie within a length, or centred on it if it is longer."""
    if side >= length:
        return float(round((length - side) / 2))
    return float(round(min(max(start, 0), length - side)))


def _plausible(box: FaceBox, found: FaceBox) -> bool:
    """Whether a box from the parsing covers most of the finder's box and has about its size."""
    width = min(box.x1, found.x1) - max(box.x0, found.x0)
    height = min(box.y1, found.y1) - max(box.y0, found.y0)
    if width <= 0 or height <= 0:
        return False
    shared = width * height / (found.width * found.height)
    return shared > 0.5 and 0.6 < box.width / found.width < 1.5 and 0.6 < box.height / found.height < 1.8
