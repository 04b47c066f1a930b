"""A change of light that the engine may still refuse, and what to return to then."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from app.engine.sources import LightSource
from relight_core.lighting.light_edit import MOST_BOXES, LightEdit

if TYPE_CHECKING:
    from app.ui.state import EditorState


@dataclass(frozen=True)
class SetLight:
    """A light with all its settings.

    Attributes:
        light: the wish for it.
        edit: level, colour, blur and soft boxes.
        yaw_deg: its rotation.
    """

    light: LightSource
    edit: LightEdit
    yaw_deg: float


@dataclass(frozen=True)
class LightWish:
    """A change of light that may still be refused.

    Attributes:
        before: the light that was set before.
        asked: the light that was asked for, with its settings at that moment.
    """

    before: SetLight
    asked: SetLight

    def taken_back(self, now: SetLight) -> SetLight:
        """The light before, with the soft boxes and the rotation that the user has set since.

        Args:
            now: the light that was asked for, as it is set by now.
        """
        turned = now.yaw_deg != self.asked.yaw_deg
        yaw_deg = now.yaw_deg if turned else self.before.yaw_deg
        return SetLight(self.before.light, self._edit_taken_back(now.edit), yaw_deg)

    def _edit_taken_back(self, now: LightEdit) -> LightEdit:
        before, asked = self.before.edit, self.asked.edit
        if asked == before and self.asked.light.same_as(self.before.light):
            # The same light was asked for, to read its file again.
            return now
        if now.added == asked.added:
            return before
        if asked.added == before.added:
            return with_added(before, now)
        # The soft boxes that came with the other light go with it.
        new = (box for box in now.added_boxes if box not in asked.boxes)
        return replace(before, boxes=(*before.boxes, *new)[:MOST_BOXES])


def light_that_stays(state: EditorState) -> SetLight:
    """The light as it is set; while another one is loading, the light to return to if that one is refused."""
    now, change = _as_set(state), state.light_wish
    opened = state.snapshot.light
    is_open = opened is not None and opened.source is state.light
    if change is None or change.asked.light is not state.light or is_open:
        return now
    return change.taken_back(now)


def note_light_wish(state: EditorState, before: SetLight) -> None:
    """Note that another light has been asked for and is set now.

    Args:
        before: what `light_that_stays` gave before anything was set.
    """
    state.light_wish = LightWish(before, _as_set(state))


def with_added(edit: LightEdit, later: LightEdit) -> LightEdit:
    """A light's settings with its own lamps, and with the soft boxes (and their room) that `later` has added."""
    lamps, added = (box for box in edit.boxes if box.name), later.added
    boxes = (*lamps, *added.boxes)[:MOST_BOXES]
    return replace(edit, boxes=boxes, base=added.base if added.boxes else edit.base)


def _as_set(state: EditorState) -> SetLight:
    return SetLight(state.light, state.light_edit, state.edit.yaw_deg)
