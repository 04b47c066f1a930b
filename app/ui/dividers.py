"""The lines between the panels: drag one to resize, double-click it for the first size."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import theme
from app.ui.layout import Divider, Layout
from app.ui.state import EditorState

_REACH = 4.0
_FLAGS = (
    imgui.WindowFlags_.no_decoration
    | imgui.WindowFlags_.no_background
    | imgui.WindowFlags_.no_move
    | imgui.WindowFlags_.no_saved_settings
    | imgui.WindowFlags_.no_nav
)


def draw(state: EditorState, layout: Layout) -> None:
    """Every line, over the panels."""
    for divider in layout.dividers:
        _divider(state, divider)


def _divider(state: EditorState, divider: Divider) -> None:
    em = imgui.get_font_size()
    line = divider.line
    across = line.height > line.width
    reach = _REACH * em / theme.FONT_PX
    grown_x, grown_y = (reach, 0.0) if across else (0.0, reach)
    size = imgui.ImVec2(line.width + 2 * grown_x, line.height + 2 * grown_y)
    imgui.set_next_window_pos(imgui.ImVec2(line.x - grown_x, line.y - grown_y))
    imgui.set_next_window_size(size)
    imgui.push_style_var(imgui.StyleVar_.window_padding, imgui.ImVec2(0.0, 0.0))
    imgui.push_style_var(imgui.StyleVar_.window_min_size, imgui.ImVec2(1.0, 1.0))
    imgui.begin(f"divider {divider.panel}", None, _FLAGS)
    imgui.pop_style_var(2)
    imgui.invisible_button("line", size)
    hovered, active = imgui.is_item_hovered(), imgui.is_item_active()
    if hovered or active:
        imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew if across else imgui.MouseCursor_.resize_ns)
    if hovered and imgui.is_mouse_double_clicked(0):
        imgui.internal.clear_active_id()
        state.panels = state.panels.reset(divider.panel)
    elif active:
        _drag(state, divider, across, em)
    colour = theme.ACCENT if active else theme.FAINT if hovered else theme.LINE
    end = imgui.ImVec2(line.x + line.width, line.y + line.height)
    imgui.get_window_draw_list().add_rect_filled(imgui.ImVec2(line.x, line.y), end, theme.packed(colour))
    imgui.end()


def _drag(state: EditorState, divider: Divider, across: bool, em: float) -> None:
    delta = imgui.get_io().mouse_delta
    moved = divider.sign * (delta.x if across else delta.y) / em
    if moved:
        state.panels = state.panels.dragged(divider.panel, divider.size_em + moved)
