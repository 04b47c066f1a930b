"""Dear ImGui itself: its context, its input, its frames."""

from __future__ import annotations

import string
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import glfw
from imgui_bundle import imgui

from app.ui.glfw_keys import KEYS
from app.ui.theme import Fonts, apply_theme, load_fonts

_MODIFIERS = (
    (glfw.MOD_CONTROL, imgui.Key.mod_ctrl, (glfw.KEY_LEFT_CONTROL, glfw.KEY_RIGHT_CONTROL)),
    (glfw.MOD_SHIFT, imgui.Key.mod_shift, (glfw.KEY_LEFT_SHIFT, glfw.KEY_RIGHT_SHIFT)),
    (glfw.MOD_ALT, imgui.Key.mod_alt, (glfw.KEY_LEFT_ALT, glfw.KEY_RIGHT_ALT)),
    (glfw.MOD_SUPER, imgui.Key.mod_super, (glfw.KEY_LEFT_SUPER, glfw.KEY_RIGHT_SUPER)),
)
"""The bit in an event, Dear ImGui's name, and the keys themselves."""
_CURSORS = {
    imgui.MouseCursor_.text_input: glfw.IBEAM_CURSOR,
    imgui.MouseCursor_.resize_ew: glfw.HRESIZE_CURSOR,
    imgui.MouseCursor_.resize_ns: glfw.VRESIZE_CURSOR,
    imgui.MouseCursor_.hand: glfw.HAND_CURSOR,
    imgui.MouseCursor_.resize_all: glfw.RESIZE_ALL_CURSOR,
    imgui.MouseCursor_.resize_nwse: glfw.RESIZE_NWSE_CURSOR,
    imgui.MouseCursor_.resize_nesw: glfw.RESIZE_NESW_CURSOR,
}
_LABELLED = {"+": glfw.KEY_EQUAL, "=": glfw.KEY_EQUAL, "-": glfw.KEY_MINUS}
_LABELLED |= {",": glfw.KEY_COMMA, ".": glfw.KEY_PERIOD}
"""Signs that do something, by what is printed on the keys; "+" and "=" share one on a US keyboard."""
_SHORTEST_FRAME_S = 1e-3


@dataclass(frozen=True)
class _Event:
    """Something the hand did.

    Attributes:
        feed: hands it to Dear ImGui.
        waits: whether it would get lost in the frame to come, beside what that one has got already.
    """

    feed: Callable[[], None]
    waits: Callable[[], bool] = lambda: False


class Binding:
    """A Dear ImGui context for a glfw window.

    Events come from the window; what a frame lists is drawn by app.window.gl_interface. An event that would get lost
    beside others of the same frame waits for the next one, and all after it, so that however long a frame takes, the
    hand's work counts as it was done.

    Args:
        window: the glfw window.
        scale: the display's scale.
    """

    def __init__(self, window: object, scale: float) -> None:
        self._context = imgui.create_context()
        # A new context is not the current one while there is another, such as that of a window not yet closed.
        imgui.set_current_context(self._context)
        self._io = imgui.get_io()
        self._io.set_ini_filename("")
        self._io.set_log_filename("")
        self._io.config_input_trickle_event_queue = True
        self._window = window
        self._last_frame_s = glfw.get_time()
        self._share_the_clipboard()
        self._cursors: dict[int, object] = {}
        self._cursor = glfw.ARROW_CURSOR
        self._held = {modifier: False for _, modifier, _ in _MODIFIERS}
        self._pressed = self._wheeled = self._moved = self._clicked = False
        self._later: list[_Event] = []
        self.fonts: Fonts = load_fonts()
        apply_theme(scale)

    def set_scale(self, scale: float) -> None:
        """Follow a change of the display's scale."""
        apply_theme(scale)

    def key(self, key: int, action: int, mods: int) -> None:
        """A glfw key event; a letter counts as what the keyboard's layout has on that key.

        A modifier let go in the frame in which a key was pressed would make a quick Ctrl + Z a Z, and in that in which
        the wheel was turned, its zoom a turn of the light.
        """
        event = _as_labelled(key), action, mods

        def waits() -> bool:
            return (self._pressed or self._wheeled) and self._modifiers(*event) != self._held

        self._take(_Event(lambda: self._feed(*event), waits))

    def _take(self, event: _Event) -> None:
        if self._later or event.waits():
            self._later.append(event)
        else:
            event.feed()

    def _feed(self, key: int, action: int, mods: int) -> None:
        self._held = self._modifiers(key, action, mods)
        for modifier, held in self._held.items():
            self._io.add_key_event(modifier, held)
        if key in KEYS:
            self._io.add_key_event(KEYS[key], action != glfw.RELEASE)
            self._pressed |= action == glfw.PRESS and not any(key in keys for _, _, keys in _MODIFIERS)

    def _modifiers(self, key: int, action: int, mods: int) -> dict[imgui.Key, bool]:
        """What an event says is held: their own events can be lost to another window."""
        # With a modifier's own event X11 states what was held before it.
        return {
            modifier: action != glfw.RELEASE if key in keys else bool(mods & bit) for bit, modifier, keys in _MODIFIERS
        }

    def character(self, code: int) -> None:
        """A glfw character event.

        Ahead of a modifier's release that waits it would count as a shortcut, and ahead of a key, be typed before it.
        """
        self._take(_Event(lambda: self._io.add_input_character(code)))

    def mouse_position(self, x: float, y: float) -> None:
        """The mouse, in window units."""

        def feed() -> None:
            self._io.add_mouse_pos_event(x, y)
            self._moved = True

        self._take(_Event(feed, lambda: self._clicked))

    def mouse_button(self, button: int, down: bool, mods: int) -> None:
        """A mouse button went down or up.

        In the frame of a movement, a drag would begin with the way to where the button was pressed, and end before
        the last of its own.
        """

        def feed() -> None:
            self._held = {modifier: bool(mods & bit) for bit, modifier, _ in _MODIFIERS}
            for modifier, held in self._held.items():
                self._io.add_key_event(modifier, held)
            if 0 <= button < 5:
                self._io.add_mouse_button_event(button, down)
            self._clicked = True

        self._take(_Event(feed, lambda: self._clicked or self._moved))

    def wheel(self, dx: float, dy: float) -> None:
        """The wheel, in steps."""

        def feed() -> None:
            self._io.add_mouse_wheel_event(dx, dy)
            self._wheeled = True

        self._take(_Event(feed))

    def focus(self, has_focus: bool) -> None:
        """The window gained or lost the keyboard; keys held then are let go."""
        self._io.add_focus_event(has_focus)

    def heard(self) -> bool:
        """Whether the frame that has begun took anything in from the keyboard or the mouse, or left some of it."""
        return self._context.input_events_trail.size() > 0 or self.has_more()

    def has_more(self) -> bool:
        """Whether something waits for the next frame: of several events of a key or a button each frame takes one."""
        return self._context.input_events_queue.size() > 0 or bool(self._later)

    def wants_text(self) -> bool:
        """Whether something is being typed, so that a cursor blinks."""
        return self._io.want_text_input

    def show_cursor(self, window: object) -> None:
        """Give the mouse the shape the panels asked for."""
        wanted = _CURSORS.get(imgui.get_mouse_cursor(), glfw.ARROW_CURSOR)
        if wanted == self._cursor:
            return
        self._cursor = wanted
        if wanted not in self._cursors:
            self._cursors[wanted] = _standard_cursor(wanted)
        glfw.set_cursor(window, self._cursors[wanted])

    def begin(self) -> None:
        """Start a frame."""
        imgui.set_current_context(self._context)
        width, height = glfw.get_window_size(self._window)
        across, down = glfw.get_framebuffer_size(self._window)
        self._io.display_size = imgui.ImVec2(width, height)
        self._io.display_framebuffer_scale = imgui.ImVec2(across / max(width, 1), down / max(height, 1))
        now_s = glfw.get_time()
        self._io.delta_time = max(now_s - self._last_frame_s, _SHORTEST_FRAME_S)
        self._last_frame_s = now_s
        imgui.new_frame()
        if not self._context.input_events_queue.size():
            # What Dear ImGui left of this frame's events, as a movement after a key, is part of the next.
            self._pressed = self._wheeled = self._moved = self._clicked = False
        waiting, self._later = self._later, []
        for event in waiting:
            self._take(event)

    def end(self) -> None:
        """End a frame; nothing is drawn yet."""
        imgui.render()

    def listed(self) -> imgui.ImDrawData:
        """What the frame that ended wants drawn; valid until the next begins."""
        return imgui.get_draw_data()

    def close(self) -> None:
        """Free everything."""
        imgui.destroy_context(self._context)

    def _share_the_clipboard(self) -> None:
        platform = imgui.get_platform_io()

        def read(_context: object) -> str:
            return (glfw.get_clipboard_string(None) or b"").decode("utf-8", "replace")

        platform.platform_get_clipboard_text_fn = read
        platform.platform_set_clipboard_text_fn = lambda _context, text: glfw.set_clipboard_string(None, text)


def _standard_cursor(shape: int) -> object | None:
    """A shape of the mouse; that for all directions where a desktop has none for a diagonal, the arrow without that."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", glfw.GLFWError)
        for known in (shape, glfw.RESIZE_ALL_CURSOR):
            cursor = glfw.create_standard_cursor(known)
            if cursor:
                return cursor
    return None


def _as_labelled(key: int) -> int:
    """The key by what is printed where a US keyboard has `key`: a letter or a sign that does something.

    Other keys stay, but a sign where a US keyboard has a letter is not that letter. Digits stay where they are, since
    some keyboards have them above other signs.
    """
    is_sign = glfw.KEY_APOSTROPHE <= key <= glfw.KEY_GRAVE_ACCENT and not glfw.KEY_0 <= key <= glfw.KEY_9
    if not is_sign and key not in (glfw.KEY_WORLD_1, glfw.KEY_WORLD_2):
        return key
    name = (glfw.get_key_name(key, 0) or "").upper()
    if glfw.KEY_A <= key <= glfw.KEY_Z and len(name) == 1 and "A" <= name <= "Z":
        return ord(name)
    is_letter_by_place = glfw.KEY_A <= key <= glfw.KEY_Z and name in tuple(string.punctuation)
    return _LABELLED.get(name, glfw.KEY_UNKNOWN if is_letter_by_place else key)
