"""Histogram or waveform of what is shown, above the effects."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import theme, widgets
from app.ui.pictures import Pictures
from app.ui.state import EditorState
from relight_core.imaging.scopes import Extremes

_LINES_AT = (0.25, 0.5, 0.75)
_LEAST_SHARE = 0.0005


def draw(state: EditorState, pictures: Pictures) -> None:
    """The panel's contents, inside its window; a click changes to the other scope."""
    em = imgui.get_font_size()
    look = state.look
    left, room = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail()
    height = room.y - 0.95 * em
    if imgui.invisible_button("scope", imgui.ImVec2(room.x, room.y)):
        look.scope = "waveform" if look.scope == "histogram" else "histogram"
    imgui.set_item_tooltip(
        "Left to right: dark to bright, as the screen shows it. Click for the waveform."
        if look.scope == "histogram"
        else "Each column of the picture: its darkest values below, its brightest on top. Click for the histogram."
    )
    draw_list = imgui.get_window_draw_list()
    end = imgui.ImVec2(left.x + room.x, left.y + height)
    draw_list.add_rect_filled(left, end, theme.packed(theme.CANVAS), 0.27 * em)
    name = state.shown_name() if state.snapshot.opened else None
    _lines(draw_list, left, room.x, height, upright=look.scope == "histogram")
    shown = pictures.scope(look.scope, name) if name else None
    if shown is not None:
        widgets.draw_image(shown, left.x, left.y + 1, room.x, height - 1)
        _extremes(draw_list, pictures.extremes(name), left.x, left.y + height + 0.25 * em, room.x)


def _lines(draw_list: imgui.ImDrawList, corner: imgui.ImVec2, width: float, height: float, upright: bool) -> None:
    for share in _LINES_AT:
        x, y = corner.x + share * width, corner.y + share * height
        start, end = ((x, corner.y), (x, corner.y + height)) if upright else ((corner.x, y), (corner.x + width, y))
        draw_list.add_line(start, end, theme.packed(theme.RAISED), 1.0)


def _extremes(draw_list: imgui.ImDrawList, found: Extremes | None, x: float, y: float, width: float) -> None:
    """How much is too dark on the left, too bright on the right, and what is no number between them."""
    if found is None:
        return
    imgui.push_font(None, 0.82 * theme.FONT_PX)
    dark, bright = f"dark {_percent(found.too_dark)}", f"bright {_percent(found.too_bright)}"
    draw_list.add_text(imgui.ImVec2(x, y), theme.packed(_warning(found.too_dark)), dark)
    at = imgui.ImVec2(x + width - imgui.calc_text_size(bright).x, y)
    draw_list.add_text(at, theme.packed(_warning(found.too_bright)), bright)
    if found.no_number:
        words = "not a number!"
        at = imgui.ImVec2(x + (width - imgui.calc_text_size(words).x) / 2, y)
        draw_list.add_text(at, theme.packed(theme.ERROR), words)
    imgui.pop_font()


def _percent(share: float) -> str:
    return f"{share * 100:.1f} %" if share < 0.0995 else f"{share * 100:.0f} %"


def _warning(share: float) -> theme.Colour:
    return theme.ACCENT if share > _LEAST_SHARE else theme.FAINT
