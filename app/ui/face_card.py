"""The card over the picture that says what can be done about the boxes of faces, and that no face was found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from imgui_bundle import imgui

from app.ui import face_edits, theme
from app.ui.layout import Rect
from app.ui.state import EditorState

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
    """The card, at the top of the viewport under what is asked, and out of the way of a drag."""
    tool = state.faces
    if state.snapshot.opened is None or state.picking is not None or tool.held is not None:
        return
    if not tool.is_open and (state.snapshot.faces or face_edits.wished_boxes(state) or face_edits.is_searching(state)):
        return
    em, spacing, padding = imgui.get_font_size(), imgui.get_style().item_spacing.x, imgui.get_style().window_padding.x
    buttons = _OPEN if tool.is_open else _CLOSED
    text, keys = words(state), sum(_width(button.label) for button in buttons) + spacing * (len(buttons) - 1)
    widest = viewport.width - 2 * em
    width = imgui.calc_text_size(text).x + 2 * em + keys + 2 * padding
    in_one_row = width <= widest
    if not in_one_row:
        width = min(widest, max(imgui.calc_text_size(text).x, keys) + 2 * padding)
    top = viewport.y + em + state.look.covered
    imgui.set_next_window_pos(imgui.ImVec2(viewport.x + (viewport.width - width) / 2, top))
    imgui.set_next_window_size(imgui.ImVec2(width, 0.0))
    with theme.card("faces", imgui.WindowFlags_.no_focus_on_appearing):
        imgui.push_text_wrap_pos(0.0)
        imgui.align_text_to_frame_padding()
        imgui.text(text)
        imgui.pop_text_wrap_pos()
        if in_one_row:
            imgui.same_line()
        imgui.set_cursor_pos_x(width - padding - keys)
        for button in buttons:
            _press(state, button)
        state.look.covered += imgui.get_window_height() + 0.5 * em


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
