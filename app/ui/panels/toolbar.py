"""The bar over the picture: opening and saving, comparing, what is shown about the picture, and its zoom."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from imgui_bundle import imgui

from app.ui import theme
from app.ui.actions import brush_actions, face_actions, look_actions
from app.ui.actions.action import Action, has_photo, has_picture
from app.ui.panels.groups import arrow
from app.ui.state import EditorState
from app.ui.viewport.panes import can_compare
from app.ui.viewport.view import View
from app.ui.viewport.viewport_panel import fit, toggle_actual_size

_PADDING_EM, _APART_EM = 0.55, 0.25
_BETWEEN_GROUPS_EM = 1.2


@dataclass(frozen=True)
class _Button:
    """One word of the bar.

    Attributes:
        help: a sentence on it.
        key: as it is written on the keyboard.
        act: what a click does.
        is_on: it looks pressed.
        held: what is done in every frame in which the button is down.
        available: else it is greyed.
    """

    label: str
    help: str
    key: str
    act: Callable[[EditorState], None] = lambda state: None
    is_on: Callable[[EditorState], bool] = lambda state: False
    held: Callable[[EditorState], None] | None = None
    available: Callable[[EditorState], bool] = lambda state: True


def _comparing(label: str, help: str, key: str, value: str) -> _Button:
    return _Button(
        label,
        help,
        key,
        lambda state: state.look.choose("compare", value),
        lambda state: state.look.compare == value,
        available=can_compare,
    )


def _see_the_photo(state: EditorState) -> None:
    state.before = True


def _full_size(state: EditorState) -> None:
    if state.view.fit:
        toggle_actual_size(state)
    else:
        state.view = View(False, 1.0, state.view.centre_x, state.view.centre_y)


_FILES = (
    _Button("Open…", "A portrait, a panorama or a session.", "Ctrl + O", lambda state: state.asking.wish("open_file")),
    _Button(
        "Save",
        "The work as a session beside the photo, to go on later.",
        "Ctrl + S",
        lambda state: state.asking.wish("save_session"),
        available=has_photo,
    ),
)
_COMPARING = (
    _Button("Before", "Hold to see the photo as it was.", "Space", held=_see_the_photo, available=has_picture),
    _comparing("Wipe", "A line to drag: the photo left of it, the picture right of it.", "W", "wipe"),
    _comparing("Side by side", "The photo beside the picture.", "Y", "side"),
)
_ZOOM = (
    _Button("Fit", "The whole picture.", "F", fit, lambda state: state.view.fit, available=has_photo),
    _Button("100 %", "One photo pixel on one screen pixel.", "Z", _full_size, available=has_photo),
)
_CLICKED = tuple(button for button in (*_FILES, *_COMPARING, *_ZOOM) if button.held is None)
"""Those that are as good in a menu as in the bar."""

_MENU = "Show"


def draw(state: EditorState) -> None:
    """The bar's contents, inside its window."""
    em = imgui.get_font_size()
    room, start = imgui.get_content_region_avail().x, imgui.get_cursor_pos()
    menu_width = _width(_MENU) + 0.9 * em
    right_width = menu_width + _APART_EM * em + _group_width(_ZOOM)
    left, right = _FILES, _ZOOM
    if _group_width(left) + _group_width(_COMPARING) + right_width + 2 * _BETWEEN_GROUPS_EM * em > room:
        left = ()
    if _group_width(_COMPARING) + right_width + _BETWEEN_GROUPS_EM * em > room:
        right, right_width = (), menu_width
    comparing = _COMPARING
    while comparing and _group_width(comparing) + right_width > room:
        comparing = comparing[:-1]
    _group(state, left, start.x, start.y)
    first = _group_width(left) + _BETWEEN_GROUPS_EM * em if left else 0.0
    last = room - right_width - _group_width(comparing) - _BETWEEN_GROUPS_EM * em
    _group(state, comparing, start.x + max(first, min((room - _group_width(comparing)) / 2, last)), start.y)
    x = start.x + max(0.0, room - right_width)
    in_bar = (*left, *comparing, *right)
    _menu(state, x, start.y, menu_width, [button for button in _CLICKED if button not in in_bar])
    _group(state, right, x + menu_width + _APART_EM * em, start.y)


def _width(label: str) -> float:
    return imgui.calc_text_size(label).x + 2.0 * _PADDING_EM * imgui.get_font_size()


def _group_width(buttons: tuple[_Button, ...]) -> float:
    apart = _APART_EM * imgui.get_font_size() * max(0, len(buttons) - 1)
    return sum(_width(button.label) for button in buttons) + apart


def _group(state: EditorState, buttons: tuple[_Button, ...], x: float, y: float) -> None:
    for button in buttons:
        imgui.set_cursor_pos(imgui.ImVec2(x, y))
        imgui.begin_disabled(not button.available(state))
        if _flat(button.label, _width(button.label), button.is_on(state)):
            button.act(state)
        if button.held is not None and imgui.is_item_active():
            button.held(state)
        imgui.end_disabled()
        imgui.set_item_tooltip(f"{button.help}  {button.key}")
        x += _width(button.label) + _APART_EM * imgui.get_font_size()


def _flat(label: str, width: float, down: bool) -> bool:
    """A button without a face until the mouse is on it, or it is down."""
    face = theme.PRESSED if down else (0.0, 0.0, 0.0, 0.0)
    imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(*face))
    imgui.push_style_var(imgui.StyleVar_.frame_padding, imgui.ImVec2(0.0, 0.2 * imgui.get_font_size()))
    clicked = imgui.button(label, imgui.ImVec2(width, 0.0))
    imgui.pop_style_var()
    imgui.pop_style_color()
    return clicked


def _menu(state: EditorState, x: float, y: float, width: float, left_out: list[_Button]) -> None:
    """What is shown, below the buttons that the bar has no room for."""
    em = imgui.get_font_size()
    imgui.set_cursor_pos(imgui.ImVec2(x, y))
    corner = imgui.get_cursor_screen_pos()
    if _flat("##show", width, imgui.is_popup_open("show")):
        imgui.open_popup("show")
    imgui.set_item_tooltip("Histogram, pixel values, clipping and more, and the panels.")
    below = imgui.ImVec2(imgui.get_item_rect_min().x, imgui.get_item_rect_max().y + 2.0)
    draw = imgui.get_window_draw_list()
    draw.add_text(imgui.ImVec2(corner.x + _PADDING_EM * em, corner.y + 0.2 * em), theme.packed(theme.TEXT), _MENU)
    arrow(draw, corner.x + width - 0.85 * em, corner.y + 0.72 * em, 0.22 * em, is_open=True)
    imgui.set_next_window_pos(below)
    if imgui.begin_popup("show"):
        _left_out(state, left_out)
        _entries(state, look_actions.READING)
        imgui.separator()
        _entries(state, look_actions.PANELS)
        imgui.separator()
        _entries(state, look_actions.ARRANGING)
        imgui.separator()
        _entries(state, (*face_actions.FACES[:1], *brush_actions.OUTLINE[:1]))
        imgui.end_popup()


def _left_out(state: EditorState, buttons: list[_Button]) -> None:
    for button in buttons:
        if imgui.menu_item(button.label, button.key, button.is_on(state), button.available(state))[0]:
            button.act(state)
        imgui.set_item_tooltip(button.help)
    if buttons:
        imgui.separator()


def _entries(state: EditorState, actions: tuple[Action, ...]) -> None:
    for action in actions:
        on = action.is_on is not None and action.is_on(state)
        if imgui.menu_item(action.name, action.label, on, action.available(state))[0]:
            action.run(state)
        imgui.set_item_tooltip(f"{action.help}.")
