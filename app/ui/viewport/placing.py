"""Placing a lamp by a click on the face; dragging moves the lamp along."""

from __future__ import annotations

from collections.abc import Sequence

from imgui_bundle import imgui

from app.ui import light_edits
from app.ui.layout import Rect
from app.ui.news import put_message_away
from app.ui.state import EditorState
from app.ui.viewport.box_tools import aimed, lamp_for_spot
from app.ui.viewport.panes import LIGHTS, Arrangement
from app.ui.viewport.view import photo_point
from app.ui.viewport.viewport_notes import note, note_width, titles_foot_em
from relight_core.face.find import FaceBox
from relight_core.pipeline.results.layers import channel_view_of

_WORDS = {
    "highlight": "Click where the highlight should be",
    "bright": "Click where the face should be brightest",
}


def drag(state: EditorState, arranged: Arrangement, at: tuple[float, float]) -> bool:
    """Follow the mouse on the viewport's item; True while it belongs to the lamp and moves no picture.

    Args:
        at: the mouse in the viewport, in framebuffer pixels.
    """
    if not state.aim.target or arranged.main is None or arranged.main.name in LIGHTS:
        return False
    if imgui.is_item_hovered():
        imgui.set_mouse_cursor(imgui.MouseCursor_.hand)
    if imgui.is_item_active():
        state.hand_on_control = True
        pressed = imgui.is_item_activated()
        placed = _place(state, arranged, at, pressed)
        state.aim.has_placed = placed or (state.aim.has_placed and not pressed)
    elif imgui.is_item_deactivated() and state.aim.has_placed:
        # After a click beside the face the next one may hit it.
        state.aim.target, state.aim.has_placed = "", False
    return imgui.is_item_active() or not imgui.get_io().mouse_wheel


def hint(state: EditorState, arranged: Arrangement, rect: Rect) -> None:
    """What the next click does; once the tool is left, the message about a click that missed goes as well.

    Where cards are at the viewport's top it lies above the titles at its foot.
    """
    if not state.aim.target:
        _put_refusal_away(state)
        return
    em = imgui.get_font_size()
    words = f"{_WORDS[state.aim.target]}.  Esc to leave it"
    covered = state.look.probe or state.look.timings
    down = rect.height - (titles_foot_em(state, arranged.main, rect) + 2.0) * em if covered else em
    note(words, rect.x + (rect.width - note_width(words)) / 2, rect.y + down)


def _no_face_at(faces: Sequence[FaceBox], only: int | None, x: float, y: float) -> str:
    """Why no lamp can be placed for a point of the photo: with several faces the normals of only one are available.

    Args:
        only: the face that is relit alone; None if all are, and then it is the first, which is the largest.
    """
    at_hand = only or 0
    for index, face in enumerate(faces):
        if index != at_hand and face.x0 <= x < face.x1 and face.y0 <= y < face.y1:
            return f"Choose this face alone first: {index + 1}, under Effects"
    return "There is no face there; click on skin, hair or clothes"


def _place(state: EditorState, arranged: Arrangement, at: tuple[float, float], pressed: bool) -> bool:
    """Place a lamp for the spot under the mouse, or show why that is not possible; whether one was placed."""
    picture = state.snapshot.picture
    pane = arranged.pane_at(at[0]) or arranged.main
    if picture is None or pane.name in LIGHTS:
        return False
    if state.snapshot.picture_in_sight is None:
        if pressed:
            _refuse(state, "This face is still being relit; click once its picture is there")
        return False
    if "normal" in picture.relit.channels:
        # While the hand moves only visible channels are made; the normals of before remain valid.
        state.aim.picture = picture.relit
    if state.aim.picture is None:
        return False
    x, y = photo_point(pane.placement, pane.frame, at)
    direction = lamp_for_spot(state.aim.picture.channels, channel_view_of(state.aim.picture), x, y, state.aim.target)
    if direction is None:
        if pressed:
            only = state.snapshot.opened.source.face_index
            _refuse(state, _no_face_at(state.snapshot.faces, only, x, y))
        return False
    edit, index = aimed(state.light_edit, state.selected_box, direction, state.edit.yaw_deg)
    if index < 0:
        light_edits.tell_full(state)
        return False
    state.light_edit, state.selected_box = edit, index
    _put_refusal_away(state)
    return True


def _refuse(state: EditorState, why: str) -> None:
    """Show why a click places no lamp, until one does or the tool is left."""
    state.asking.tell(why)
    state.aim.refusal = why


def _put_refusal_away(state: EditorState) -> None:
    if (message := state.message()) is not None and message.text == state.aim.refusal:
        put_message_away(state)
