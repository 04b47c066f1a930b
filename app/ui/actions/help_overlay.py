"""The overlay that shows every key and every gesture, from the action table."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import theme
from app.ui.actions.action_table import ACTIONS, GESTURES
from app.ui.layout import Rect
from app.ui.state import EditorState

_LEAST_COLUMN_EM, _WIDEST_COLUMN_EM = 22.0, 30.0
_KEYS_SHARE = 0.4
_FOOT_EM = 2.4


def groups() -> dict[str, list[tuple[str, str]]]:
    """Group -> rows of keys and what they do; the groups in the table's order, gestures last in each."""
    rows: dict[str, list[tuple[str, str]]] = {}
    for action in ACTIONS:
        keys = "  or  ".join(chord.label for chord in action.chords if chord.label != "Shift + +")
        hold = " (hold)" if action.let_go else ""
        rows.setdefault(action.group, []).append((keys + hold, action.name))
    for gesture in GESTURES:
        rows.setdefault(gesture.group, []).append((gesture.hand, gesture.help))
    return rows


def draw(state: EditorState, fonts: theme.Fonts, window: Rect) -> None:
    """The overlay over the whole window; a click anywhere closes it."""
    if not state.look.help:
        return
    em = imgui.get_font_size()
    imgui.set_next_window_pos(imgui.ImVec2(window.x, window.y))
    imgui.set_next_window_size(imgui.ImVec2(window.width, window.height))
    imgui.set_next_window_focus()
    imgui.push_style_color(imgui.Col_.window_bg, imgui.ImVec4(*theme.SHADE))
    flags = imgui.WindowFlags_.no_decoration | imgui.WindowFlags_.no_saved_settings
    imgui.push_style_var(imgui.StyleVar_.window_padding, imgui.ImVec2(0.0, 0.0))
    imgui.begin("help", None, flags)
    imgui.pop_style_var()
    imgui.pop_style_color()
    if imgui.is_window_hovered(imgui.HoveredFlags_.child_windows) and imgui.is_mouse_clicked(0):
        state.look.help = False
    # Scrolls in a window that is too low for all of it.
    imgui.begin_child("keys", imgui.ImVec2(window.width, window.height - _FOOT_EM * em))
    _keys(fonts, window.width)
    imgui.end_child()
    foot = "Click anywhere or press Esc to close.  Ctrl + P finds a command by its name."
    y = window.height - (_FOOT_EM + 1.0) / 2 * em
    imgui.set_cursor_pos(imgui.ImVec2((window.width - imgui.calc_text_size(foot).x) / 2, y))
    imgui.text_disabled(foot)
    imgui.end()


def _keys(fonts: theme.Fonts, width: float) -> None:
    em = imgui.get_font_size()
    room = width - 2 * em
    count = max(1, min(3, int(room // (_LEAST_COLUMN_EM * em))))
    column = min(room / count, _WIDEST_COLUMN_EM * em)
    left = (width - count * column) / 2
    for index, part in enumerate(_columns(count)):
        imgui.set_cursor_pos(imgui.ImVec2(left + index * column, 1.2 * em))
        imgui.begin_group()
        for title, rows in part:
            _group(fonts, title, rows, column)
        imgui.end_group()


def _group(fonts: theme.Fonts, title: str, rows: list[tuple[str, str]], width: float) -> None:
    em = imgui.get_font_size()
    imgui.push_font(fonts.bold, 0.0)
    imgui.text_colored(imgui.ImVec4(*theme.ACCENT), title)
    imgui.pop_font()
    left = imgui.get_cursor_pos_x()
    imgui.push_style_var(imgui.StyleVar_.item_spacing, imgui.ImVec2(0.5 * em, 0.18 * em))
    for keys, words in rows:
        _wrapped(_unbroken(keys), left + _KEYS_SHARE * width - 0.5 * em, theme.TEXT)
        imgui.same_line()
        imgui.set_cursor_pos_x(left + _KEYS_SHARE * width)
        _wrapped(words, left + width - em, theme.DIM)
    imgui.pop_style_var()
    imgui.dummy(imgui.ImVec2(1.0, 0.5 * em))


def _unbroken(keys: str) -> str:
    """Keys of which a line may end between two ways to press something, but not amid one."""
    return keys.replace(" + ", "\N{NO-BREAK SPACE}+\N{NO-BREAK SPACE}")


def _wrapped(words: str, right: float, colour: theme.Colour) -> None:
    imgui.push_text_wrap_pos(right)
    imgui.text_colored(imgui.ImVec4(*colour), words)
    imgui.pop_text_wrap_pos()


def _columns(count: int) -> list[list[tuple[str, list[tuple[str, str]]]]]:
    """The groups dealt to columns of about the same height, in order."""
    items = list(groups().items())
    weights = [len(rows) + 2 for _, rows in items]
    columns, filled, share = [[]], 0, sum(weights) / count
    for item, weight in zip(items, weights, strict=True):
        if filled + weight / 2 > share * len(columns) and len(columns) < count:
            columns.append([])
        columns[-1].append(item)
        filled += weight
    return columns
