"""The few controls the panels are made of."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from imgui_bundle import imgui

from app.ui import theme
from app.ui.angles import wrap_degrees
from app.ui.layout import Rect
from app.ui.pictures import Shown
from app.ui.state import EditorState
from relight_core.imaging.files import legible
from relight_core.pipeline.edit import is_plain_colour

_NARROW_PADDING = 1.0
_TYPED_FORM = "%.2f"
_TYPED_FLAGS = imgui.InputTextFlags_.auto_select_all | imgui.InputTextFlags_.enter_returns_true


@dataclass(frozen=True)
class Slider:
    """One number the user sets.

    Attributes:
        label: its name in the panel, unique.
        low, high: the ends of the track; numbers typed in are limited to them too, or wrapped.
        rest: where a double click brings it back to, and where its bar grows from.
        form: printf form of the number, with its unit.
        help: what it does, in plain words.
        wraps: it is an angle in degrees, of which a number past an end of the track is another turn.
    """

    label: str
    low: float
    high: float
    rest: float
    form: str
    help: str
    wraps: bool = False

    def taken(self, number: float) -> float:
        """A number that was typed in, on the track."""
        if self.wraps and math.isfinite(number) and not self.low <= number <= self.high:
            return wrap_degrees(number)
        return min(max(number, self.low), self.high)


def heading(fonts: theme.Fonts, text: str) -> None:
    """The title of a group of controls."""
    imgui.push_font(fonts.bold, 0.0)
    imgui.text(text)
    imgui.pop_font()


def path_input(
    path: str, flags: int, callback: Callable[[imgui.InputTextCallbackData], int] | None = None
) -> tuple[bool, str]:
    """A line for the path of a file, and the path afterwards; a name that is no text stays while it is not touched."""
    drawn = legible(path)
    # Tab out of a slider's number would begin to type here, and the next keys would be the file's name.
    imgui.push_item_flag(imgui.ItemFlags_.no_tab_stop, True)
    entered, typed = imgui.input_text("##path", drawn, flags, callback)
    imgui.pop_item_flag()
    return entered, path if typed == drawn else typed


def gap(em: float) -> None:
    """Empty room, in font heights."""
    imgui.dummy(imgui.ImVec2(1.0, em * imgui.get_font_size()))


def slider(state: EditorState, spec: Slider, value: float) -> float:
    """Draw a slider and return its value.

    A double click resets it; a Ctrl-click on the track or a click on the number lets one type it.
    """
    imgui.push_id(spec.label)
    row = _typed if state.typing == spec.label else _title_row
    spacing = imgui.get_style().item_spacing
    imgui.push_style_var(imgui.StyleVar_.item_spacing, imgui.ImVec2(spacing.x, 0.25 * spacing.y))
    value = row(state, spec, value)
    value = _track(state, spec, value)
    imgui.pop_style_var()
    imgui.pop_id()
    return value


def _title_row(state: EditorState, spec: Slider, value: float) -> float:
    shown = (spec.form % value).replace("-", "\N{MINUS SIGN}")
    left = imgui.get_cursor_screen_pos()
    width = imgui.get_content_region_avail().x
    text_width = imgui.calc_text_size(shown).x
    imgui.text_disabled(shortened(spec.label, width - text_width - 0.4 * imgui.get_font_size()))
    imgui.set_item_tooltip(spec.help)
    imgui.set_cursor_screen_pos(imgui.ImVec2(left.x + width - text_width, left.y))
    if imgui.invisible_button("number", imgui.ImVec2(text_width, imgui.get_text_line_height())):
        begin_typing(state, spec.label)
    hovered = imgui.is_item_hovered()
    if hovered:
        imgui.set_mouse_cursor(imgui.MouseCursor_.text_input)
    imgui.set_item_tooltip("Click to type a number.")
    colour = theme.ACCENT if hovered else theme.TEXT
    imgui.get_window_draw_list().add_text(
        imgui.ImVec2(left.x + width - text_width, left.y), theme.packed(colour), shown
    )
    return value


def begin_typing(state: EditorState, label: str) -> None:
    """Start typing a slider's number, a swatch's colour or a line of `keyboard_for` in the next frame.

    It has no effect if the control with this label is not drawn then (see `forget_lost_typing`).
    """
    state.typing, state.typing_began, state.typing_seen = label, True, True


@contextmanager
def keyboard_for(state: EditorState, label: str) -> Iterator[None]:
    """Around a line that can always be typed in: gives it the keyboard after `begin_typing` with this label."""
    if state.typing == label:
        state.typing_seen = True
        imgui.set_keyboard_focus_here()
    yield
    if state.typing == label and imgui.is_item_active():
        state.typing = None


def forget_lost_typing(state: EditorState) -> None:
    """At the end of a frame: stop typing into a control that was not drawn, such as one of a deleted lamp."""
    if not state.typing_seen:
        state.typing = None
    state.typing_seen = False


def _typed(state: EditorState, spec: Slider, value: float) -> float:
    imgui.text_disabled(spec.label)
    imgui.same_line()
    imgui.set_next_item_width(imgui.get_content_region_avail().x)
    imgui.push_style_var(imgui.StyleVar_.frame_padding, imgui.ImVec2(4.0, 0.0))
    began = _typing_begins(state)
    _, new = imgui.input_float("##typed", value, 0.0, 0.0, _TYPED_FORM, _TYPED_FLAGS)
    imgui.pop_style_var()
    # A number that was not changed must neither be rounded to the digits shown nor be clamped to the track.
    untouched = new != new or _TYPED_FORM % new == _TYPED_FORM % value
    if _typing_is_done(state, began) and not untouched:
        value = spec.taken(new)
    return value


def _typing_begins(state: EditorState) -> bool:
    """To be called before the input line; whether it asks for the keyboard in this frame."""
    state.typing_seen = True
    if state.typing_began:
        imgui.set_keyboard_focus_here()
    return state.typing_began


def _typing_is_done(state: EditorState, began: bool) -> bool:
    """To be called after the input line; whether its text was accepted, by Enter, Tab or a click elsewhere, not Esc.

    Args:
        began: what `_typing_begins` returned.
    """
    if imgui.is_item_active() and imgui.is_key_pressed(imgui.Key.tab, False):
        for down in (True, False):
            imgui.get_io().add_key_event(imgui.Key.enter, down)
    # The line gets the keyboard only some frames after asking for it, later still in a panel that is just opening.
    state.typing_began = began and not imgui.is_item_active()
    is_left = not began and imgui.is_item_deactivated()
    if is_left or not (began or imgui.is_item_active() or imgui.is_item_focused()):
        state.typing = None
    return is_left and not imgui.is_key_pressed(imgui.Key.escape)


def typed_colour(state: EditorState, colour: Sequence[float]) -> tuple[float, ...] | None:
    """Input for "#rrggbb", drawn in place of a swatch while `state.typing` is its label; None until it is typed.

    Args:
        colour: what the line begins with; red, green and blue in [0, 1], as what is returned.
    """
    shown = hex_of(colour)
    imgui.set_next_item_width(imgui.get_content_region_avail().x)
    began = _typing_begins(state)
    _, typed = imgui.input_text("##colour", shown, _TYPED_FLAGS)
    digits = typed.strip().removeprefix("#")
    if not _typing_is_done(state, began) or typed == shown or not digits:
        return None
    if not is_plain_colour(f"#{digits}"):
        state.asking.tell(f"{typed} is no colour; type one like #30343a: red, green and blue from 00 to ff", True)
        return None
    return tuple(value / 255 for value in bytes.fromhex(digits))


def hex_of(colour: Sequence[float]) -> str:
    """Red, green and blue in [0, 1] as "#rrggbb"."""
    return "#" + "".join(f"{round(value * 255):02x}" for value in colour)


def _track(state: EditorState, spec: Slider, value: float) -> float:
    em = imgui.get_font_size()
    left = imgui.get_cursor_screen_pos()
    width, height = imgui.get_content_region_avail().x, 1.1 * em
    radius = 0.42 * em
    imgui.invisible_button("track", imgui.ImVec2(width, height))
    hovered, active = imgui.is_item_hovered(), imgui.is_item_active()
    imgui.set_item_tooltip(f"{spec.help}\nDouble-click to reset, Ctrl-click to type a number.")
    if imgui.is_item_activated() and imgui.get_io().key_ctrl:
        begin_typing(state, spec.label)
        imgui.internal.clear_active_id()
    elif hovered and imgui.is_mouse_double_clicked(0):
        imgui.internal.clear_active_id()
        value = spec.rest
    elif active:
        state.hand_on_control = True
        value = _held(state, spec, value, left.x + radius, width - 2 * radius, radius)
    _draw_track(spec, value, left, width, height, radius, lit=hovered or active)
    return value


def _held(state: EditorState, spec: Slider, value: float, start: float, length: float, radius: float) -> float:
    """The value while the mouse holds the track, whose knob goes from `start` so far: it comes to a press beside it.

    No hand meets the knob's very middle: a click on it moves nothing, and it is dragged by where it was met.
    """
    if imgui.is_item_activated():
        state.off_knob = imgui.get_io().mouse_pos.x - start - _along(spec, value) * length
        if abs(state.off_knob) < radius:
            return value
        state.off_knob = 0.0
    elif not imgui.get_io().mouse_delta.x:
        return value
    along = (imgui.get_io().mouse_pos.x - state.off_knob - start) / max(1.0, length)
    return _snapped(spec, spec.low + (spec.high - spec.low) * min(max(along, 0.0), 1.0))


def _along(spec: Slider, value: float) -> float:
    """The knob's position from 0 to 1 along the track; values from files may lie beyond the track's ends."""
    return (min(max(value, spec.low), spec.high) - spec.low) / (spec.high - spec.low)


def _snapped(spec: Slider, value: float) -> float:
    """The value, or the resting value if that is less than a hundredth of the track away."""
    return spec.rest if abs(value - spec.rest) < 0.01 * (spec.high - spec.low) else value


def _draw_track(
    spec: Slider, value: float, left: imgui.ImVec2, width: float, height: float, radius: float, lit: bool
) -> None:
    draw = imgui.get_window_draw_list()
    middle, thick = left.y + height / 2, max(1.5, 0.1 * height)

    def at(number: float) -> float:
        return left.x + radius + _along(spec, number) * (width - 2 * radius)

    def bar(x0: float, x1: float, colour: theme.Colour) -> None:
        top, bottom = imgui.ImVec2(min(x0, x1), middle - thick), imgui.ImVec2(max(x0, x1), middle + thick)
        draw.add_rect_filled(top, bottom, theme.packed(colour), thick)

    bar(left.x, left.x + width, theme.TRACK)
    bar(at(spec.rest), at(value), theme.ACCENT)
    rest, reach = at(spec.rest), 2.2 * thick
    draw.add_line((rest, middle - reach), (rest, middle + reach), theme.packed(theme.FAINT))
    knob = theme.TEXT if lit else (0.76, 0.76, 0.76, 1.0)
    draw.add_circle_filled(imgui.ImVec2(at(value), middle), radius, theme.packed(knob), 24)


def swatch(
    state: EditorState, label: str, colour: Sequence[float], help: str, *, in_bytes: bool = False
) -> tuple[float, ...] | None:
    """A square of a colour that opens a picker; the colour while it is being picked, else None.

    Args:
        label: unique.
        colour: red, green and blue in [0, 1].
        in_bytes: numbers are shown from 0 to 255, and not from 0 to 1.

    Returns:
        In [0, 1]: the picker takes any number that is typed.
    """
    flags = imgui.ColorEditFlags_.no_inputs | imgui.ColorEditFlags_.no_label | imgui.ColorEditFlags_.no_tooltip
    kind = imgui.ColorEditFlags_.uint8 if in_bytes else imgui.ColorEditFlags_.float
    changed, picked = imgui.color_edit3(label, list(colour), flags | kind)
    if imgui.is_item_active():
        state.hand_on_control = True
    imgui.set_item_tooltip(help)
    return tuple(min(max(float(value), 0.0), 1.0) for value in picked) if changed else None


def segmented(
    choices: Sequence[tuple[str, str, str]], chosen: str, width: float | None = None, most_in_row: int | None = None
) -> str:
    """A row of buttons of which one is down, or several such rows.

    Args:
        choices: (value, label, tooltip) each.
        chosen: the value that is down.
        width: of the row; None takes all there is.
        most_in_row: the others go into further rows; None has all in one where that has room for their words.

    Returns:
        The value that is down now.
    """
    spacing = 2.0
    in_row = min(len(choices), most_in_row or len(choices))
    room = width or imgui.get_content_region_avail().x
    widest = max((label for _, label, _ in choices), key=lambda label: imgui.calc_text_size(label).x)
    while most_in_row is None and in_row > 1 and not fit_in_row([widest] * in_row, room, spacing)[0]:
        in_row = (in_row + 1) // 2
    width = (room - spacing * (in_row - 1)) / in_row
    for index, (value, label, tooltip) in enumerate(choices):
        if index % in_row:
            imgui.same_line(0.0, spacing)
        with narrow_buttons():
            if toggle(label, value == chosen, width, one_of_many=True):
                chosen = value
        imgui.set_item_tooltip(tooltip)
    return chosen


@contextmanager
def narrow_buttons() -> Iterator[None]:
    """Buttons with hardly any room beside their words, so that these are not cut where the panel is narrow."""
    padding = imgui.ImVec2(_NARROW_PADDING, imgui.get_style().frame_padding.y)
    imgui.push_style_var(imgui.StyleVar_.frame_padding, padding)
    yield
    imgui.pop_style_var()


def fit_in_row(labels: Sequence[str], room: float, spacing: float) -> tuple[bool, float]:
    """Whether equal `narrow_buttons` of these labels fit in a row, and the width of each: its part or all the room.

    All lengths are in window units; buttons that don't fit in a row are to be placed below one another.
    """
    width = (room - spacing * (len(labels) - 1)) / max(1, len(labels))
    fits = all(imgui.calc_text_size(label).x + 2.0 * _NARROW_PADDING <= width for label in labels)
    return (True, width) if fits else (False, room)


def toggle(label: str, down: bool, width: float, *, one_of_many: bool = False) -> bool:
    """A button that looks pressed while `down`; True when it is clicked.

    Among others, of which one is down, those that are not are dimmed; one by itself would look as if it couldn't be
    clicked.
    """
    background = theme.PRESSED if down else theme.RAISED
    words = theme.DIM if one_of_many and not down else theme.TEXT
    imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(*background))
    imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*words))
    clicked = imgui.button(label, imgui.ImVec2(width, 0.0))
    imgui.pop_style_color(2)
    return clicked


@contextmanager
def scrolling(name: str) -> Iterator[None]:
    """What scrolls, over all the room there is; as wide with a scroll bar as without, so that nothing jumps aside."""
    kept, key = imgui.get_state_storage(), imgui.get_id(name)
    colours = () if kept.get_bool(key, True) else (imgui.Col_.scrollbar_grab, imgui.Col_.scrollbar_grab_hovered)
    for colour in colours:
        imgui.push_style_color(colour, imgui.ImVec4(0.0, 0.0, 0.0, 0.0))
    imgui.begin_child(name, imgui.ImVec2(0.0, 0.0), 0, imgui.WindowFlags_.always_vertical_scrollbar)
    imgui.pop_style_color(len(colours))
    kept.set_bool(key, imgui.get_scroll_max_y() > 0.0)
    yield
    imgui.end_child()


def shade(draw: imgui.ImDrawList, place: Rect, opacity: float) -> None:
    """The dark behind words over the picture."""
    x0, y0, x1, y1 = place.corners
    rounding = 0.27 * imgui.get_font_size()
    draw.add_rect_filled(imgui.ImVec2(x0, y0), imgui.ImVec2(x1, y1), theme.packed(theme.SHADE, opacity), rounding)


def draw_image(shown: Shown, x: float, y: float, width: float, height: float, rounding: float = 0.0) -> None:
    """A texture in a rectangle of the window."""
    imgui.get_window_draw_list().add_image_rounded(
        imgui.ImTextureRef(shown.number),
        imgui.ImVec2(x, y),
        imgui.ImVec2(x + width, y + height),
        imgui.ImVec2(0.0, 0.0),
        imgui.ImVec2(1.0, 1.0),
        theme.packed((1.0, 1.0, 1.0, 1.0)),
        rounding,
    )


def shortened(text: str, width: float) -> str:
    """The text, its end replaced by an ellipsis where it is wider than `width`."""
    if imgui.calc_text_size(text).x <= width:
        return text
    while text and imgui.calc_text_size(text + "…").x > width:
        text = text[:-1]
    return text.rstrip() + "…"
