"""Where the light comes from: a lit ball as the camera sees it, in a compass as seen from above."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from imgui_bundle import imgui

from app.ui import theme, widgets
from app.ui.layout import Rect
from app.ui.panels.panorama import FINE
from app.ui.pictures import Pictures
from app.ui.state import EditorState
from relight_core.lighting.environment import Environment
from relight_core.lighting.summary import average_direction

_SIDE_EM, _MARGIN_EM = 4.2, 0.8
_RING = 1.24
_EVEN = 0.12
"""Directions shorter than this say nothing: the light comes from all sides."""

_SECTORS = ("front", "front right", "the right", "behind right", "behind", "behind left", "the left", "front left")


def draw(state: EditorState, pictures: Pictures, rect: Rect, scale: float) -> None:
    """The ball in the viewport's lower left corner; dragging it sideways turns the light, with Shift in small steps."""
    light = state.snapshot.light
    em = imgui.get_font_size()
    side = _SIDE_EM * em
    if not state.look.light_ball or light is None or rect.width < 4 * side:
        return
    shown = pictures.light_ball(max(1, round(side * scale)), state.edit.yaw_deg)
    reach = _RING * side / 2
    x, y = rect.x + _MARGIN_EM * em + reach, rect.y + rect.height - _MARGIN_EM * em - reach
    state.look.ball_at = (x, y)
    _turn_by_dragging(state, x, y, reach)
    draw_list = imgui.get_window_draw_list()
    draw_list.add_circle_filled((x, y), reach + 0.25 * em, theme.packed(theme.SHADE, 0.6), 48)
    widgets.draw_image(shown, x - side / 2, y - side / 2, side, side)
    direction = _direction(light.environment, state.edit.yaw_deg)
    _compass(draw_list, x, y, reach, direction)


def words(direction: np.ndarray) -> str:
    """A direction, (3,) in camera space, as one says it: "From front left, 40° up"."""
    length = float(np.linalg.norm(direction))
    if length < _EVEN:
        return "From all sides"
    right, up, toward = (float(part) / length for part in direction)
    height_deg = math.degrees(math.asin(min(max(up, -1.0), 1.0)))
    if abs(height_deg) > 65.0:
        return "From above" if up > 0 else "From below"
    sector = _SECTORS[round(math.degrees(math.atan2(right, toward)) / 45.0) % 8]
    tall = "" if abs(height_deg) < 7.5 else f", {abs(height_deg):.0f}° {'up' if up > 0 else 'down'}"
    where = "the front" if sector == "front" else sector
    return f"From {where}{tall}"


@lru_cache(maxsize=8)
def _direction(environment: Environment, yaw_deg: float) -> np.ndarray:
    return average_direction(environment, yaw_deg)


def _turn_by_dragging(state: EditorState, x: float, y: float, reach: float) -> None:
    imgui.set_cursor_screen_pos(imgui.ImVec2(x - reach, y - reach))
    imgui.invisible_button("light ball", imgui.ImVec2(2 * reach, 2 * reach))
    if imgui.is_item_active():
        state.hand_on_control = True
        io = imgui.get_io()
        # The near side of the ball follows the hand; on the panorama, which is seen from within, it goes the other way.
        state.turn(-io.mouse_delta.x / (2 * reach) * 180.0 * (FINE if io.key_shift else 1.0))
    if imgui.is_item_hovered() or imgui.is_item_active():
        imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
        state.look.pointer_px = None
    light = state.snapshot.light
    described = words(_direction(light.environment, state.edit.yaw_deg))
    imgui.set_item_tooltip(
        f"{described}.\nThe ring is seen from above, the camera at its foot.\n"
        "Drag to turn the light, with Shift in small steps."
    )


def _compass(draw_list: imgui.ImDrawList, x: float, y: float, reach: float, direction: np.ndarray) -> None:
    """Ring, a tick at each quarter, and a dot on the side the light comes from; the camera is below."""
    draw_list.add_circle((x, y), reach, theme.packed(theme.FAINT), 48, 1.0)
    tick = 0.07 * reach
    for across, down in ((0, 1), (1, 0), (0, -1), (-1, 0)):
        start = (x + across * (reach - tick), y + down * (reach - tick))
        end = (x + across * (reach + tick), y + down * (reach + tick))
        draw_list.add_line(start, end, theme.packed(theme.DIM), 1.5)
    flat = math.hypot(direction[0], direction[2])
    if flat < _EVEN:
        return
    dot = (x + direction[0] / flat * reach, y + direction[2] / flat * reach)
    draw_list.add_circle_filled(dot, 0.13 * reach, theme.packed(theme.SHADE), 24)
    draw_list.add_circle_filled(dot, 0.10 * reach, theme.packed(theme.ACCENT), 24)
