"""Soft boxes under the mouse: hit testing, dragging, and placing a lamp for a spot on the face.

Positions on the panorama are u and v of the picture as it is seen, turned by the light's yaw.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from relight_core.face.crop import Crop
from relight_core.lighting.light_edit import MOST_BOXES, LightEdit
from relight_core.lighting.soft_box import SoftBox, contains, corners, lamp_direction, moved_to, resized_to
from relight_core.lighting.sphere import direction_at, turned, uv_of
from relight_core.pipeline.results.channels import unrolled

NEW_BOX = SoftBox(intensity=0.6)
"""Weaker than the light that it is added to, so that skin does not clip at once."""

_PATCH = 0.012
"""Half the side of the patch of normals that is averaged, as a share of the channel's side."""


@dataclass(frozen=True)
class Grab:
    """What the mouse holds on the panorama.

    Attributes:
        kind: "turn" for the panorama itself, "move" or "resize" for a soft box.
        index: of the box; -1 for "turn".
        du, dv: offset from the mouse to the box's centre for "move", to the corner for "resize".
        box: the soft box as it is now; None for "turn".
    """

    kind: str
    index: int = -1
    du: float = 0.0
    dv: float = 0.0
    box: SoftBox | None = None

    def is_among(self, boxes: tuple[SoftBox, ...]) -> bool:
        """Whether what is held still exists: undo, a key, or a refused light may have removed it."""
        return self.box is None or boxes[self.index : self.index + 1] == (self.box,)


def grab(boxes: tuple[SoftBox, ...], selected: int, u: float, v: float, yaw_deg: float, reach_deg: float) -> Grab:
    """What a press at a point of the panorama grabs: a corner, a box, or the panorama itself.

    Only the selected box can be grabbed by its corners. A box can be moved by its area and by the surroundings of its
    centre, so that a very small one, such as a sun, can be grabbed too. Of overlapping boxes the selected one is
    preferred, then the newest.

    Args:
        selected: index of the selected box, or -1.
        u, v: the point on the panorama as it is seen.
        reach_deg: how near a corner has to be, in degrees of the panorama as drawn; a centre has to be half as near.
    """
    u = u - yaw_deg / 360.0
    direction = direction_at(u, v)
    in_middle = [_apart_deg(box.direction, u, v) <= reach_deg / 2 for box in boxes]
    if 0 <= selected < len(boxes) and not in_middle[selected]:
        corner = min(corners(boxes[selected]), key=lambda corner: _apart_deg(corner, u, v))
        if _apart_deg(corner, u, v) <= reach_deg:
            return Grab("resize", selected, *_between(u, v, corner), boxes[selected])
    order = sorted(range(len(boxes)), key=lambda index: (index == selected, index), reverse=True)
    for held in (in_middle, [contains(box, direction) for box in boxes]):
        for index in order:
            if held[index]:
                return Grab("move", index, *_between(u, v, boxes[index].direction), boxes[index])
    return Grab("turn")


def _between(u: float, v: float, direction: np.ndarray) -> tuple[float, float]:
    """The offset (u, v) from a point of the panorama to a direction, the shorter way round."""
    its_u, its_v = uv_of(direction)
    return (its_u - u + 0.5) % 1.0 - 0.5, its_v - v


def _apart_deg(direction: np.ndarray, u: float, v: float) -> float:
    """How far a direction lies from a point of the panorama as it is drawn, with 360 degrees to its width."""
    du, dv = _between(u, v, direction)
    return float(np.hypot(du * 360.0, dv * 180.0))


def dragged(held: Grab, u: float, v: float, yaw_deg: float) -> SoftBox:
    """The soft box that is held, after the mouse has moved to a point."""
    to = direction_at(u - yaw_deg / 360.0 + held.du, min(max(v + held.dv, 0.0), 1.0))
    return moved_to(held.box, to) if held.kind == "move" else resized_to(held.box, to)


def with_box(boxes: tuple[SoftBox, ...], index: int, box: SoftBox) -> tuple[SoftBox, ...]:
    """The boxes with one replaced."""
    return (*boxes[:index], box, *boxes[index + 1 :])


def without_box(boxes: tuple[SoftBox, ...], index: int) -> tuple[SoftBox, ...]:
    """The boxes without one."""
    return (*boxes[:index], *boxes[index + 1 :])


def aimed(edit: LightEdit, selected: int, direction: np.ndarray, yaw_deg: float) -> tuple[LightEdit, int]:
    """Put the selected box, or a new one where none is selected, into a direction.

    Args:
        direction: (3,) from the face toward the lamp, camera space.
        yaw_deg: the light's turn.

    Returns:
        The edit and the index of the box; unchanged and -1 where there are as many boxes as there may be.
    """
    inside = turned(direction, -yaw_deg)
    if 0 <= selected < len(edit.boxes):
        moved = moved_to(edit.boxes[selected], inside)
        return replace(edit, boxes=with_box(edit.boxes, selected, moved)), selected
    if len(edit.boxes) >= MOST_BOXES:
        return edit, -1
    return replace(edit, boxes=(*edit.boxes, moved_to(NEW_BOX, inside))), len(edit.boxes)


def lamp_for_spot(
    channels: dict[str, np.ndarray], view: Crop | None, x: float, y: float, aim: str
) -> np.ndarray | None:
    """The direction of a lamp that makes a spot of the person brightest, or puts a highlight there.

    The normal is averaged over a small patch, which reduces the network's noise.

    Args:
        channels: a Relit's, of which "normal" and "parsing" are read.
        view: where the channels lie in the photo.
        x, y: the spot, in photo pixels.
        aim: "bright" or "highlight".

    Returns:
        (3,) unit vector in camera space toward the lamp, or None if there is no person at the spot.
    """
    normal, labels = channels.get("normal"), channels.get("parsing")
    if normal is None or labels is None or view is None:
        return None
    size = normal.shape[0]
    column, row = (int(position) for position in np.floor(view.from_photo(np.array([x, y]), size)))
    if not (0 <= row < size and 0 <= column < size) or labels[row, column] == 0:
        return None
    reach = max(1, round(_PATCH * size))
    patch = (slice(max(0, row - reach), row + reach + 1), slice(max(0, column - reach), column + reach + 1))
    mean = normal[patch][labels[patch] != 0].mean(axis=0, dtype=np.float64)
    mean = unrolled(mean, view.roll_deg)
    return lamp_direction(mean, aim) if np.linalg.norm(mean) > 1e-6 else None
