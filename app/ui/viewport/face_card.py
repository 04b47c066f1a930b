"""The card over the picture that says what can be done about the boxes of faces, and that no face was found."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from imgui_bundle import imgui

from app.ui import face_edits, theme
from app.ui.layout import Rect
from app.ui.state import EditorState
from app.ui.viewport import face_tool

_OVER_NOTES_EM, _OVER_A_JOB_EM = 3.0, 9.0
_CORRECTING = "Move or resize a box, or draw one from brows to chin."
_NOBODY = "No face was found. Draw a box over it, from brows to chin."
_NOBODY_LEFT = "No face is left. Draw a box over one, from brows to chin."
_SEARCHING = "Looking for faces…"


@dataclass(frozen=True)
class _Button:
    label: str
    tooltip: str
    act: Callable[[EditorState], None]
    available: Callable[[EditorState], bool] = lambda state: True
    is_main: bool = False


def _is_corrected(state: EditorState) -> bool:
    return state.photo is not None and state.photo.boxes is not None


_CLOSED = (_Button("Draw a box", "Then drag over the face.  Shift + F", face_edits.show, is_main=True),)
_OPEN = (
    _Button("Find again", "Forget these boxes and look for the faces anew.", face_edits.find_again, _is_corrected),
    _Button(
        "Remove",
        "The selected box is no face.  Delete",
        face_edits.remove,
        lambda state: 0 <= state.faces.selected < len(face_edits.wished_boxes(state)),
    ),
    _Button("Done", "Enter.  Esc puts the boxes back as they were", face_edits.done, is_main=True),
)


def draw(state: EditorState, viewport: Rect) -> None:
    """The card, at the top of the viewport under what is asked, at its foot where it would cover a box there."""
    tool = state.faces
    if state.snapshot.opened is None or state.picking is not None or tool.held is not None:
        return
    if not tool.is_open and (state.snapshot.faces or face_edits.wished_boxes(state) or face_edits.is_searching(state)):
        return
    buttons = _OPEN if tool.is_open else _CLOSED
    keys = sum(_width(button.label) for button in buttons) + imgui.get_style().item_spacing.x * (len(buttons) - 1)
    size, in_one_row = _size(words(state), keys, viewport)
    place, is_above = _place(state, viewport, size)
    imgui.set_next_window_pos(imgui.ImVec2(*place))
    imgui.set_next_window_size(imgui.ImVec2(size[0], 0.0))
    with theme.card("faces", imgui.WindowFlags_.no_focus_on_appearing):
        imgui.push_text_wrap_pos(0.0)
        imgui.align_text_to_frame_padding()
        imgui.text(words(state))
        imgui.pop_text_wrap_pos()
        if in_one_row:
            imgui.same_line()
        imgui.set_cursor_pos_x(size[0] - imgui.get_style().window_padding.x - keys)
        for button in buttons:
            _press(state, button)
        if is_above:
            state.look.covered += imgui.get_window_height() + 0.5 * imgui.get_font_size()


def _size(text: str, keys: float, viewport: Rect) -> tuple[tuple[float, float], bool]:
    """Width and height of the card, and whether words and buttons have room beside each other."""
    em, style = imgui.get_font_size(), imgui.get_style()
    text_width, padding, row = imgui.calc_text_size(text).x, style.window_padding, imgui.get_frame_height()
    widest = viewport.width - 2 * em
    width = text_width + 2 * em + keys + 2 * padding.x
    if width <= widest:
        return (width, row + 2 * padding.y), True
    width = min(widest, max(text_width, keys) + 2 * padding.x)
    lines = math.ceil(text_width / max(1.0, width - 2 * padding.x))
    return (width, (lines - 1) * em + 2 * row + style.item_spacing.y + 2 * padding.y), False


def _place(state: EditorState, viewport: Rect, size: tuple[float, float]) -> tuple[tuple[float, float], bool]:
    """The card's corner in the window, and whether that is at the viewport's top."""
    em = imgui.get_font_size()
    x = viewport.x + (viewport.width - size[0]) / 2
    above = viewport.y + em + state.look.covered
    below = viewport.y + viewport.height - (_OVER_A_JOB_EM if state.job else _OVER_NOTES_EM) * em - size[1]
    boxes = face_tool.on_the_screen(state, viewport)

    def is_free(y: float) -> bool:
        return not any(
            left < x + size[0] and right > x and top < y + size[1] and bottom > y for left, top, right, bottom in boxes
        )

    is_above = is_free(above) or not is_free(below)
    return (x, above if is_above else below), is_above


def words(state: EditorState) -> str:
    """What can be done now."""
    if face_edits.is_searching(state):
        return _SEARCHING
    if face_edits.wished_boxes(state):
        return _CORRECTING
    return _NOBODY if state.photo is None or state.photo.boxes is None else _NOBODY_LEFT


def _width(label: str) -> float:
    return imgui.calc_text_size(label).x + 1.6 * imgui.get_font_size()


def _press(state: EditorState, button: _Button) -> None:
    if button.is_main:
        imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*theme.ACCENT))
    imgui.begin_disabled(not button.available(state))
    clicked = imgui.button(button.label, imgui.ImVec2(_width(button.label), 0.0))
    imgui.end_disabled()
    if button.is_main:
        imgui.pop_style_color()
    imgui.set_item_tooltip(button.tooltip)
    if button is not _OPEN[-1]:
        imgui.same_line()
    if clicked:
        button.act(state)
