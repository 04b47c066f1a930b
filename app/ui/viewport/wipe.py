"""The wipe's line: drag it sideways; it stays at its place in the picture when one zooms or pans."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import theme
from app.ui.layout import Rect
from app.ui.state import EditorState
from app.ui.viewport.panes import Arrangement

_REACH_EM = 0.6
_KNOB_EM = 0.85


def drag(state: EditorState, arranged: Arrangement, at: tuple[float, float], scale: float) -> bool:
    """Move the line with the mouse, right after the viewport's item; True while the hand is on it."""
    look = state.look
    if arranged.wipe_x is None:
        look.wipe_held = False
        return False
    near = is_near(arranged, at, scale)
    if imgui.is_item_activated():
        look.wipe_held = near
    if not imgui.is_item_active():
        look.wipe_held = False
    if near or look.wipe_held:
        imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
    if near and imgui.is_mouse_double_clicked(0):
        look.wipe_at = 0.5
        return True
    if look.wipe_held and imgui.get_io().mouse_delta.x:
        spot = arranged.main.placement
        look.wipe_at = min(max((at[0] - spot.x) / spot.width, 0.0), 1.0)
    return look.wipe_held


def is_near(arranged: Arrangement, at: tuple[float, float], scale: float) -> bool:
    """Whether the mouse, on the viewport's item, is near enough to the line to take it."""
    reach = _REACH_EM * imgui.get_font_size() * scale
    return arranged.wipe_x is not None and imgui.is_item_hovered() and abs(at[0] - arranged.wipe_x) < reach


def draw(state: EditorState, arranged: Arrangement, rect: Rect, scale: float) -> None:
    """The line and its knob."""
    if arranged.wipe_x is None:
        return
    em = imgui.get_font_size()
    x, middle, radius = rect.x + arranged.wipe_x / scale, rect.y + rect.height / 2, _KNOB_EM * em
    colour = theme.packed(theme.ACCENT if state.look.wipe_held else theme.TEXT)
    shade = theme.packed((0.0, 0.0, 0.0, 1.0), 0.45)
    draw_list = imgui.get_window_draw_list()
    top, bottom = rect.y, rect.y + rect.height
    for width, shown in ((0.2 * em, shade), (0.08 * em, colour)):
        draw_list.add_line((x, top), (x, middle - radius), shown, width)
        draw_list.add_line((x, middle + radius), (x, bottom), shown, width)
    draw_list.add_circle_filled((x, middle), radius, theme.packed(theme.SHADE, 0.72), 32)
    draw_list.add_circle((x, middle), radius, colour, 32, 0.1 * em)
    for side in (-1.0, 1.0):
        tip, base, half = x + side * 0.62 * radius, x + side * 0.2 * radius, 0.36 * radius
        draw_list.add_triangle_filled((tip, middle), (base, middle - half), (base, middle + half), colour)
