"""The light's panorama: drag it to turn the light, and the soft boxes on it to move and resize them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from imgui_bundle import imgui

from app.ui import light_edits, theme, widgets
from app.ui.pictures import Pictures
from app.ui.state import EditorState
from app.ui.viewport.box_tools import NEW_BOX, Grab, dragged, grab
from app.ui.viewport.viewport_notes import note
from relight_core.lighting.light_edit import MOST_BOXES
from relight_core.lighting.soft_box import box_title, corners, moved_to, outline
from relight_core.lighting.sphere import direction_at, turned, uv_of

FINE = 0.2
"""Factor on the rotation while Shift is held."""

_NEW_AT = ((0.125, 0.3), (0.875, 0.3), (0.375, 0.3), (0.625, 0.3))
"""Where new soft boxes are put, u and v as seen: above at the front left and right, then behind the person."""

_TAKEN_DEG = 20.0
"""A place within this angle of a soft box counts as taken."""

_COMPASS = ((0.0, "front"), (0.25, "left"), (0.5, "behind"), (0.75, "right"), (1.0, "front"))
_REACH_EM, _KNOB_EM, _COMPASS_EM = 0.6, 0.27, 12.0


def draw(state: EditorState, pictures: Pictures) -> None:
    """The panorama as wide as there is room, the boxes on it, and where front and behind are."""
    left = imgui.get_cursor_screen_pos()
    width = imgui.get_content_region_avail().x
    height = width / 2
    imgui.invisible_button("panorama", imgui.ImVec2(width, height))
    io = imgui.get_io()
    u, v = (io.mouse_pos.x - left.x) / width, (io.mouse_pos.y - left.y) / height
    reach_deg = _REACH_EM * imgui.get_font_size() * 180.0 / height
    if imgui.is_item_hovered():
        _hover(state, u, v, reach_deg)
    else:
        state.hint_spent = False
    _drag(state, u, v, io.mouse_delta.x / width, reach_deg)
    _picture(state, pictures, left, width, height)
    for index in range(len(state.light_edit.boxes)):
        _box(state, index, left, width, height)
    _loading_note(state, left, width, height)
    _compass(left, width, height)


def add_box(state: EditorState, u: float, v: float) -> None:
    """A new soft box at a point of the panorama as it is seen, selected."""
    boxes = state.light_edit.boxes
    if len(boxes) >= MOST_BOXES:
        light_edits.tell_full(state)
        return
    box = moved_to(NEW_BOX, turned(direction_at(u, v), -state.edit.yaw_deg))
    state.light_edit = replace(state.light_edit, boxes=(*boxes, box))
    state.selected_box = len(boxes)


def add_next_box(state: EditorState) -> None:
    """Add a soft box at the first of the usual places that is free, or at the first one, and select it."""

    def is_taken(place: tuple[float, float]) -> bool:
        toward = turned(direction_at(*place), -state.edit.yaw_deg)
        return any(box.direction @ toward > np.cos(np.radians(_TAKEN_DEG)) for box in state.light_edit.boxes)

    add_box(state, *next((place for place in _NEW_AT if not is_taken(place)), _NEW_AT[0]))


def _hover(state: EditorState, u: float, v: float, reach_deg: float) -> None:
    """The cursor and tooltip for what is under the mouse; right clicks delete a soft box, double clicks add one."""
    found = grab(state.light_edit.boxes, state.selected_box, u, v, state.edit.yaw_deg, reach_deg)
    turn = imgui.MouseCursor_.resize_ew
    imgui.set_mouse_cursor(
        {"turn": turn, "move": imgui.MouseCursor_.hand, "resize": imgui.MouseCursor_.hand}[found.kind]
    )
    if found.kind != "turn" and imgui.is_mouse_clicked(1):
        state.selected_box = found.index
        light_edits.delete_box(state)
    elif not state.hint_spent:
        _explain(state, found)
    if found.kind == "turn" and imgui.is_mouse_double_clicked(0):
        add_box(state, u, v)
        state.held = None


def _explain(state: EditorState, found: Grab) -> None:
    if found.kind == "turn":
        imgui.set_item_tooltip(
            "Everything around the person: the middle lies behind them, the edges in front.\n"
            "Drag sideways to turn the light, with Shift in small steps.\n"
            "Double-click to add a soft box."
        )
    else:
        title = box_title(state.light_edit.boxes, found.index)
        imgui.set_item_tooltip(f"{title}\nDrag to move it, a corner to resize it. Right-click to delete it.")


def _drag(state: EditorState, u: float, v: float, moved: float, reach_deg: float) -> None:
    """Press, drag and release on the panorama.

    Args:
        moved: by what part of the panorama's width the mouse has moved since the last frame.
    """
    if imgui.is_item_activated() and not imgui.is_mouse_double_clicked(0):
        state.held = grab(state.light_edit.boxes, state.selected_box, u, v, state.edit.yaw_deg, reach_deg)
    if state.held is not None and not state.held.is_among(state.light_edit.boxes):
        state.held = None
    if state.held is not None and state.typing is None:
        # A number that is being typed belongs to the box selected before, which takes it in this frame.
        state.selected_box = state.held.index
    if not imgui.is_item_active() or state.held is None:
        state.held = None
        return
    state.hand_on_control = state.hint_spent = True
    if state.held.kind == "turn":
        state.turn(moved * 360.0 * (FINE if imgui.get_io().key_shift else 1.0))
    elif moved or imgui.get_io().mouse_delta.y:
        box = dragged(state.held, u, v, state.edit.yaw_deg)
        light_edits.put_box(state, state.held.index, box)
        state.held = replace(state.held, box=box)


def _picture(state: EditorState, pictures: Pictures, left: imgui.ImVec2, width: float, height: float) -> None:
    corner = imgui.ImVec2(left.x + width, left.y + height)
    draw_list = imgui.get_window_draw_list()
    shown = pictures.panorama()
    if shown is None:
        draw_list.add_rect_filled(left, corner, theme.packed(theme.RAISED), 4.0)
        return
    turned_by = -state.edit.yaw_deg / 360.0
    uv0, uv1 = imgui.ImVec2(turned_by, 0.0), imgui.ImVec2(turned_by + 1.0, 1.0)
    white = theme.packed((1.0, 1.0, 1.0, 1.0))
    draw_list.add_image(imgui.ImTextureRef(shown.number), left, corner, uv0, uv1, white)


def _box(state: EditorState, index: int, left: imgui.ImVec2, width: float, height: float) -> None:
    """A soft box's outline, and knobs at the corners of the selected one.

    Drawn three times, one panorama's width apart, so that it continues across the seam.
    """
    box, selected = state.light_edit.boxes[index], index == state.selected_box
    draw_list = imgui.get_window_draw_list()
    draw_list.push_clip_rect(left, imgui.ImVec2(left.x + width, left.y + height), True)
    edge = _unwrapped(outline(box), state.edit.yaw_deg)
    colour, em = theme.ACCENT if selected else theme.DIM if box.off else theme.TEXT, imgui.get_font_size()
    for turn in (-1, 0, 1):
        points = [imgui.ImVec2(left.x + (u + turn) * width, left.y + v * height) for u, v in edge]
        draw_list.add_polyline(points, theme.packed((0.0, 0.0, 0.0, 1.0), 0.5), 0.23 * em, 0)
        draw_list.add_polyline(points, theme.packed(colour), (0.13 if selected else 0.08) * em, 0)
        for u, v in _unwrapped(corners(box), state.edit.yaw_deg)[:-1] if selected else ():
            at = imgui.ImVec2(left.x + (u + turn) * width, left.y + v * height)
            draw_list.add_circle_filled(at, _KNOB_EM * em, theme.packed(theme.ACCENT))
    draw_list.pop_clip_rect()


def _unwrapped(directions: np.ndarray, yaw_deg: float) -> list[tuple[float, float]]:
    """A closed line's points (u, v) on the panorama as it is seen, without a jump at the seam.

    Args:
        directions: (n, 3); the first one is repeated at the end.
    """
    points: list[tuple[float, float]] = []
    for direction in [*directions, directions[0]]:
        u, v = uv_of(direction)
        u += yaw_deg / 360.0
        u += round(points[-1][0] - u) if points else -np.floor(u)
        points.append((u, v))
    return points


def _loading_note(state: EditorState, left: imgui.ImVec2, width: float, height: float) -> None:
    """What the engine is doing, while a light that was asked for is not there yet."""
    light, activity, em = state.snapshot.light, state.snapshot.activity, imgui.get_font_size()
    if activity and light is not None and not state.light.same_as(light.source):
        words = widgets.shortened(f"{activity}…", width - 1.8 * em)
        note(words, left.x + 0.4 * em, left.y + height - 1.9 * em)


def _compass(left: imgui.ImVec2, width: float, height: float) -> None:
    draw_list = imgui.get_window_draw_list()
    small = 0.8 * imgui.get_font_size()
    imgui.push_font(None, 0.8 * theme.FONT_PX)
    # In a narrow panel the words between would run into the others.
    for along, word in _COMPASS if width >= _COMPASS_EM * imgui.get_font_size() else _COMPASS[::2]:
        x = left.x + along * width
        word_width = imgui.calc_text_size(word).x
        foot = imgui.ImVec2(x, left.y + height)
        draw_list.add_line(foot, imgui.ImVec2(x, foot.y + 3.0), theme.packed(theme.FAINT))
        at = min(max(x - word_width / 2, left.x), left.x + width - word_width)
        draw_list.add_text(imgui.ImVec2(at, left.y + height + 4.0), theme.packed(theme.DIM), word)
    imgui.pop_font()
    imgui.dummy(imgui.ImVec2(1.0, small + 2.0))
