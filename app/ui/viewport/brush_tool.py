"""The brush over the picture: what it paints is person, or is not; and the outline as it is now."""

from __future__ import annotations

import math

import numpy as np
from imgui_bundle import imgui

from app.engine.snapshot import Picture
from app.ui import brush_edits, theme
from app.ui.layout import Rect
from app.ui.state import EditorState
from app.ui.viewport.panes import Arrangement, Pane
from app.ui.viewport.photo_panes import drawn_over, in_the_window, pane_under
from app.ui.viewport.view import photo_point
from relight_core.pipeline.per_photo.brush import BrushStroke

_ADDED: theme.Colour = (0.35, 0.85, 0.45, 1.0)
_TAKEN: theme.Colour = (0.95, 0.35, 0.32, 1.0)
_PAINT_OPACITY = 0.4
_LINE_EM, _UNDER_LINE_EM = 0.1, 0.22
Point = tuple[float, float]


def drag(state: EditorState, arranged: Arrangement, at: Point, scale: float) -> bool:
    """Follow the mouse on the viewport's item; True while it belongs to the brush and moves no picture.

    Args:
        at: the mouse in the viewport, in framebuffer pixels.
    """
    tool = state.brush
    pane = pane_under(arranged, at, tool.pane if tool.painting else None)
    if not tool.is_open or pane is None:
        tool.painting = None
        return False
    active, io = imgui.is_item_active(), imgui.get_io()
    point = photo_point(pane.placement, pane.frame, at)
    if imgui.is_item_activated():
        radius_px = tool.radius_em * imgui.get_font_size() * scale / pane.placement.zoom
        brush_edits.begin(state, point, radius_px, tool.adds != io.key_alt)
        tool.pane = arranged.panes.index(pane)
    if tool.painting is not None and active:
        state.hand_on_control = True
        brush_edits.move(state, point)
    elif tool.painting is not None:
        brush_edits.lift(state)
    return active or not io.mouse_wheel


def draw(state: EditorState, arranged: Arrangement, rect: Rect, scale: float) -> None:
    """The outline, what is being painted or not yet in the picture, and the brush under the mouse."""
    tool = state.brush
    if not tool.is_open:
        return
    lines, fresh = _outline(state), _fresh(state)
    for pane in drawn_over(arranged, rect, scale):
        for line in lines:
            _outline_line(in_the_window(line, pane, rect, scale))
        for stroke in fresh:
            _paint(stroke, pane, rect, scale)
    _brush_under_the_mouse(state, rect, scale)


def _outline(state: EditorState) -> list[np.ndarray]:
    """The outline in the picture in sight; the last one, while that of a new picture is being drawn."""
    picture, tool = _picture(state), state.brush
    if picture is not None and picture.outline is not None:
        tool.outline = picture.outline
    return tool.outline


def _picture(state: EditorState) -> Picture | None:
    """The picture in sight, if it is one of the photo that is open and not of the one before."""
    picture, opened = state.snapshot.picture, state.snapshot.opened
    return picture if picture is not None and opened is not None and picture.opened.photo is opened.photo else None


def _fresh(state: EditorState) -> list[BrushStroke]:
    """The strokes that are not in the picture in sight yet."""
    picture, tool = _picture(state), state.brush
    done = picture.opened.source.strokes if picture is not None and not picture.is_stale else tool.shown
    tool.shown = done
    wished = state.photo.strokes if state.photo is not None else ()
    fresh = wished[len(done) :] if wished[: len(done)] == done else ()
    return [*fresh, *((tool.painting,) if tool.painting else ())]


def _outline_line(line: list[imgui.ImVec2]) -> None:
    em, draw_list = imgui.get_font_size(), imgui.get_window_draw_list()
    draw_list.add_polyline(line, theme.packed(theme.SHADE, 0.55), _UNDER_LINE_EM * em, imgui.ImDrawFlags_.closed)
    draw_list.add_polyline(line, theme.packed(theme.ACCENT), _LINE_EM * em, imgui.ImDrawFlags_.closed)


def _paint(stroke: BrushStroke, pane: Pane, rect: Rect, scale: float) -> None:
    """A stroke, so that one sees through it."""
    draw_list = imgui.get_window_draw_list()
    colour = theme.packed(_ADDED if stroke.adds else _TAKEN, _PAINT_OPACITY)
    radius = stroke.radius_px * pane.placement.zoom / scale
    points = in_the_window(stroke.points, pane, rect, scale)
    if len(points) == 1:
        draw_list.add_circle_filled(points[0], radius, colour)
    else:
        draw_list.add_polyline(points, colour, 2 * radius, 0)
        for end, inward in ((points[0], points[1]), (points[-1], points[-2])):
            outward = math.atan2(end.y - inward.y, end.x - inward.x)
            draw_list.path_arc_to(end, radius, outward - math.pi / 2, outward + math.pi / 2)
            draw_list.path_fill_convex(colour)


def _brush_under_the_mouse(state: EditorState, rect: Rect, scale: float) -> None:
    """A ring as large as the brush, while it is over the picture."""
    tool, pointer = state.brush, state.look.pointer_px
    if pointer is None:
        return
    em, draw_list = imgui.get_font_size(), imgui.get_window_draw_list()
    adds = tool.painting.adds if tool.painting else tool.adds != imgui.get_io().key_alt
    centre = imgui.ImVec2(rect.x + pointer[0] / scale, rect.y + pointer[1] / scale)
    radius = tool.radius_em * em
    draw_list.add_circle(centre, radius, theme.packed(theme.SHADE, 0.55), 0, _UNDER_LINE_EM * em)
    draw_list.add_circle(centre, radius, theme.packed(_ADDED if adds else _TAKEN), 0, _LINE_EM * em)
