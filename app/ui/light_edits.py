"""Changing the light that is in use: what the panels and the commands do to the state."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from app.ui import brush_edits, face_edits
from app.ui.viewport.box_tools import with_box, without_box
from relight_core.lighting.light_edit import MOST_BOXES, MOST_LEVEL_EV, put_together, taken_apart
from relight_core.lighting.soft_box import SoftBox

if TYPE_CHECKING:
    from app.engine.snapshot import Picture
    from app.engine.sources import RelitLike
    from app.ui.state import EditorState


@dataclass
class AimTool:
    """Placing a lamp by a click on the face.

    Attributes:
        target: what the next click places a lamp for: "highlight", "bright", or "" while the tool is not in use.
        picture: the relit picture whose normals the click reads.
        has_placed: the click, or the drag that it became, has placed a lamp.
        refusal: the message why the last click placed none.
    """

    target: str = ""
    picture: RelitLike | None = None
    has_placed: bool = False
    refusal: str = ""


def meter_light(state: EditorState) -> None:
    """Set the light's level by what a meter reads in it, or leave it as its file says."""
    state.light_edit = replace(state.light_edit, metered=not state.light_edit.metered)


def match_face(state: EditorState, picture: Picture) -> None:
    """Set the light's level so that the lit part of the face in a picture is as bright as in the photo.

    Where another photo or another light is wanted by now, that light's level is left alone.
    """
    if state.photo is None or not picture.opened.shows(state.photo) or not state.light.same_as(picture.light.source):
        return
    stops = picture.light.edit.level_ev + picture.relit.level_as_in_photo_ev(2 * MOST_LEVEL_EV)
    level_ev = min(max(stops, -MOST_LEVEL_EV), MOST_LEVEL_EV)
    state.light_edit = replace(state.light_edit, level_ev=round(level_ev, 2))


def is_adjusted(state: EditorState) -> bool:
    """Whether the light's level, colour or blur are other than the light came with."""
    return replace(state.light_edit, boxes=(), apart=False) != state.light.opening_edit


def reset_adjustments(state: EditorState) -> None:
    """Put level, colour and blur of the light back; its soft boxes stay."""
    lamps = {"boxes": state.light_edit.boxes, "apart": state.light_edit.apart}
    state.light_edit = replace(state.light.opening_edit, **lamps)


def can_undo(state: EditorState) -> bool:
    """Whether there is something that `undo` takes back."""
    return state.brush.painting is not None or state.asking.level is not None or state.history.can_undo


def undo(state: EditorState) -> None:
    """Take back what was begun last: a stroke being painted, a level that its picture has yet to tell, else a step."""
    if state.brush.painting is not None:
        state.brush.painting = None
    elif state.asking.level is not None:
        state.asking.level = None
        state.asking.tell("The light's level stays as it is")
    else:
        state.restore(state.history.undo())


def has_box(state: EditorState) -> bool:
    """Whether a soft box is selected."""
    return 0 <= state.selected_box < len(state.light_edit.boxes)


def put_box(state: EditorState, index: int, box: SoftBox) -> None:
    """Put a soft box into the place of another."""
    state.light_edit = replace(state.light_edit, boxes=with_box(state.light_edit.boxes, index, box))


def tell_full(state: EditorState, delete: str = "one") -> None:
    """Say that there are as many soft boxes as there may be."""
    state.asking.tell(f"A light has at most {MOST_BOXES} soft boxes; delete {delete} first", True)


def switch_box(state: EditorState) -> None:
    """Switch the selected soft box off, or on again."""
    if has_box(state):
        box = state.light_edit.boxes[state.selected_box]
        put_box(state, state.selected_box, replace(box, off=not box.off))


def has_gel(state: EditorState) -> bool:
    """Whether a soft box is selected that has a coloured gel."""
    return has_box(state) and state.light_edit.boxes[state.selected_box].colour is not None


def remove_gel(state: EditorState) -> None:
    """Take the coloured gel off the selected soft box."""
    if has_gel(state):
        put_box(state, state.selected_box, replace(state.light_edit.boxes[state.selected_box], colour=None))


def raise_box(state: EditorState, degrees: float) -> None:
    """Lift the selected soft box, or lower it; at most to straight above or below."""
    if has_box(state):
        box = state.light_edit.boxes[state.selected_box]
        raised = replace(box, elevation_deg=min(max(box.elevation_deg + degrees, -90.0), 90.0))
        put_box(state, state.selected_box, raised)


def delete_box(state: EditorState) -> None:
    """Take the selected soft box away."""
    if has_box(state):
        boxes = without_box(state.light_edit.boxes, state.selected_box)
        state.light_edit, state.selected_box = replace(state.light_edit, boxes=boxes), -1


def delete_boxes(state: EditorState) -> None:
    """Take every soft box away, and let the light itself be as it is without them."""
    state.light_edit, state.selected_box = replace(state.light_edit, boxes=(), base=1.0, apart=False), -1


def switch_aim(state: EditorState, target: str) -> None:
    """Let the next click on the face place a lamp, or not; the other tools over the picture, which come first, go away.

    Args:
        target: as of `AimTool`; the one in use already switches the tool off.
    """
    face_edits.done(state)
    brush_edits.done(state)
    state.aim.target = "" if state.aim.target == target else target


def has_lamps(state: EditorState) -> bool:
    """Whether the light that is wanted is there and has lamps of its own that can be moved."""
    light = state.snapshot.light
    return light is not None and state.light.same_as(light.source) and bool(light.lamps)


def as_it_came(state: EditorState, box: SoftBox) -> SoftBox:
    """A lamp of the light itself as it is in the light; for a soft box that was added, a new one."""
    lamps = state.snapshot.light.lamps if has_lamps(state) else ()
    return next((lamp for lamp in lamps if lamp.name == box.name), SoftBox())


def switch_lamps(state: EditorState) -> None:
    """Make the light's own lamps soft boxes, the strongest of them selected, or put them back."""
    if state.light_edit.apart:
        state.light_edit, state.selected_box = put_together(state.light_edit), -1
        return
    edit = taken_apart(state.light_edit, state.snapshot.light.lamps)
    if len(edit.boxes) > MOST_BOXES:
        tell_full(state, "some")
        return
    lamps = [box.intensity if box.name else -1.0 for box in edit.boxes]
    state.light_edit, state.selected_box = edit, lamps.index(max(lamps))
