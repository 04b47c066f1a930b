"""What is written over the picture: its name and zoom, what runs, what the colours mean, and the first words."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import theme, widgets
from app.ui.channels import CHANNELS, RESULT
from app.ui.layout import Rect
from app.ui.pictures import Pictures
from app.ui.state import EditorState
from app.ui.viewport.panes import LIGHTS, Arrangement, Pane

TITLES = {channel.name: channel.title for channel in CHANNELS}
_DIFFERENCE_ENDS = ("3 stops darker", "same", "3 stops brighter")
_NARROW_DIFFERENCE_ENDS = ("\N{MINUS SIGN}3 EV", "0", "+3 EV")
_SCALE_ENDS = {"specular": ("0", "0.25"), "shadow": ("0", "0.5")}
_LEGEND_EM, _LEGEND_FOOT_EM, _NARROW_LEGEND_FOOT_EM = (17.0, 0.55), 3.1, 4.9
"""Width and height of its colours, and how far above the viewport's foot they begin, in font heights."""
_CORNER_ROOM_EM = 9.0
"""How much of the viewport's width the picture's name and zoom in its corner take at most."""
_LEGEND_ROOM_EM = 34.0
"""A narrower viewport has no room for the legend beside the picture's name in its corner."""


def note(words: str, x: float, y: float, colour: theme.Colour = theme.TEXT) -> None:
    """Words on a dark pill, their rectangle's top left corner at x, y."""
    em = imgui.get_font_size()
    draw = imgui.get_window_draw_list()
    widgets.shade(draw, Rect(x, y, note_width(words), 1.5 * em), 0.72)
    draw.add_text(imgui.ImVec2(x + 0.5 * em, y + 0.22 * em), theme.packed(colour), words)


def note_width(words: str) -> float:
    """How wide the pill is."""
    return imgui.calc_text_size(words).x + imgui.get_font_size()


def corner_note(state: EditorState, arranged: Arrangement, rect: Rect) -> None:
    """The picture's name, unless it is the result, and its zoom."""
    pane = arranged.main
    words = f"{pane.placement.zoom * 100:.0f} %" if pane.name not in LIGHTS else ""
    if state.before:
        words = f"Before   {words}"
    elif pane.name != RESULT and len(arranged.panes) == 1:
        words = f"{TITLES[pane.name]}   {words}".rstrip()
    em = imgui.get_font_size()
    note(words, rect.x + rect.width - note_width(words) - 0.6 * em, rect.y + rect.height - 2.1 * em)


def pane_titles(state: EditorState, arranged: Arrangement, rect: Rect, scale: float) -> None:
    """Which picture is which, on either side of the line between two; below where cards or a tool's words are on top.

    What the colours mean stays in sight below them.
    """
    if len(arranged.panes) < 2:
        return
    em = imgui.get_font_size()
    before, after = arranged.panes
    covered = state.look.probe or state.look.timings or state.aim.target
    y = rect.y + (rect.height - titles_foot_em(state, arranged.main, rect) * em if covered else 0.6 * em)
    left = TITLES[before.name]
    x = rect.x + before.right / scale - note_width(left) - 0.6 * em
    if x > rect.x:
        note(left, x, y)
    right = TITLES[after.name]
    x = rect.x + after.left / scale + 0.6 * em
    if x + note_width(right) < rect.x + rect.width:
        note(right, x, y)


def titles_foot_em(state: EditorState, pane: Pane, rect: Rect) -> float:
    """How far above the viewport's foot titles begin that have no room at its top; above what colours mean."""
    return 2.1 if _colours(state, pane) is None else _legend_foot_em(rect) + 2.5


def progress(state: EditorState, rect: Rect) -> None:
    """What runs, over the photo, as long as there is nothing newer of it to look at."""
    snapshot = state.snapshot
    if snapshot.activity is None or snapshot.picture_in_sight is not None:
        return
    em = imgui.get_font_size()
    words = widgets.shortened(f"{snapshot.activity}…", rect.width - 2.2 * em)
    beside = (rect.width - note_width(words)) / 2
    foot_em = 2.1 if beside > _CORNER_ROOM_EM * em else 3.9
    note(words, rect.x + beside, rect.y + rect.height - foot_em * em)


def legend(state: EditorState, pictures: Pictures, pane: Pane, rect: Rect) -> None:
    """What the colours of a difference or of false colour mean."""
    colours = _colours(state, pane)
    if colours is None:
        return
    kind, ends = colours
    em = imgui.get_font_size()
    width, height = min(_LEGEND_EM[0] * em, rect.width - 2 * em), _LEGEND_EM[1] * em
    x, y = rect.x + (rect.width - width) / 2, rect.y + rect.height - _legend_foot_em(rect) * em
    draw = imgui.get_window_draw_list()
    widgets.shade(draw, Rect(x - 0.7 * em, y - 0.6 * em, width + 1.4 * em, 2.9 * em), 0.8)
    widgets.draw_image(pictures.colours(kind), x, y, width, height)
    imgui.push_font(None, 0.86 * theme.FONT_PX)
    if ends is _DIFFERENCE_ENDS and sum(imgui.calc_text_size(words).x for words in ends) + 2 * em > width:
        ends = _NARROW_DIFFERENCE_ENDS
    for index, words in enumerate(ends):
        words_width = imgui.calc_text_size(words).x
        share = index / (len(ends) - 1)
        at = imgui.ImVec2(x + share * (width - words_width), y + height + 0.25 * em)
        draw.add_text(at, theme.packed(theme.TEXT), words)
    imgui.pop_font()


def _legend_foot_em(rect: Rect) -> float:
    """How far above the viewport's foot the legend's colours begin; above the picture's name where that is near."""
    return _LEGEND_FOOT_EM if rect.width > _LEGEND_ROOM_EM * imgui.get_font_size() else _NARROW_LEGEND_FOOT_EM


def _colours(state: EditorState, pane: Pane) -> tuple[str, tuple[str, ...]] | None:
    """Of what kind the colours are that have a legend, and what its ends say; None where it is shown as it is."""
    look = state.look
    if look.difference and pane.name == RESULT:
        return "difference", _DIFFERENCE_ENDS
    if look.false_colour and pane.name in _SCALE_ENDS:
        return "scale", _SCALE_ENDS[pane.name]
    return None


_FIRST_WORDS = (
    (-0.3, "or click to choose one: JPEG, PNG, TIFF, HEIC, WebP, EXR, raw"),
    (1.8, "Several photos or a folder become a queue; a session goes on."),
    (3.2, "An .hdr or .exr panorama becomes the light."),
    (4.6, "A portrait dropped on the light panel lends its light."),
)
"""Their places below the middle, in font heights."""


def invitation(state: EditorState, fonts: theme.Fonts, rect: Rect) -> bool:
    """What to do while nothing is open, or what is being opened; whether the mouse is on an invitation to open."""
    busy = state.snapshot.activity if state.photo else None
    em = imgui.get_font_size()
    middle_x, middle_y = rect.x + rect.width / 2, rect.y + rect.height / 2
    reach_x, reach_y = min(16 * em, 0.46 * rect.width), min(8 * em, 0.36 * rect.height)
    mouse = imgui.get_io().mouse_pos
    inside = abs(mouse.x - middle_x) < reach_x and abs(mouse.y - middle_y) < reach_y
    pointed_at = not busy and inside and imgui.is_item_hovered()
    if pointed_at:
        imgui.set_mouse_cursor(imgui.MouseCursor_.hand)
    imgui.push_font(fonts.regular, 1.5 * theme.FONT_PX)
    words = widgets.shortened(f"{busy}…" if busy else "Drop a portrait here", rect.width - 2.2 * em)
    _centred(words, middle_x, middle_y - 3.6 * em, theme.TEXT)
    imgui.pop_font()
    if not busy:
        corner = imgui.ImVec2(middle_x - reach_x, middle_y - reach_y)
        end = imgui.ImVec2(middle_x + reach_x, middle_y + reach_y)
        line = theme.packed(theme.DIM if pointed_at else theme.PRESSED)
        imgui.get_window_draw_list().add_rect(corner, end, line, 10.0, 1.5)
        for down_em, words in _FIRST_WORDS:
            _centred(words, middle_x, middle_y + (down_em - 1.2) * em, theme.DIM)
    return pointed_at


def _centred(text: str, x: float, y: float, colour: theme.Colour) -> None:
    width = imgui.calc_text_size(text).x
    imgui.get_window_draw_list().add_text(imgui.ImVec2(x - width / 2, y), theme.packed(colour), text)
