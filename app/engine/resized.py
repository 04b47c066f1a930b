"""What was corrected in a photo, by hand and in its pixels, where the photo has come to have another size."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Protocol, TypeVar

if TYPE_CHECKING:
    from relight_core.face.find import FaceBox
    from relight_core.imaging.photo import Photo
    from relight_core.pipeline.per_photo.brush import BrushStroke

Size = tuple[int, int]
"""Width and height in pixels, of a photo as it is read: upright."""

_ROUNDING_PX = 1.0
_DIGITS = 1
"""As fine as strokes are painted."""


class Corrected(Protocol):
    """A photo with what was corrected in it: a wish for one, or what a document keeps of it.

    Attributes:
        size: of the photo that it was corrected in; None where that is not known.
    """

    face_index: int | None
    boxes: tuple[FaceBox, ...] | None
    strokes: tuple[BrushStroke, ...]
    size: Size | None


Portrait = TypeVar("Portrait", bound=Corrected)


def size_of(photo: Photo) -> Size:
    """A photo's size."""
    height, width = photo.linear.shape[:2]
    return width, height


def at_size(corrected: Portrait, size: Size) -> Portrait:
    """The same portrait in the photo at a size: corrections made at another are scaled, or left out.

    They are scaled where the photo has kept its proportions. In one that was cropped nobody knows where they belong,
    nor which of the faces was chosen.
    """
    before = corrected.size
    if before == size:
        return corrected
    if before is not None and not _are_alike(before, size):
        return replace(corrected, face_index=None, boxes=None, strokes=(), size=size)
    by = (1.0, 1.0) if before is None else (size[0] / before[0], size[1] / before[1])
    if by == (1.0, 1.0) or not (corrected.boxes or corrected.strokes):
        return replace(corrected, size=size)
    boxes = corrected.boxes and tuple(_scaled_box(box, by) for box in corrected.boxes)
    strokes = tuple(_scaled_stroke(stroke, by) for stroke in corrected.strokes)
    return replace(corrected, boxes=boxes, strokes=strokes, size=size)


def loses_corrections(corrected: Corrected, size: Size) -> bool:
    """Whether corrections are left out in the photo at a size, as its proportions are others."""
    if corrected.size is None or _are_alike(corrected.size, size):
        return False
    return corrected.boxes is not None or bool(corrected.strokes) or corrected.face_index is not None


def size_note(corrected: Corrected, size: Size) -> str | None:
    """What becomes of corrections in the photo at a size, to be told; None where they stay as they are."""
    if corrected.size in (None, size):
        return None
    is_lost = loses_corrections(corrected, size)
    what = ["boxes of faces"] if corrected.boxes or (is_lost and corrected.boxes is not None) else []
    what += ["strokes of the outline"] if corrected.strokes else []
    what += ["the choice of one face"] if is_lost and corrected.face_index is not None else []
    if not what:
        return None
    (width, height), (new_width, new_height) = corrected.size, size
    was = f"was {width} by {height} pixels when it was worked on and is {new_width} by {new_height} now"
    return f"{was}; {'left out' if is_lost else 'scaled to that'}: {', '.join(what)}"


def _are_alike(one: Size, other: Size) -> bool:
    """Whether two sizes have the same proportions, but for what rounding does to the smaller."""
    small, large = sorted((one, other), key=sum)
    long = 0 if large[0] >= large[1] else 1
    expected = large[1 - long] * small[long] / large[long]
    return abs(expected - small[1 - long]) <= _ROUNDING_PX


def _scaled_box(box: FaceBox, by: tuple[float, float]) -> FaceBox:
    """A box that still has a pixel."""
    centre = (box.x0 + box.x1) / 2 * by[0], (box.y0 + box.y1) / 2 * by[1]
    x, y = max(box.width * by[0], 1.0) / 2, max(box.height * by[1], 1.0) / 2
    return replace(box, x0=centre[0] - x, y0=centre[1] - y, x1=centre[0] + x, y1=centre[1] + y)


def _scaled_stroke(stroke: BrushStroke, by: tuple[float, float]) -> BrushStroke:
    """A stroke within the limits of strokes."""
    from relight_core.pipeline.per_photo.brush import FARTHEST_PX, THINNEST_PX, WIDEST_PX

    def place(part: float, scale: float) -> float:
        return round(min(max(part * scale, -FARTHEST_PX), FARTHEST_PX), _DIGITS)

    radius_px = min(max(stroke.radius_px * (by[0] * by[1]) ** 0.5, THINNEST_PX), WIDEST_PX)
    points = tuple((place(x, by[0]), place(y, by[1])) for x, y in stroke.points)
    return replace(stroke, points=points, radius_px=round(radius_px, _DIGITS))
