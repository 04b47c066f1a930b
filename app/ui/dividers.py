"""The lines between the panels: drag one to resize, double-click it for the first size."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import theme
from app.ui.handles import handle
from app.ui.layout import Divider, Layout
from app.ui.state import EditorState

_REACH = 4.0


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
    with handle(f"divider {divider.panel}", line.x - grown_x, line.y - grown_y, size) as grab:
        if grab.hovered or grab.active:
            imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew if across else imgui.MouseCursor_.resize_ns)
        if grab.twice:
            state.panels = state.panels.reset(divider.panel)
        elif grab.active:
            _drag(state, divider, across, em)
        colour = theme.ACCENT if grab.active else theme.FAINT if grab.hovered else theme.LINE
        end = imgui.ImVec2(line.x + line.width, line.y + line.height)
        imgui.get_window_draw_list().add_rect_filled(imgui.ImVec2(line.x, line.y), end, theme.packed(colour))


def _drag(state: EditorState, divider: Divider, across: bool, em: float) -> None:
    delta = imgui.get_io().mouse_delta
    moved = divider.sign * (delta.x if across else delta.y) / em
    if moved:
        state.panels = state.panels.dragged(divider.panel, divider.size_em + moved)
