"""The boxes of the faces over the picture: drag them, drag their edges, drag beside them for one more."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import face_edits, theme
from app.ui.channels import WHOLE_PHOTO
from app.ui.layout import Rect
from app.ui.state import EditorState
from app.ui.viewport import wipe
from app.ui.viewport.face_boxes import FaceGrab, corners, dragged, grab
from app.ui.viewport.panes import Arrangement, Pane, arrange_panes
from app.ui.viewport.photo_panes import drawn_over, in_the_window, pane_under
from app.ui.viewport.view import photo_point
from app.ui.viewport.viewport_notes import note
from relight_core.face.find import FaceBox

_REACH_EM, _KNOB_EM = 0.5, 0.3
_LEAST_EM, _LEAST_PHOTO_PX = 0.8, 8.0
"""No box becomes smaller than this on the screen, nor in the photo."""

_CLOSED = imgui.ImDrawFlags_.closed
Point = tuple[float, float]


def drag(state: EditorState, arranged: Arrangement, at: Point, scale: float) -> bool:
    """Follow the mouse on the viewport's item; True while it belongs to the boxes and moves no picture.

    Args:
        at: the mouse in the viewport, in framebuffer pixels.
    """
    tool = state.faces
    pane = pane_under(arranged, at, tool.pane if tool.held else None)
    if not tool.is_open or pane is None:
        tool.let_go()
        return False
    active, io = imgui.is_item_active(), imgui.get_io()
    em_px = imgui.get_font_size() * scale / pane.placement.zoom
    point = photo_point(pane.placement, pane.frame, at)
    boxes = face_edits.wished_boxes(state)
    under = grab(boxes, tool.selected, point, _REACH_EM * em_px)
    # Edges come before the wipe's line, which comes before the boxes it crosses.
    on_the_line = under.kind != "resize" and wipe.is_near(arranged, at, scale)
    if tool.held is None and (state.look.wipe_held or on_the_line):
        wipe.drag(state, arranged, at, scale)
        return active or not io.mouse_wheel
    if imgui.is_item_activated():
        tool.held, tool.pane = under, arranged.panes.index(pane)
        tool.selected = -1 if under.kind == "draw" else under.index
    if tool.held is not None and active:
        _follow(state, boxes, point, em_px)
    elif tool.held is not None:
        face_edits.finish_drag(state)
    if imgui.is_item_hovered() or active:
        _show_cursor(tool.held or under)
    return active or not io.mouse_wheel


def draw(state: EditorState, arranged: Arrangement, rect: Rect, scale: float) -> None:
    """The boxes, while they can be moved or the mouse is on the choice of faces."""
    tool = state.faces
    if not (tool.is_open or state.pointing_at_faces):
        return
    boxes = tool.moving if tool.moving is not None else face_edits.wished_boxes(state)
    only = state.photo.face_index if state.photo else None
    for pane in drawn_over(arranged, rect, scale):
        for index, box in enumerate(boxes):
            if tool.is_open and index == _in_hand(tool, boxes):
                _box(box, index, pane, rect, scale, theme.ACCENT, knobs=True)
            else:
                is_relit = only is None or only == index
                _box(box, index, pane, rect, scale, theme.TEXT if is_relit else theme.DIM, knobs=False)


def on_the_screen(state: EditorState, rect: Rect) -> list[tuple[float, float, float, float]]:
    """Left, top, right and bottom of every box as it lies in the window, in each pane that shows the whole photo."""
    scale = imgui.get_io().display_framebuffer_scale.x
    places = []
    for pane in arrange_panes(state, state.look.viewport_px).panes:
        for box in face_edits.wished_boxes(state) if pane.name in WHOLE_PHOTO else ():
            x, y = zip(*((at.x, at.y) for at in in_the_window(corners(box), pane, rect, scale)), strict=True)
            places.append((min(x), min(y), max(x), max(y)))
    return places


def _follow(state: EditorState, boxes: tuple[FaceBox, ...], point: Point, em_px: float) -> None:
    state.hand_on_control = True
    if imgui.internal.is_mouse_drag_past_threshold(0):
        size = state.snapshot.opened.photo.linear.shape[:2]
        least_px = max(_LEAST_EM * em_px, _LEAST_PHOTO_PX)
        state.faces.moving = dragged(boxes, state.faces.held, point, size, least_px)


def _in_hand(tool: face_edits.FaceTool, boxes: tuple[FaceBox, ...]) -> int:
    """The selected box, or the one that is being drawn."""
    return len(boxes) - 1 if tool.moving is not None and tool.held.kind == "draw" else tool.selected


def _show_cursor(held: FaceGrab) -> None:
    if held.kind == "move":
        imgui.set_mouse_cursor(imgui.MouseCursor_.resize_all)
    elif held.kind == "resize":
        across, down = held.side
        cursor = imgui.MouseCursor_.resize_ns if across == 0 else imgui.MouseCursor_.resize_ew
        if across and down:
            cursor = imgui.MouseCursor_.resize_nwse if across == down else imgui.MouseCursor_.resize_nesw
        imgui.set_mouse_cursor(cursor)


def _box(box: FaceBox, index: int, pane: Pane, rect: Rect, scale: float, colour: theme.Colour, *, knobs: bool) -> None:
    """A box with its number; one that is selected with knobs at its corners."""
    em, draw_list = imgui.get_font_size(), imgui.get_window_draw_list()
    edge = in_the_window(corners(box), pane, rect, scale)
    draw_list.add_polyline(edge, theme.packed(theme.SHADE, 0.55), 0.25 * em, _CLOSED)
    draw_list.add_polyline(edge, theme.packed(colour), (0.13 if knobs else 0.1) * em, _CLOSED)
    for corner in edge if knobs else ():
        draw_list.add_circle_filled(corner, _KNOB_EM * em, theme.packed(colour))
    # Above the box, so that of a small face nothing is hidden.
    first = min(edge, key=lambda corner: corner.x + corner.y)
    note(str(index + 1), first.x - 0.1 * em, max(first.y - 1.75 * em, rect.y + 0.2 * em), colour)
