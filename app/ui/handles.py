"""Invisible windows over the panels that can be grabbed: what dividers and grips have in common."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from imgui_bundle import imgui

_FLAGS = (
    imgui.WindowFlags_.no_decoration
    | imgui.WindowFlags_.no_background
    | imgui.WindowFlags_.no_move
    | imgui.WindowFlags_.no_saved_settings
    | imgui.WindowFlags_.no_nav
)


@dataclass(frozen=True)
class Touch:
    """What the mouse does to a handle: it is over it, it drags it, it pressed it twice."""

    hovered: bool
    active: bool
    twice: bool


@contextmanager
def handle(name: str, x: float, y: float, size: imgui.ImVec2) -> Iterator[Touch]:
    """A place of the window, in pixels, that takes the mouse; it is drawn, and asked for more, in the block.

    A second press belongs to the first: it grabs nothing.
    """
    imgui.set_next_window_pos(imgui.ImVec2(x, y))
    imgui.set_next_window_size(size)
    imgui.push_style_var(imgui.StyleVar_.window_padding, imgui.ImVec2(0.0, 0.0))
    imgui.push_style_var(imgui.StyleVar_.window_min_size, imgui.ImVec2(1.0, 1.0))
    imgui.begin(name, None, _FLAGS)
    imgui.pop_style_var(2)
    imgui.invisible_button("handle", size)
    hovered, active = imgui.is_item_hovered(), imgui.is_item_active()
    twice = hovered and imgui.is_mouse_double_clicked(0)
    if twice:
        imgui.internal.clear_active_id()
    yield Touch(hovered, active, twice)
    imgui.end()
