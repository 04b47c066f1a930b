"""The steps that can be undone, newest last; a click goes to any of them."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import theme, widgets
from app.ui.state import EditorState

_ROWS = 7


def draw(state: EditorState, fonts: theme.Fonts) -> None:
    """The heading, undo and redo, and the list, inside a panel."""
    widgets.heading(fonts, "History")
    history = state.history
    half = (imgui.get_content_region_avail().x - 4.0) / 2
    imgui.begin_disabled(not history.can_undo)
    if imgui.button("Undo", imgui.ImVec2(half, 0.0)):
        state.restore(history.undo())
    imgui.end_disabled()
    imgui.set_item_tooltip("Take the last step back.  Ctrl + Z")
    imgui.same_line(0.0, 4.0)
    imgui.begin_disabled(not history.can_redo)
    if imgui.button("Redo", imgui.ImVec2(half, 0.0)):
        state.restore(history.redo())
    imgui.end_disabled()
    imgui.set_item_tooltip("Do again what was taken back.  Ctrl + Shift + Z")
    _list(state)


def _list(state: EditorState) -> None:
    history = state.history
    if not history.steps:
        return
    row = imgui.get_text_line_height_with_spacing()
    height = row * min(len(history.steps), _ROWS) + 2.0
    imgui.begin_child("steps", imgui.ImVec2(0.0, height))
    for index, step in enumerate(history.steps):
        undone = index > history.at
        colour = theme.FAINT if undone else theme.ACCENT if index == history.at else theme.TEXT
        imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*colour))
        label = widgets.shortened(step.name, imgui.get_content_region_avail().x)
        clicked, _ = imgui.selectable(f"{label}##{index}", False)
        imgui.pop_style_color()
        imgui.set_item_tooltip("Click to go back to this step." if not undone else "Undone; click to do it again.")
        if clicked and index != history.at:
            state.restore(history.go(index))
    if state.history_seen != (len(history.steps), history.at):
        state.history_seen = (len(history.steps), history.at)
        imgui.set_scroll_y(max(0.0, (history.at - _ROWS + 2) * row))
    imgui.end_child()
