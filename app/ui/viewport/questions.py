"""Open questions, as cards at the top of the viewport."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import theme
from app.ui.asking import Question
from app.ui.layout import Rect
from app.ui.state import EditorState
from relight_core.imaging.files import legible


def draw(state: EditorState, viewport: Rect) -> None:
    """Every open question, one under the other."""
    em = imgui.get_font_size()
    top = viewport.y + em
    for question in list(state.asking.questions):
        top += _card(state, question, viewport, top) + 0.5 * em
    state.look.covered = top - viewport.y - em


def answered_by_enter(state: EditorState) -> Question | None:
    """The question whose first answer Enter gives: the newest, unless a tool is open that Enter finishes."""
    if state.faces.is_open or state.brush.is_open or not state.asking.questions:
        return None
    return state.asking.questions[-1]


def _card(state: EditorState, question: Question, viewport: Rect, top: float) -> float:
    em = imgui.get_font_size()
    width = min(34 * em, viewport.width - 2 * em)
    imgui.set_next_window_pos(imgui.ImVec2(viewport.x + (viewport.width - width) / 2, top))
    imgui.set_next_window_size(imgui.ImVec2(width, 0.0))
    with theme.card(legible(f"question {question.key}")):
        imgui.push_text_wrap_pos(0.0)
        imgui.text(legible(question.text))
        imgui.pop_text_wrap_pos()
        _buttons(state, question)
        return imgui.get_window_height()


def _buttons(state: EditorState, question: Question) -> None:
    padding = 1.6 * imgui.get_font_size()
    widths = [imgui.calc_text_size(label).x + padding for label, _ in question.choices]
    spacing = imgui.get_style().item_spacing.x
    room = imgui.get_content_region_avail().x - sum(widths) - spacing * (len(widths) - 1)
    imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + max(0.0, room))
    by_enter = answered_by_enter(state)
    for index, (label, _) in enumerate(question.choices):
        if index:
            imgui.same_line()
        is_lit = not index and question is by_enter
        imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*(theme.ACCENT if is_lit else theme.TEXT)))
        clicked = imgui.button(label, imgui.ImVec2(widths[index], 0.0))
        imgui.pop_style_color()
        if clicked:
            state.asking.answer(question, index)
