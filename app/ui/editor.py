"""One frame of the editor: lays out the panels and lets each read and write the state."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from imgui_bundle import imgui

from app.ui import dividers, file_picker, grips, theme, widgets
from app.ui.actions import help_overlay, palette, shortcuts
from app.ui.layout import Layout, Rect, arrange
from app.ui.light_list import Shelf
from app.ui.panels import effects_panel, filmstrip, light_panel, scope_panel, status_line, toolbar
from app.ui.pictures import Pictures
from app.ui.state import EditorState
from app.ui.viewport import brush_card, face_card, progress_card, questions, viewport_panel

_FLAGS = (
    # Drawn on the cleared window: without a GPU, filling every panel once more is a third of a frame.
    imgui.WindowFlags_.no_background
    | imgui.WindowFlags_.no_decoration
    | imgui.WindowFlags_.no_move
    | imgui.WindowFlags_.no_saved_settings
    | imgui.WindowFlags_.no_bring_to_front_on_focus
    | imgui.WindowFlags_.no_nav
    | imgui.WindowFlags_.no_scroll_with_mouse
)

_TOOLTIP_S, _NEVER_S = 0.15, 1e9


def draw(state: EditorState, fonts: theme.Fonts, pictures: Pictures, shelf: Shelf) -> None:
    """Draw every panel; between new_frame and render."""
    io = imgui.get_io()
    state.hand_on_control = False
    shortcuts.apply(state)
    progress_card.play(state)
    # A tooltip of what the mouse was left on would lie over what is typed in now.
    imgui.get_style().hover_delay_short = _NEVER_S if state.picking or state.look.palette else _TOOLTIP_S
    scope = state.look.scope != "off"
    layout = arrange(io.display_size.x, io.display_size.y, imgui.get_font_size(), state.panels, scope)
    state.light_panel = layout.light.corners if layout.light else (0.0, 0.0, 0.0, 0.0)
    _sides(state, fonts, pictures, shelf, layout)
    if layout.toolbar:
        with _panel("toolbar", layout.toolbar, padding=(8.0, 5.0)):
            toolbar.draw(state)
    with _panel("viewport", layout.viewport, padding=(0.0, 0.0)):
        viewport_panel.draw(state, fonts, pictures, layout.viewport)
    if layout.filmstrip:
        with _panel("filmstrip", layout.filmstrip, padding=(14.0, 7.0)):
            filmstrip.draw(state, pictures)
    with _panel("status", layout.status, padding=(14.0, 5.0)):
        status_line.draw(state)
    dividers.draw(state, layout)
    grips.draw(state, layout)
    questions.draw(state, layout.viewport)
    progress_card.draw(state, layout.viewport)
    face_card.draw(state, layout.viewport)
    brush_card.draw(state, layout.viewport)
    file_picker.draw(state, fonts)
    whole = Rect(0.0, 0.0, io.display_size.x, io.display_size.y)
    help_overlay.draw(state, fonts, whole)
    palette.draw(state, shelf, whole)
    widgets.forget_lost_typing(state)


def _sides(state: EditorState, fonts: theme.Fonts, pictures: Pictures, shelf: Shelf, layout: Layout) -> None:
    if layout.light:
        with _panel("light", layout.light):
            light_panel.draw(state, fonts, pictures, shelf)
    if layout.scope:
        with _panel("scope", layout.scope, padding=(14.0, 10.0)):
            scope_panel.draw(state, pictures)
    if layout.effects:
        with _panel("effects", layout.effects), widgets.scrolling("controls"):
            effects_panel.draw(state, fonts)


@contextmanager
def _panel(name: str, rect: Rect, padding: tuple[float, float] | None = None) -> Iterator[None]:
    imgui.set_next_window_pos(imgui.ImVec2(rect.x, rect.y))
    imgui.set_next_window_size(imgui.ImVec2(rect.width, rect.height))
    if padding is not None:
        scale = imgui.get_font_size() / theme.FONT_PX
        scaled = imgui.ImVec2(padding[0] * scale, padding[1] * scale)
        imgui.push_style_var(imgui.StyleVar_.window_padding, scaled)
    imgui.push_style_var(imgui.StyleVar_.window_min_size, imgui.ImVec2(1.0, 1.0))
    imgui.begin(name, None, _FLAGS)
    imgui.pop_style_var()
    if padding is not None:
        imgui.pop_style_var()
    yield
    imgui.end()
