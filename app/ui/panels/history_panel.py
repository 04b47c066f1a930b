"""The steps that can be undone, newest first; a click goes to any of them."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import light_edits, theme, widgets
from app.ui.panels.groups import Tool, group
from app.ui.state import EditorState

_LEAST_ROWS = 4


def draw(state: EditorState, fonts: theme.Fonts) -> None:
    """The title with undo and redo, and the list, inside a panel."""
    history = state.history
    tools = (
        Tool("Undo", "Take the last step back.  Ctrl + Z", light_edits.can_undo(state)),
        Tool("Redo", "Do again what was taken back.  Ctrl + Shift + Z", history.can_redo),
    )
    last = history.steps[history.at].name if history.steps else ""
    is_open, pressed = group(state, fonts, "history", "History", last, tools)
    if pressed == "Undo":
        light_edits.undo(state)
    elif pressed:
        state.restore(history.redo())
    if is_open:
        _list(state)


def _list(state: EditorState) -> None:
    history = state.history
    if not history.steps:
        return
    row = imgui.get_text_line_height_with_spacing()
    room = imgui.get_content_region_avail().y
    height = max(room, row * min(len(history.steps), _LEAST_ROWS) + 2.0)
    imgui.begin_child("steps", imgui.ImVec2(0.0, height))
    for index, step in reversed(list(enumerate(history.steps))):
        undone = index > history.at
        label, at = widgets.shortened(step.name, imgui.get_content_region_avail().x), imgui.get_cursor_pos()
        clicked, _ = imgui.selectable(f"##{index}", False)
        is_in_force = index == history.at and not history.is_ahead
        back = "This step is in force." if is_in_force else "Click to go back to this step."
        imgui.set_item_tooltip("Undone; click to do it again." if undone else back)
        colour = theme.FAINT if undone else theme.ACCENT if index == history.at else theme.TEXT
        # The name of a photo is in it, and ## would end the name of a control.
        imgui.set_cursor_pos(at)
        imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*colour))
        imgui.text_unformatted(label)
        imgui.pop_style_color()
        if clicked and not is_in_force:
            state.restore(history.go(index))
    if state.history_seen != (len(history.steps), history.at):
        state.history_seen = (len(history.steps), history.at)
        above = len(history.steps) - 1 - history.at
        imgui.set_scroll_y(max(0.0, (above + 2) * row - height))
    imgui.end_child()
