"""Dark and quiet: neutral greys, so that nothing but the photo has colour, and one warm accent."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from imgui_bundle import imgui

from relight_core.resources import resource_path

FONT_PX = 15.0

Colour = tuple[float, float, float, float]

CANVAS_SRGB = (0.088, 0.088, 0.088)
CANVAS: Colour = (*CANVAS_SRGB, 1.0)
"""Behind pictures and scopes."""

PANEL: Colour = (0.135, 0.135, 0.135, 1.0)
RAISED: Colour = (0.19, 0.19, 0.19, 1.0)
HOVERED: Colour = (0.25, 0.25, 0.25, 1.0)
PRESSED: Colour = (0.31, 0.31, 0.31, 1.0)
LINE: Colour = (0.07, 0.07, 0.07, 1.0)
TRACK: Colour = (0.27, 0.27, 0.27, 1.0)
TEXT: Colour = (0.87, 0.87, 0.86, 1.0)
DIM: Colour = (0.60, 0.60, 0.59, 1.0)
FAINT: Colour = (0.42, 0.42, 0.42, 1.0)
ACCENT: Colour = (0.93, 0.67, 0.34, 1.0)
ERROR: Colour = (0.96, 0.52, 0.44, 1.0)
CARD: Colour = (0.17, 0.17, 0.17, 0.98)
SHADE: Colour = (0.05, 0.05, 0.05, 1.0)
"""Behind words over the picture, more or less opaque."""

_CARD_FLAGS = (
    imgui.WindowFlags_.no_decoration
    | imgui.WindowFlags_.no_move
    | imgui.WindowFlags_.no_saved_settings
    | imgui.WindowFlags_.always_auto_resize
    | imgui.WindowFlags_.no_nav
)


@dataclass(frozen=True)
class Fonts:
    """The two weights in use."""

    regular: imgui.ImFont
    bold: imgui.ImFont


def load_fonts() -> Fonts:
    """Add the bundled fonts to the current context."""
    atlas = imgui.get_io().fonts
    regular = atlas.add_font_from_file_ttf(str(resource_path("fonts", "Roboto-Regular.ttf")), FONT_PX)
    bold = atlas.add_font_from_file_ttf(str(resource_path("fonts", "Roboto-Bold.ttf")), FONT_PX)
    return Fonts(regular, bold)


def apply_theme(scale: float) -> None:
    """Set sizes and colours of the current context; `scale` is the display's."""
    style = imgui.get_style()
    style.font_size_base = FONT_PX
    style.font_scale_dpi = scale
    for name, size in _LENGTHS.items():
        setattr(style, name, size * scale)
    for name, (across, down) in _PAIRS.items():
        setattr(style, name, imgui.ImVec2(across * scale, down * scale))
    for name, colour in _COLOURS.items():
        style.set_color_(getattr(imgui.Col_, name), imgui.ImVec4(*colour))
    style.hover_stationary_delay = 0.1


@contextmanager
def card(name: str, flags: int = 0) -> Iterator[None]:
    """A window of its own over the picture, where and as wide as the next window was set to be.

    Args:
        name: unique.
        flags: of the window, beside those of every card.
    """
    imgui.push_style_color(imgui.Col_.window_bg, imgui.ImVec4(*CARD))
    imgui.push_style_var(imgui.StyleVar_.window_rounding, 6.0)
    imgui.push_style_var(imgui.StyleVar_.window_border_size, 1.0)
    imgui.begin(name, None, _CARD_FLAGS | flags)
    yield
    imgui.end()
    imgui.pop_style_var(2)
    imgui.pop_style_color()


def packed(colour: Colour, opacity: float = 1.0) -> int:
    """A colour as draw lists take it."""
    red, green, blue, alpha = colour
    return imgui.get_color_u32(imgui.ImVec4(red, green, blue, alpha * opacity))


_LENGTHS = {
    "window_rounding": 0.0,
    "window_border_size": 0.0,
    "child_border_size": 0.0,
    "child_rounding": 4.0,
    "frame_rounding": 4.0,
    "popup_rounding": 4.0,
    "popup_border_size": 1.0,
    "scrollbar_size": 10.0,
    "scrollbar_rounding": 5.0,
}
_PAIRS = {
    "window_padding": (14.0, 12.0),
    "frame_padding": (8.0, 5.0),
    "item_spacing": (8.0, 7.0),
    "item_inner_spacing": (6.0, 4.0),
}
_COLOURS = {
    "text": TEXT,
    "text_disabled": DIM,
    "window_bg": PANEL,
    "child_bg": (0.0, 0.0, 0.0, 0.0),
    "popup_bg": (0.10, 0.10, 0.10, 0.98),
    "border": PRESSED,
    "frame_bg": RAISED,
    "frame_bg_hovered": HOVERED,
    "frame_bg_active": HOVERED,
    "button": RAISED,
    "button_hovered": HOVERED,
    "button_active": PRESSED,
    "check_mark": ACCENT,
    "checkbox_selected_bg": RAISED,
    "header": RAISED,
    "header_hovered": HOVERED,
    "header_active": PRESSED,
    "separator": LINE,
    "scrollbar_bg": (0.0, 0.0, 0.0, 0.0),
    "scrollbar_grab": HOVERED,
    "scrollbar_grab_hovered": PRESSED,
    "scrollbar_grab_active": FAINT,
    "text_selected_bg": (0.93, 0.67, 0.34, 0.35),
}
