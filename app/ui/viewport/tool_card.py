"""A card over the picture that explains a tool, with the tool's buttons."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from imgui_bundle import imgui

from app.ui import theme
from app.ui.layout import Rect
from app.ui.state import EditorState

_OVER_NOTES_EM, _OVER_A_JOB_EM = 3.0, 9.0

Box = tuple[float, float, float, float]


@dataclass(frozen=True)
class Button:
    """A button on the card.

    Attributes:
        label, tooltip: its words.
        act: called when it is clicked.
        available: whether it can be clicked; otherwise it is greyed.
        is_main: the button that finishes the tool, in the accent colour.
    """

    label: str
    tooltip: str
    act: Callable[[EditorState], None]
    available: Callable[[EditorState], bool] = lambda state: True
    is_main: bool = False


def draw(
    state: EditorState, name: str, words: str, buttons: Sequence[Button], viewport: Rect, avoided: Sequence[Box]
) -> None:
    """The card, at the top of the viewport below open questions, or at the bottom if it would cover something there.

    Args:
        name: of the card's window.
        avoided: left, top, right and bottom of what should stay in sight.
    """
    rows = _rows(buttons, viewport.width - 2 * imgui.get_font_size() - 2 * imgui.get_style().window_padding.x)
    size, in_one_row = _size(words, rows, viewport)
    place, is_above = _place(state, viewport, size, avoided)
    imgui.set_next_window_pos(imgui.ImVec2(*place))
    imgui.set_next_window_size(imgui.ImVec2(size[0], 0.0))
    with theme.card(name, imgui.WindowFlags_.no_focus_on_appearing):
        imgui.push_text_wrap_pos(0.0)
        imgui.align_text_to_frame_padding()
        imgui.text(words)
        imgui.pop_text_wrap_pos()
        if in_one_row:
            imgui.same_line()
        for row in rows:
            imgui.set_cursor_pos_x(size[0] - imgui.get_style().window_padding.x - _row_width(row))
            for index, button in enumerate(row):
                if index:
                    imgui.same_line()
                _press(state, button)
        if is_above:
            state.look.covered += imgui.get_window_height() + 0.5 * imgui.get_font_size()


def _rows(buttons: Sequence[Button], room: float) -> list[list[Button]]:
    """The buttons in as many rows as they need, each no wider than the room unless one button is."""
    rows: list[list[Button]] = [[]]
    for button in buttons:
        if rows[-1] and _row_width([*rows[-1], button]) > room:
            rows.append([])
        rows[-1].append(button)
    return rows


def _row_width(row: Sequence[Button]) -> float:
    return sum(_width(button.label) for button in row) + imgui.get_style().item_spacing.x * (len(row) - 1)


def _size(text: str, rows: Sequence[Sequence[Button]], viewport: Rect) -> tuple[tuple[float, float], bool]:
    """Width and height of the card, and whether words and buttons have room beside each other."""
    em, style = imgui.get_font_size(), imgui.get_style()
    text_width, padding, row = imgui.calc_text_size(text).x, style.window_padding, imgui.get_frame_height()
    keys, widest = max(map(_row_width, rows)), viewport.width - 2 * em
    width = text_width + 2 * em + keys + 2 * padding.x
    if len(rows) == 1 and width <= widest:
        return (width, row + 2 * padding.y), True
    width = min(widest, max(text_width, keys) + 2 * padding.x)
    lines = math.ceil(text_width / max(1.0, width - 2 * padding.x))
    height = (lines - 1) * em + row + len(rows) * (row + style.item_spacing.y) + 2 * padding.y
    return (width, height), False


def _place(
    state: EditorState, viewport: Rect, size: tuple[float, float], avoided: Sequence[Box]
) -> tuple[tuple[float, float], bool]:
    """The card's corner in the window, and whether that is at the viewport's top."""
    em = imgui.get_font_size()
    x = viewport.x + (viewport.width - size[0]) / 2
    above = viewport.y + em + state.look.covered
    below = viewport.y + viewport.height - (_OVER_A_JOB_EM if state.job else _OVER_NOTES_EM) * em - size[1]

    def is_free(y: float) -> bool:
        return not any(
            left < x + size[0] and right > x and top < y + size[1] and bottom > y
            for left, top, right, bottom in avoided
        )

    is_above = is_free(above) or not is_free(below)
    return (x, above if is_above else below), is_above


def _width(label: str) -> float:
    return imgui.calc_text_size(label).x + 1.6 * imgui.get_font_size()


def _press(state: EditorState, button: Button) -> None:
    if button.is_main:
        imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*theme.ACCENT))
    imgui.begin_disabled(not button.available(state))
    clicked = imgui.button(button.label, imgui.ImVec2(_width(button.label), 0.0))
    imgui.end_disabled()
    if button.is_main:
        imgui.pop_style_color()
    imgui.set_item_tooltip(button.tooltip)
    if clicked:
        button.act(state)
