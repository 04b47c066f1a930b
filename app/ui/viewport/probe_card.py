"""The pixel probe: a card with the values of every channel under the mouse."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import theme, widgets
from app.ui.layout import Rect
from app.ui.state import EditorState
from app.ui.viewport.panes import LIGHTS, Arrangement
from app.ui.viewport.probe import Reading, readings
from app.ui.viewport.view import photo_point
from app.ui.viewport.viewport_notes import TITLES

_NAME_EM, _LINEAR_EM, _CODES_EM, _SWATCH_EM = 6.2, 10.2, 7.6, 1.0
_PAD_EM, _LINE_EM = 0.7, 1.25


def spot(state: EditorState, arranged: Arrangement) -> tuple[float, float] | None:
    """The point of the photo under the mouse; None where there is none."""
    at = state.look.pointer_px
    pane = arranged.pane_at(at[0]) if at else None
    if pane is None or pane.name in LIGHTS:
        return None
    x, y = photo_point(pane.placement, pane.frame, at)
    height, width = state.snapshot.opened.photo.linear.shape[:2]
    return (x, y) if 0 <= x < width and 0 <= y < height else None


def width_em() -> float:
    """Of the card, in heights of its font."""
    return _NAME_EM + _LINEAR_EM + _CODES_EM + _SWATCH_EM + 2 * _PAD_EM


def height_em() -> float:
    """Of the card with all its rows, in heights of its font."""
    return _LINE_EM * len(TITLES) + 2 * _PAD_EM


def draw(state: EditorState, arranged: Arrangement, rect: Rect) -> None:
    """The card in the viewport's upper left corner, while it is switched on."""
    point = spot(state, arranged)
    under = arranged.pane_at(state.look.pointer_px[0]).name if point else ""
    state.look.spot, state.look.spot_in = point, under
    if not state.look.probe:
        return
    rows = readings(state.snapshot, state.edit.exposure_ev, *point) if point else []
    imgui.push_font(None, 0.88 * theme.FONT_PX)
    em = imgui.get_font_size()
    width = width_em() * em
    height = (_LINE_EM * (len(rows) + 1) + 2 * _PAD_EM) * em
    x, y = rect.x + 0.6 * em, rect.y + 0.6 * em
    draw_list = imgui.get_window_draw_list()
    widgets.shade(draw_list, Rect(x, y, width, height), 0.92)
    left, top = x + _PAD_EM * em, y + _PAD_EM * em
    _heading(draw_list, left, top, point, hint(arranged))
    for row, reading in enumerate(rows, 1):
        _row(draw_list, left, top + row * _LINE_EM * em, reading, reading.name == under)
    imgui.pop_font()


def hint(arranged: Arrangement) -> str:
    """How to get values, as long as there are none."""
    if arranged.main is not None and arranged.main.name in LIGHTS:
        return "A panorama; show another picture to read values"
    return "Point at the picture to read its values"


def _heading(
    draw_list: imgui.ImDrawList, x: float, y: float, point: tuple[float, float] | None, otherwise: str
) -> None:
    em = imgui.get_font_size()
    if point is None:
        draw_list.add_text(imgui.ImVec2(x, y), theme.packed(theme.DIM), otherwise)
        return
    draw_list.add_text(imgui.ImVec2(x, y), theme.packed(theme.TEXT), f"{int(point[0])}, {int(point[1])}")
    for words, along in (("linear", _NAME_EM), ("on screen, 0 – 255", _NAME_EM + _LINEAR_EM)):
        draw_list.add_text(imgui.ImVec2(x + along * em, y), theme.packed(theme.DIM), words)


def _row(draw_list: imgui.ImDrawList, x: float, y: float, reading: Reading, chosen: bool) -> None:
    em = imgui.get_font_size()
    name_colour = theme.packed(theme.ACCENT if chosen else theme.DIM)
    draw_list.add_text(imgui.ImVec2(x, y), name_colour, TITLES[reading.name])
    values = theme.packed(theme.TEXT)
    if reading.word:
        draw_list.add_text(imgui.ImVec2(x + _NAME_EM * em, y), values, reading.word.replace("_", " "))
    elif not reading.linear:
        draw_list.add_text(imgui.ImVec2(x + _NAME_EM * em, y), theme.packed(theme.FAINT), "outside")
        return
    for index, value in enumerate(reading.linear):
        words = f"{value:.3f}".replace("-", "\N{MINUS SIGN}")
        draw_list.add_text(imgui.ImVec2(x + (_NAME_EM + 3.3 * index) * em, y), values, words)
    codes_x = x + (_NAME_EM + _LINEAR_EM) * em
    for index, code in enumerate(reading.codes):
        draw_list.add_text(imgui.ImVec2(codes_x + 2.3 * index * em, y), values, str(code))
    if reading.codes:
        red, green, blue = (code / 255 for code in reading.codes)
        corner = imgui.ImVec2(codes_x + _CODES_EM * em, y + 0.1 * em)
        end = imgui.ImVec2(corner.x + 0.9 * em, y + 1.0 * em)
        draw_list.add_rect_filled(corner, end, theme.packed((red, green, blue, 1.0)), 2.0)
