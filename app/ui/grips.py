"""The grips of the panels: drag one to move its panel to another edge of the window."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import theme
from app.ui.handles import handle
from app.ui.layout import EDGES, Layout, Rect, arrange
from app.ui.state import EditorState

_LONG_EM, _THICK_EM, _APART_EM = 2.2, 0.22, 0.22
_REACH_EM = 0.3


def draw(state: EditorState, layout: Layout) -> None:
    """Every grip, over the panels; while one is dragged, where its panel would go."""
    for name, rect in layout.parts.items():
        _grip(state, name, rect)


def _grip(state: EditorState, name: str, panel: Rect) -> None:
    em = imgui.get_font_size()
    bar, reach = bar_of(name, panel, em), _REACH_EM * em
    size = imgui.ImVec2(bar.width + 2 * reach, bar.height + 2 * reach)
    with handle(f"grip {name}", bar.x - reach, bar.y - reach, size) as grab:
        if grab.hovered or grab.active:
            imgui.set_mouse_cursor(imgui.MouseCursor_.hand)
        colour = theme.ACCENT if grab.active else theme.TEXT if grab.hovered else theme.TRACK
        x0, y0, x1, y1 = bar.corners
        draw_list = imgui.get_window_draw_list()
        draw_list.add_rect_filled(imgui.ImVec2(x0, y0), imgui.ImVec2(x1, y1), theme.packed(colour), em)
        if grab.twice:
            state.panels = state.panels.across(name)
        elif grab.active or imgui.is_item_deactivated():
            _drag(state, name, imgui.is_item_deactivated())
        else:
            imgui.set_item_tooltip("Drag this panel to the other edge, or double-click.  F9 puts all panels back")


def bar_of(name: str, panel: Rect, em: float) -> Rect:
    """Where a panel's grip is: in the middle of its upper edge; the filmstrip's at its left end."""
    if name == "filmstrip":
        return Rect(
            panel.x + _APART_EM * em, panel.y + (panel.height - _LONG_EM * em) / 2, _THICK_EM * em, _LONG_EM * em
        )
    return Rect(panel.x + (panel.width - _LONG_EM * em) / 2, panel.y + _APART_EM * em, _LONG_EM * em, _THICK_EM * em)


def _drag(state: EditorState, name: str, let_go: bool) -> None:
    if not imgui.internal.is_mouse_drag_past_threshold(0):
        return
    io = imgui.get_io()
    size = io.display_size
    beyond = io.mouse_pos.y > size.y / 2 if name == "filmstrip" else io.mouse_pos.x > size.x / 2
    moved = state.panels.moved(name, EDGES[name][beyond])
    if let_go:
        state.panels = moved
        return
    place = arrange(size.x, size.y, imgui.get_font_size(), moved, state.look.scope != "off").parts[name]
    corner, end = imgui.ImVec2(place.x, place.y), imgui.ImVec2(place.x + place.width, place.y + place.height)
    over = imgui.get_foreground_draw_list()
    over.add_rect_filled(corner, end, theme.packed(theme.ACCENT, 0.18))
    over.add_rect(corner, end, theme.packed(theme.ACCENT), 0.0, 2.0)
