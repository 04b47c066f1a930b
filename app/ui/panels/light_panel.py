"""The light panel: the light's panorama, its rotation, and the lights to choose from."""

from __future__ import annotations

from imgui_bundle import imgui

from app.engine.sources import LightSource
from app.ui import theme, widgets
from app.ui.light_list import Shelf, lights_to_choose
from app.ui.panels import light_controls, panorama
from app.ui.pictures import Pictures, Shown
from app.ui.state import EditorState
from relight_core.imaging.files import legible

ROTATION = widgets.Slider(
    "Rotation",
    -180.0,
    180.0,
    0.0,
    "%.0f°",
    "Turns the light around the person; positive moves the panorama to the right,\n"
    "and a lamp in front of the person to the left.",
    wraps=True,
)
_LOWEST_EM = 16.0
"""In a panel that is lower than this below its panorama all of it scrolls, and not the lights alone."""

_COLUMNS = 3
_WIDE_EM, _HIGH_EM = 6.0, 4.75
"""From this width on there are more columns of lights; none is higher than that."""


def draw(state: EditorState, fonts: theme.Fonts, pictures: Pictures, shelf: Shelf) -> None:
    """The panel's contents, inside its window."""
    room, em = imgui.get_content_region_avail(), imgui.get_font_size()
    if room.y >= room.x / 2 + _LOWEST_EM * em:
        _tools(state, fonts, pictures)
        with widgets.scrolling("lights"):
            _choices(state, fonts, pictures, shelf)
    else:
        with widgets.scrolling("panel"):
            _tools(state, fonts, pictures)
            _choices(state, fonts, pictures, shelf)


def _tools(state: EditorState, fonts: theme.Fonts, pictures: Pictures) -> None:
    """What stays in sight while the rest scrolls: the panorama, and what adds lamps and turns the light."""
    widgets.heading(fonts, "Light")
    panorama.draw(state, pictures)
    light_controls.tools(state)
    state.change(yaw_deg=widgets.slider(state, ROTATION, state.edit.yaw_deg))
    label = "Stop" if state.playing else "Play the rotation"
    imgui.begin_disabled(state.snapshot.picture is None and not state.playing)
    if widgets.toggle(label, state.playing, imgui.get_content_region_avail().x):
        state.playing = not state.playing
    imgui.end_disabled()
    imgui.set_item_tooltip("The light turns by itself; save it as a film under Export, Turntable.  P")


def _choices(state: EditorState, fonts: theme.Fonts, pictures: Pictures, shelf: Shelf) -> None:
    light_controls.box(state, fonts)
    light_controls.light(state, fonts)
    _lights(state, pictures, shelf)


def _lights(state: EditorState, pictures: Pictures, shelf: Shelf) -> None:
    room = imgui.get_content_region_avail().x
    columns = max(_COLUMNS, int(room // (_WIDE_EM * imgui.get_font_size())))
    width = room / columns
    for index, (source, description) in enumerate(lights_to_choose(state, shelf)):
        if index % columns:
            imgui.same_line(0.0, 0.0)
        _light_button(state, pictures, source, description, width)


def _light_button(state: EditorState, pictures: Pictures, source: LightSource, description: str, width: float) -> None:
    em = imgui.get_font_size()
    corner = imgui.get_cursor_screen_pos()
    height = min(width, _HIGH_EM * em)
    if imgui.invisible_button(legible(f"{source.kind}:{source.name}"), imgui.ImVec2(width, height)):
        state.choose_light(source)
    if source in state.extra_lights and imgui.is_item_clicked(1):
        state.forget_light(source)
    imgui.set_item_tooltip(tooltip(state, source, description))
    chosen = source.same_as(state.light)
    draw = imgui.get_window_draw_list()
    if chosen or imgui.is_item_hovered():
        inside = imgui.ImVec2(corner.x + 2, corner.y), imgui.ImVec2(corner.x + width - 2, corner.y + height)
        draw.add_rect_filled(*inside, theme.packed(theme.HOVERED if chosen else theme.RAISED), 6.0)
    _ball(pictures.ball(source), corner, width, height - 1.9 * em)
    imgui.push_font(None, 0.86 * theme.FONT_PX)
    title = widgets.shortened(source.title, width - 8.0)
    text_x = corner.x + (width - imgui.calc_text_size(title).x) / 2
    colour = theme.ACCENT if chosen else theme.TEXT
    draw.add_text(imgui.ImVec2(text_x, corner.y + height - 1.25 * em), theme.packed(colour), title)
    imgui.pop_font()


def tooltip(state: EditorState, light: LightSource, words: str) -> str:
    """What is read of a light in the list while the mouse is on it."""
    can_go = light in state.extra_lights and not light.same_as(state.light)
    said = f"{words} Right-click takes it off this list." if can_go else words
    return f"{light.title}\n{said}" if said else light.title


def _ball(shown: Shown | None, corner: imgui.ImVec2, width: float, side: float) -> None:
    x, y = corner.x + (width - side) / 2, corner.y + 0.3 * imgui.get_font_size()
    if shown is not None:
        widgets.draw_image(shown, x, y, side, side)
        return
    centre = imgui.ImVec2(x + side / 2, y + side / 2)
    imgui.get_window_draw_list().add_circle(centre, side / 2 - 1, theme.packed(theme.TRACK), 32)
