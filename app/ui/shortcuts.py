"""Keys that work wherever the mouse is, unless a number or a path is being typed."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui.state import CHANNELS, EditorState
from app.ui.view import View
from app.ui.viewport_panel import ZOOM_PER_STEP, zoom_by

_NUMBERS = [getattr(imgui.Key, f"_{number}") for number in range(1, 10)]
_KEYPAD = [getattr(imgui.Key, f"keypad{number}") for number in range(1, 10)]


def apply(state: EditorState, viewport: tuple[int, int]) -> None:
    """Act on the keys of this frame; `viewport` is its size in framebuffer pixels."""
    io = imgui.get_io()
    typing = io.want_text_input
    state.before = imgui.is_key_down(imgui.Key.space) and not typing
    if typing or io.key_ctrl or io.key_alt or io.key_super:
        return
    _choose_channel(state)
    _look(state, viewport)
    if _pressed(imgui.Key.e) and state.snapshot.picture:
        state.export_wanted = ".exr" if io.key_shift else ".png"
    step = 1.0 if io.key_shift else 5.0
    if imgui.is_key_pressed(imgui.Key.left_arrow):
        state.turn(-step)
    if imgui.is_key_pressed(imgui.Key.right_arrow):
        state.turn(step)
    if _pressed(imgui.Key.escape) and state.snapshot.message:
        state.dismissed = state.snapshot.message.number


def _choose_channel(state: EditorState) -> None:
    if state.snapshot.picture is None:
        return
    for index, (name, _, _) in enumerate(CHANNELS):
        if _pressed(_NUMBERS[index]) or _pressed(_KEYPAD[index]):
            state.shown = name


def _look(state: EditorState, viewport: tuple[int, int]) -> None:
    if _pressed(imgui.Key.f):
        state.view = View()
    if imgui.is_key_pressed(imgui.Key.equal) or imgui.is_key_pressed(imgui.Key.keypad_add):
        zoom_by(state, ZOOM_PER_STEP, viewport)
    if imgui.is_key_pressed(imgui.Key.minus) or imgui.is_key_pressed(imgui.Key.keypad_subtract):
        zoom_by(state, 1.0 / ZOOM_PER_STEP, viewport)


def _pressed(key: imgui.Key) -> bool:
    return imgui.is_key_pressed(key, False)
