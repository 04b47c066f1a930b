"""When each stage of the last update ran and what it took, and why it ran or did not."""

from __future__ import annotations

from collections.abc import Mapping

from imgui_bundle import imgui

from app.ui import theme
from app.ui.layout import Rect
from app.ui.state import EditorState
from app.ui.viewport import probe_card
from relight_core.pipeline.cache import Stage

_NAME_EM, _MS_EM, _BAR_EM, _WHY_EM = 7.6, 3.6, 8.0, 12.5
_PAD_EM, _LINE_EM = 0.7, 1.25
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
    wide = rect.width > _ROOM_FOR_WHY_EM * em
    width = (_NAME_EM + _MS_EM + _BAR_EM + (_WHY_EM if wide else 0.0) + 2 * _PAD_EM) * em
    x, y = rect.x + rect.width - width - 0.6 * em, rect.y + 0.6 * em
    if state.look.probe and x < rect.x + probe_card.width_em() * em + 1.2 * em:
        y += probe_card.height_em() * em + 0.6 * em
    room_em = (rect.y + rect.height - y) / em - 2 * _PAD_EM - _FOOT_EM
    shown = stages_that_fit(stages, int(room_em / _LINE_EM))
    sums = [("all together", _sum_ms(stages))]
    if len(shown) < len(stages):
        sums.insert(0, (f"{len(stages) - len(shown)} others", sums[0][1] - _sum_ms(shown)))
    height = (_LINE_EM * (len(shown) + len(sums)) + 2 * _PAD_EM) * em
    draw_list = imgui.get_window_draw_list()
    corner, end = imgui.ImVec2(x, y), imgui.ImVec2(x + width, y + height)
    draw_list.add_rect_filled(corner, end, theme.packed(theme.SHADE, 0.92), 0.27 * em)
    end_ms = max((stage.start_ms + stage.ms for stage in stages.values() if stage.state == "computed"), default=1.0)
    for row, (name, stage) in enumerate(shown.items()):
        at = imgui.ImVec2(x + _PAD_EM * em, y + (_PAD_EM + row * _LINE_EM) * em)
        _row(draw_list, at, name, stage, end_ms, wide)
    for row, (name, ms) in enumerate(sums, len(shown)):
        foot = y + (_PAD_EM + row * _LINE_EM) * em
        draw_list.add_text(imgui.ImVec2(x + _PAD_EM * em, foot), theme.packed(theme.TEXT), name)
        _right_aligned(draw_list, f"{ms:.1f} ms", x + (_PAD_EM + _NAME_EM + _MS_EM) * em, foot, theme.TEXT)
    imgui.pop_font()


def stages_that_fit(stages: Mapping[str, Stage], lines: int) -> dict[str, Stage]:
    """All stages if the lines have room for them and their sum; else, beside a line for the others, the longest."""
    if len(stages) + 1 <= lines:
        return dict(stages)
    longest = sorted(stages, key=lambda name: _sum_ms({name: stages[name]}), reverse=True)[: max(lines - 2, 0)]
    return {name: stage for name, stage in stages.items() if name in longest}


def _sum_ms(stages: Mapping[str, Stage]) -> float:
    return sum(stage.ms for stage in stages.values() if stage.state == "computed")


def _row(draw_list: imgui.ImDrawList, at: imgui.ImVec2, name: str, stage, end_ms: float, wide: bool) -> None:
    """One stage; its bar lies where it ran between the update's begin and `end_ms`."""
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
    if wide and stage.why:
        why = imgui.ImVec2(at.x + (_NAME_EM + _MS_EM + _BAR_EM) * em, at.y)
        draw_list.add_text(why, theme.packed(theme.DIM), stage.why)


def _right_aligned(draw_list: imgui.ImDrawList, words: str, right: float, y: float, colour: theme.Colour) -> None:
    draw_list.add_text(imgui.ImVec2(right - imgui.calc_text_size(words).x, y), theme.packed(colour), words)
