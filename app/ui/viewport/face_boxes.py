"""Boxes of faces under the mouse: what a press means and what a drag does. Positions are in photo pixels."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from relight_core.face.find import FaceBox

_LARGEST_SHARE = 2.0
"""A box may be this many times as large as the photo's longer side: faces may fill a photo and reach beyond it."""

_ON_THE_PHOTO = 0.25
"""At least this share of a box's width, and of its height, lies on the photo: its edge may cut through a face."""

_MIDDLE = 0.5
"""This share of a box can always be taken to move it, however small it is on the screen."""

Point = tuple[float, float]


@dataclass(frozen=True)
class FaceGrab:
    """What the mouse took hold of.

    Attributes:
        kind: "move", "resize" or "draw".
        index: of the box; for "draw" the one it will have.
        box: as it was then; for "draw" None.
        side: for "resize" which edges follow, -1, 0 or 1 across and down, seen from the face.
        x, y: from the mouse to the box's centre for "move", to the edges for "resize" (seen from the face); where
            the mouse is for "draw".
    """

    kind: str
    index: int
    box: FaceBox | None = None
    side: tuple[int, int] = (0, 0)
    x: float = 0.0
    y: float = 0.0


def grab(boxes: tuple[FaceBox, ...], selected: int, at: Point, reach_px: float) -> FaceGrab:
    """What a press at a point of the photo takes hold of: an edge or corner of a box, a box, or room for a new one.

    The selected box comes first, then the smallest, so that one inside another can be had.

    Args:
        selected: index of the selected box, or -1.
        reach_px: how near an edge counts.
    """
    order = sorted(range(len(boxes)), key=lambda index: (index != selected, boxes[index].width))
    for index in order:
        found = _grab_of(boxes[index], index, at, reach_px)
        if found is not None:
            return found
    return FaceGrab("draw", len(boxes), None, (0, 0), *at)


def dragged(
    boxes: tuple[FaceBox, ...], held: FaceGrab, at: Point, size: tuple[int, int], least_px: float
) -> tuple[FaceBox, ...]:
    """The boxes after the mouse has moved to a point while it holds one.

    Boxes keep their proportions and how the head leans; a new one is square and upright. A quarter of each stays on the
    photo.

    Args:
        boxes: as they were when the mouse took hold.
        size: of the photo, height and width.
        least_px: no box becomes smaller; a new one that would be, or would lie beside the photo, is none yet.
    """
    if held.kind == "draw":
        box = _drawn((held.x, held.y), at, size)
        return boxes if box.width < least_px or _kept_on(box, size) != box else (*boxes, box)
    if held.kind == "move":
        box = _about(held.box, (at[0] + held.x, at[1] + held.y))
    else:
        box = _resized(held, at, size, least_px)
    return (*boxes[: held.index], _kept_on(box, size), *boxes[held.index + 1 :])


def corners(box: FaceBox) -> list[Point]:
    """The corners of a box as the face leans: top left, top right, bottom right, bottom left, seen from the face."""
    half_x, half_y = box.width / 2, box.height / 2
    return [_to_photo(box, (x * half_x, y * half_y)) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


def _grab_of(box: FaceBox, index: int, at: Point, reach_px: float) -> FaceGrab | None:
    x, y = _from_photo(box, at)
    half_x, half_y = box.width / 2, box.height / 2
    if abs(x) > half_x + reach_px or abs(y) > half_y + reach_px:
        return None
    side = _side(x, half_x, reach_px), _side(y, half_y, reach_px)
    if side == (0, 0):
        centre = _centre(box)
        return FaceGrab("move", index, box, side, centre[0] - at[0], centre[1] - at[1])
    return FaceGrab("resize", index, box, side, side[0] * half_x - x, side[1] * half_y - y)


def _side(along: float, half: float, reach_px: float) -> int:
    """Which of two opposite edges is near: -1, 1, or 0 for neither."""
    inward = min(reach_px, (1.0 - _MIDDLE) * half)
    return 0 if abs(along) < half - inward else int(math.copysign(1, along))


def _drawn(start: Point, at: Point, size: tuple[int, int]) -> FaceBox:
    x, y = start
    across, down = at[0] - x, at[1] - y
    side = min(max(abs(across), abs(down)), _LARGEST_SHARE * max(size))
    x1, y1 = x + math.copysign(side, across), y + math.copysign(side, down)
    return FaceBox(min(x, x1), min(y, y1), max(x, x1), max(y, y1))


def _resized(held: FaceGrab, at: Point, size: tuple[int, int], least_px: float) -> FaceBox:
    """The box with the edges that are held under the mouse; the corner or edge opposite stays where it is."""
    box, (side_x, side_y) = held.box, held.side
    x, y = _from_photo(box, at)
    half_x, half_y = box.width / 2, box.height / 2
    wanted = []
    if side_x:
        wanted.append(((x + held.x) * side_x + half_x) / box.width)
    if side_y:
        wanted.append(((y + held.y) * side_y + half_y) / box.height)
    smaller, larger = min(box.width, box.height), max(box.width, box.height)
    scale = min(max(*wanted, least_px / smaller, 0.0), _LARGEST_SHARE * max(size) / larger)
    moved = (scale - 1.0) * side_x * half_x, (scale - 1.0) * side_y * half_y
    half_x, half_y = half_x * scale, half_y * scale
    grown = replace(box, x0=-half_x, y0=-half_y, x1=half_x, y1=half_y)
    return _about(grown, _to_photo(box, moved))


def _kept_on(box: FaceBox, size: tuple[int, int]) -> FaceBox:
    """The box moved so far that enough of it lies on the photo."""
    (x, y), (height, width) = _centre(box), size
    beyond_x, beyond_y = ((0.5 - _ON_THE_PHOTO) * side for side in (box.width, box.height))
    inside = min(max(x, -beyond_x), width + beyond_x), min(max(y, -beyond_y), height + beyond_y)
    return box if inside == (x, y) else _about(box, inside)


def _about(box: FaceBox, centre: Point) -> FaceBox:
    half_x, half_y = box.width / 2, box.height / 2
    x, y = centre
    return replace(box, x0=x - half_x, y0=y - half_y, x1=x + half_x, y1=y + half_y)


def _centre(box: FaceBox) -> Point:
    return (box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2


def _from_photo(box: FaceBox, at: Point) -> Point:
    """A point of the photo from the box's middle, seen as the face is: across and down."""
    cosine, sine = math.cos(math.radians(box.roll_deg)), math.sin(math.radians(box.roll_deg))
    centre = _centre(box)
    x, y = at[0] - centre[0], at[1] - centre[1]
    return cosine * x - sine * y, sine * x + cosine * y


def _to_photo(box: FaceBox, at: Point) -> Point:
    cosine, sine = math.cos(math.radians(box.roll_deg)), math.sin(math.radians(box.roll_deg))
    centre = _centre(box)
    return centre[0] + cosine * at[0] + sine * at[1], centre[1] - sine * at[0] + cosine * at[1]
