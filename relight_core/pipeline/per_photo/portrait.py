"""A photo made ready for relighting: its face, and the view of it that the networks see."""

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
from relight_core.imaging.toning import is_grey
from relight_core.pipeline.per_photo.exposing import exposure_of_face
from relight_core.pipeline.per_photo.network_view import in_photo, in_picture, picture_size, picture_view

SURROUNDINGS = 1.7
"""The networks' view is up to this many times the paper's crop: hair, neck and shoulders change with the light too."""

_TURNED_FROM_DEG = 10.0
"""A head that leans by less is seen in an upright view, as the networks saw many."""

_FINER_FROM_DEG = 3.0

_LARGEST_BOX = 4
"""In lengths of the photo: what lies outside it is made up of its border, and takes memory."""

_LOOKS = 3

_LOOKED_AT_PX = 128


@dataclass(frozen=True, eq=False)
class Portrait:
    """A photo with one of its faces chosen.

    Attributes:
        photo: the whole photo.
        found: where the face finder saw the face.
        face: the face's box, refined by the parsing map once that is known.
        crop: the paper's square around the face.
        view: the wider square that the networks see.
        exposure: what they see of it is the photo times this, see `per_photo.exposing`.
    """

    photo: Photo
    found: FaceBox
    face: FaceBox
    crop: Crop
    view: Crop
    exposure: float = 1.0

    @cached_property
    def monochrome(self) -> bool:
        """Whether the face has no colour of its own: that of a black-and-white or toned photo, or one that is grey.

        Grey faces stay so in photos that have colours elsewhere: a stamped date, a mark, a page or buttons around.
        """
        return self.photo.monochrome or self._is_grey()

    def _is_grey(self) -> bool:
        seen = picture_view(self.photo, self.crop, _LOOKED_AT_PX) * np.float32(self.exposure)
        return is_grey(srgb_encode(np.clip(seen, 0, 1)))


def located(photo: Photo, view: Crop, parsed: Callable[[Crop], np.ndarray]) -> FaceBox | None:
    """Where the parsing sees a face in a view, looked at again from as near as a face should be.

    Args:
        parsed: gives the parsing of a view, (classes, S, S) probabilities.
    """
    place = None
    for _ in range(_LOOKS):
        nearer = box_from_parsing(parsed(view), view)
        if nearer is None:
            break
        place, view = nearer, frame(photo, nearer).view
    return place


def frame(photo: Photo, found: FaceBox) -> Portrait:
    """A first framing, from the finder's box alone."""
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
    """The framing with the face's box as the parsing map of the view has it (paper, section 3.2).

    A parsing map that disagrees wildly with the finder is not believed.

    Args:
        parsing: (classes, S, S) probabilities, of the view.
    """
    box = box_from_parsing(parsing, portrait.view)
    if box is None or not _plausible(box, portrait.found):
        return portrait
    crop = crop_with_padding(box)
    return replace(portrait, face=box, crop=crop, view=_view_around(crop, portrait.photo))


def straightened(portrait: Portrait, labels: np.ndarray) -> Portrait | None:
    """The first framing again, turned by how far the head leans more than the finder saw; None where it hardly does.

    Args:
        labels: (S, S) parsing labels of the view.
    """
    roll_deg = remaining_roll(labels)
    if abs(roll_deg) < (_TURNED_FROM_DEG if portrait.found.roll_deg == 0 else _FINER_FROM_DEG):
        return None
    return frame(portrait.photo, replace(portrait.found, roll_deg=portrait.found.roll_deg + roll_deg))


def framed(photo: Photo, box: FaceBox, parsed: Callable[[Crop], np.ndarray]) -> Portrait:
    """A face framed by its parsing map, upright as far as that says how it leans.

    Args:
        parsed: gives the parsing of a view, (classes, S, S) probabilities.
    """
    portrait = frame(photo, box)
    portrait = straightened(portrait, parsed(portrait.view).argmax(0)) or portrait
    return refine(portrait, parsed(portrait.view))


def _view_around(crop: Crop, photo: Photo) -> Crop:
    """The wider square, moved and shrunk to stay inside the photo and its frame as far as the crop itself allows.

    Continued border pixels are streaks that no network has seen, so as few as possible are shown to it.
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
    if side >= length:
        return float(round((length - side) / 2))
    return float(round(min(max(start, 0), length - side)))


def _plausible(box: FaceBox, found: FaceBox) -> bool:
    width = min(box.x1, found.x1) - max(box.x0, found.x0)
    height = min(box.y1, found.y1) - max(box.y0, found.y0)
    if width <= 0 or height <= 0:
        return False
    shared = width * height / (found.width * found.height)
    return shared > 0.5 and 0.6 < box.width / found.width < 1.5 and 0.6 < box.height / found.height < 1.8
