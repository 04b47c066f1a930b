"""The command palette: type a few letters of what you want to do, Enter does it."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import theme
from app.ui.actions.action import Action, matching
from app.ui.actions.action_table import ACTIONS
from app.ui.actions.answer_actions import answer_actions
from app.ui.actions.light_actions import light_actions
from app.ui.actions.setting_actions import setting_actions
from app.ui.layout import Rect
from app.ui.light_list import Shelf
from app.ui.state import EditorState

_WIDTH_EM, _ROWS = 34.0, 12
_TOP = 0.12
"""Share of the window's height above it."""


def draw(state: EditorState, shelf: Shelf, window: Rect) -> None:
    """The palette over the window's upper middle, while it is open."""
    look = state.look
    if not look.palette:
        return
    em = imgui.get_font_size()
    width = min(_WIDTH_EM * em, window.width - 2 * em)
    imgui.set_next_window_pos(imgui.ImVec2(window.x + (window.width - width) / 2, window.y + _TOP * window.height))
    imgui.set_next_window_size(imgui.ImVec2(width, 0.0))
    imgui.set_next_window_focus()
    flags = imgui.WindowFlags_.no_decoration | imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_nav
    imgui.push_style_color(imgui.Col_.window_bg, imgui.ImVec4(0.10, 0.10, 0.10, 0.99))
    imgui.push_style_var(imgui.StyleVar_.window_border_size, 1.0)
    imgui.push_style_var(imgui.StyleVar_.window_rounding, 0.5 * em)
    imgui.begin("palette", None, flags)
    imgui.pop_style_var(2)
    imgui.pop_style_color()
    found = _typing(state, shelf)
    _rows(state, found, window)
    _keys(state, found)
    imgui.end()


def _typing(state: EditorState, shelf: Shelf) -> list[Action]:
    look = state.look
    imgui.set_next_item_width(-1.0)
    if not imgui.is_any_item_active():
        imgui.set_keyboard_focus_here()
    changed, look.palette_text = imgui.input_text_with_hint("##command", "What do you want to do?", look.palette_text)
    if changed:
        look.palette_row = 0
    every = (*answer_actions(state), *ACTIONS, *setting_actions(state), *light_actions(state, shelf))
    found = matching(every, look.palette_text)
    look.palette_row = min(max(look.palette_row, 0), max(len(found) - 1, 0))
    return found


def _rows(state: EditorState, found: list[Action], window: Rect) -> None:
    if not found:
        imgui.text_disabled("Nothing of that name.")
        return
    line = imgui.get_text_line_height_with_spacing()
    # Above them is the line that is typed in, below them the chosen one's help of two lines.
    fitting = int((1.0 - _TOP) * window.height / line) - 6
    height = line * min(_ROWS, max(fitting, 1), len(found))
    imgui.begin_child("commands", imgui.ImVec2(0.0, height + 0.4 * line))
    imgui.set_cursor_pos_y(imgui.get_cursor_pos_y() + 0.2 * line)
    for row, action in enumerate(found):
        _row(state, action, row)
    imgui.end_child()
    chosen = found[state.look.palette_row]
    imgui.push_text_wrap_pos(0.0)
    imgui.text_disabled(f"{chosen.help}.")
    imgui.pop_text_wrap_pos()


def _row(state: EditorState, action: Action, row: int) -> None:
    em = imgui.get_font_size()
    chosen = row == state.look.palette_row
    left = imgui.get_cursor_screen_pos()
    width = imgui.get_content_region_avail().x
    imgui.begin_disabled(not action.available(state))
    # Only one row is lit: the one that Enter runs, which follows the mouse once that moves.
    nothing = imgui.get_style().color_(imgui.Col_.header if chosen else imgui.Col_.child_bg)
    imgui.push_style_color(imgui.Col_.header_hovered, nothing)
    if imgui.selectable(f"##{row}", chosen)[0]:
        _run(state, action)
    imgui.pop_style_color()
    imgui.end_disabled()
    mouse = imgui.get_io().mouse_delta
    if imgui.is_item_hovered() and (mouse.x or mouse.y):
        state.look.palette_row = row
    if chosen and _moved():
        imgui.set_scroll_here_y()
    draw = imgui.get_window_draw_list()
    colour = theme.TEXT if action.available(state) else theme.FAINT
    tick = "• " if action.is_on and action.is_on(state) else ""
    draw.add_text(imgui.ImVec2(left.x + 0.4 * em, left.y), theme.packed(colour), tick + action.name)
    keys_width = imgui.calc_text_size(action.label).x
    at = imgui.ImVec2(left.x + width - keys_width - 0.8 * em, left.y)
    draw.add_text(at, theme.packed(theme.DIM if action.available(state) else theme.FAINT), action.label)


def _moved() -> bool:
    return imgui.is_key_pressed(imgui.Key.down_arrow) or imgui.is_key_pressed(imgui.Key.up_arrow)


def _keys(state: EditorState, found: list[Action]) -> None:
    look = state.look
    if imgui.is_key_pressed(imgui.Key.down_arrow):
        look.palette_row = min(look.palette_row + 1, max(len(found) - 1, 0))
    if imgui.is_key_pressed(imgui.Key.up_arrow):
        look.palette_row = max(look.palette_row - 1, 0)
    again = imgui.get_io().key_ctrl and imgui.is_key_pressed(imgui.Key.p, False) and not imgui.is_window_appearing()
    if again or imgui.is_key_pressed(imgui.Key.escape, False):
        look.palette = False
    chosen = found[look.palette_row] if found else None
    enter = imgui.is_key_pressed(imgui.Key.enter, False) or imgui.is_key_pressed(imgui.Key.keypad_enter, False)
    if enter and chosen and chosen.available(state):
        _run(state, chosen)
    clicked_elsewhere = imgui.is_mouse_clicked(0) and not imgui.is_window_hovered(
        imgui.HoveredFlags_.child_windows | imgui.HoveredFlags_.allow_when_blocked_by_active_item
    )
    if clicked_elsewhere:
        look.palette = False


def _run(state: EditorState, action: Action) -> None:
    state.look.palette = False
    action.run(state)
