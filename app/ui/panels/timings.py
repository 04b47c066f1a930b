"""When each stage of the last update ran and what it took, and why it ran or did not."""

from __future__ import annotations

from collections.abc import Mapping

from imgui_bundle import imgui

from app.ui import theme, widgets
from app.ui.layout import Rect
from app.ui.state import EditorState
from app.ui.viewport import probe_card
from relight_core.pipeline.cache import Stage, computed_ms

_NAME_EM, _MS_EM, _BAR_EM, _LEAST_WHY_EM = 10.0, 3.6, 8.0, 12.5
_PAD_EM, _LINE_EM, _MARGIN_EM = 0.7, 1.25, 0.6
_ROOM_FOR_WHY_EM = 49.0
_FOOT_EM = 2.7
"""What stays free under the card, for the zoom's percentage."""


def draw(state: EditorState, rect: Rect) -> None:
    """A card in the viewport's upper right corner, while it is switched on."""
    picture = state.snapshot.picture
    if not state.look.timings or picture is None or not picture.relit.stages:
        return
    imgui.push_font(None, 0.88 * theme.FONT_PX)
    em = imgui.get_font_size()
    stages = picture.relit.stages
    probe_end = probe_card.width_em() + 2 * _MARGIN_EM if state.look.probe else _MARGIN_EM
    why_width = _why_width(stages, rect.width, probe_end * em)
    width = (_NAME_EM + _MS_EM + _BAR_EM + 2 * _PAD_EM) * em + why_width
    x, y = rect.x + rect.width - width - _MARGIN_EM * em, rect.y + _MARGIN_EM * em
    if state.look.probe and x < rect.x + probe_end * em:
        y += (probe_card.height_em() + _MARGIN_EM) * em
    room_em = (rect.y + rect.height - y) / em - 2 * _PAD_EM - _FOOT_EM
    shown = stages_that_fit(stages, int(room_em / _LINE_EM))
    sums = [("all together", computed_ms(stages))]
    if len(shown) < len(stages):
        sums.insert(0, (f"{len(stages) - len(shown)} others", sums[0][1] - computed_ms(shown)))
    height = (_LINE_EM * (len(shown) + len(sums)) + 2 * _PAD_EM) * em
    draw_list = imgui.get_window_draw_list()
    widgets.shade(draw_list, Rect(x, y, width, height), 0.92)
    end_ms = max((stage.start_ms + stage.ms for stage in stages.values() if stage.state == "computed"), default=1.0)
    for row, (name, stage) in enumerate(shown.items()):
        at = imgui.ImVec2(x + _PAD_EM * em, y + (_PAD_EM + row * _LINE_EM) * em)
        _row(draw_list, at, name, stage, end_ms, why_width)
    for row, (name, ms) in enumerate(sums, len(shown)):
        foot = y + (_PAD_EM + row * _LINE_EM) * em
        draw_list.add_text(imgui.ImVec2(x + _PAD_EM * em, foot), theme.packed(theme.TEXT), name)
        _right_aligned(draw_list, f"{ms:.1f} ms", x + (_PAD_EM + _NAME_EM + _MS_EM) * em, foot, theme.TEXT)
    imgui.pop_font()


def _why_width(stages: Mapping[str, Stage], room: float, taken: float) -> float:
    """Pixels for the reasons: as the longest asks for and the viewport has left; none where that is narrow."""
    em = imgui.get_font_size()
    if room <= _ROOM_FOR_WHY_EM * em:
        return 0.0
    left = room - taken - (_NAME_EM + _MS_EM + _BAR_EM + 2 * _PAD_EM + _MARGIN_EM) * em
    longest = max((imgui.calc_text_size(stage.why).x for stage in stages.values()), default=0.0)
    return max(_LEAST_WHY_EM * em, min(longest, left))


def stages_that_fit(stages: Mapping[str, Stage], lines: int) -> dict[str, Stage]:
    """All stages if the lines have room for them and their sum; else, beside a line for the others, the longest."""
    if len(stages) + 1 <= lines:
        return dict(stages)
    longest = sorted(stages, key=lambda name: computed_ms({name: stages[name]}), reverse=True)[: max(lines - 2, 0)]
    return {name: stage for name, stage in stages.items() if name in longest}


def _row(draw_list: imgui.ImDrawList, at: imgui.ImVec2, name: str, stage: Stage, end_ms: float, why: float) -> None:
    """One stage; its bar lies where it ran between the update's begin and `end_ms`, its reason is `why` pixels wide."""
    em = imgui.get_font_size()
    computed = stage.state == "computed"
    colour = theme.TEXT if computed else theme.DIM
    draw_list.add_text(at, theme.packed(colour), name.replace("_", " "))
    if computed:
        _right_aligned(draw_list, f"{stage.ms:.1f} ms", at.x + (_NAME_EM + _MS_EM) * em, at.y, colour)
        per_ms = (_BAR_EM - 1.0) * em / max(end_ms, 1e-6)
        left, middle = at.x + (_NAME_EM + _MS_EM + 0.6) * em + per_ms * stage.start_ms, at.y + 0.55 * em
        end = imgui.ImVec2(left + max(per_ms * stage.ms, 1.0), middle + 0.2 * em)
        draw_list.add_rect_filled(imgui.ImVec2(left, middle - 0.2 * em), end, theme.packed(theme.ACCENT), 1.0)
    else:
        draw_list.add_text(imgui.ImVec2(at.x + (_NAME_EM + 0.6) * em, at.y), theme.packed(colour), stage.state)
    if why and stage.why:
        left = imgui.ImVec2(at.x + (_NAME_EM + _MS_EM + _BAR_EM) * em, at.y)
        draw_list.add_text(left, theme.packed(theme.DIM), widgets.shortened(stage.why, why))


def _right_aligned(draw_list: imgui.ImDrawList, words: str, right: float, y: float, colour: theme.Colour) -> None:
    draw_list.add_text(imgui.ImVec2(right - imgui.calc_text_size(words).x, y), theme.packed(colour), words)
