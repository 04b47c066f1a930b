"""The editor's window: events in, frames out, asleep while nothing changes."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import glfw
import moderngl
import numpy as np

from app.engine.engine import Engine
from app.engine.exporting import Exporter, ExportJob
from app.engine.light_shelf import LightShelf
from app.engine.sources import LightSource, RelighterLike, Request
from app.ui import editor, theme
from app.ui.binding import Binding
from app.ui.effects_panel import export_path
from app.ui.light_panel import Shelf
from app.ui.state import EditorState
from app.window.deeds import Deeds
from app.window.dropped import take_files
from app.window.gl_interface import InterfacePainter
from app.window.gl_pictures import GlPictures
from app.window.gl_textures import Canvas
from app.window.glfw_window import close_window, open_window
from app.window.memory import Memory
from app.window.outputs import Outputs

SIZE = (1440, 900)
_LIVELY_S = 0.7
_LIVELY_STEP_S = 0.03
_CURSOR_BLINK_S = 0.25
_DEEDS_STEP_S = 0.1
_PLAYING_STEP_S = 1 / 60


class EditorWindow:
    """The whole editor. Its on_... methods are the glfw callbacks, and may be called to act as a user.

    Args:
        make_relighter: called on the engine's thread when the first photo is opened.
        photo, light: what to open at once.
        size: of the window; None is the last one's.
        visible: False keeps it off the screen.
        on_engine_start, set_pace: as of app.engine.engine.Engine.
        settings_path: where panels and window size are kept between runs; None keeps nothing.
        calibration_path: where the costs of the quality tiers are kept; None does not measure them.

    Raises:
        NoDisplayError: no display, or one without OpenGL 3.3.
    """

    def __init__(
        self,
        make_relighter: Callable[[], RelighterLike],
        photo: Path | None = None,
        light: LightSource | None = None,
        *,
        size: tuple[int, int] | None = None,
        visible: bool = True,
        on_engine_start: Callable[[], None] = lambda: None,
        set_pace: Callable[[bool], None] = lambda hurried: None,
        settings_path: Path | None = None,
        calibration_path: Path | None = None,
    ) -> None:
        self._memory = Memory(settings_path)
        self.handle = open_window("relight", size or self._memory.window_size or SIZE, visible)
        self.context = moderngl.create_context(require=330)
        self.state = EditorState()
        self._memory.recall(self.state)
        if light is not None:
            self.state.choose_light(light)
        if photo is not None:
            self.state.open_photo(photo)
        self.shelf = LightShelf(glfw.post_empty_event)
        self.engine = Engine(make_relighter, glfw.post_empty_event, on_engine_start, calibration_path, set_pace)
        self.exporter = Exporter(self.engine.say, glfw.post_empty_event)
        self.pictures = GlPictures(self.context, self.shelf, theme.CANVAS_SRGB)
        self._binding = Binding(self.handle, self._scale(glfw.get_window_content_scale(self.handle)[0]))
        self._painter = InterfacePainter(self.context)
        folder = settings_path.parent if settings_path else None
        outputs = Outputs(self.state, self.exporter, make_relighter)
        self._deeds = Deeds(self.state, self.engine.say, folder, outputs=outputs)
        self._submitted = Request()
        self._lively_until = time.monotonic() + _LIVELY_S
        self._title = ""
        self._listen()

    def run(self) -> None:
        """Draw until the user closes the window."""
        while not glfw.window_should_close(self.handle):
            self._wait()
            self.frame()

    def frame(self) -> None:
        """Take over what the engine published, draw one frame, and tell the engine what is wanted."""
        glfw.make_context_current(self.handle)
        width, height = glfw.get_framebuffer_size(self.handle)
        if width == 0 or height == 0:
            return
        self._draw()
        self._paint(self.context.screen)
        glfw.swap_buffers(self.handle)
        self._act()

    def settle(self, timeout_s: float = 60.0) -> bool:
        """Draw until the engine has answered all that is wanted; False if it took too long."""
        self.frame()
        answered = self.engine.wait_until_idle(timeout_s)
        for _ in range(3):
            self.frame()
        return answered

    def screenshot(self) -> np.ndarray:
        """(h, w, 3) uint8 sRGB of the whole window."""
        canvas = Canvas(self.context)
        canvas.fit(glfw.get_framebuffer_size(self.handle))
        self._draw()
        self._paint(canvas.framebuffer)
        pixels = canvas.pixels()[::-1].copy()
        canvas.close()
        return pixels

    def close(self) -> None:
        """Keep the settings, finish exports, end the threads, free everything."""
        self._memory.keep(self.state, glfw.get_window_size(self.handle))
        glfw.hide_window(self.handle)
        self._deeds.close()
        self.shelf.close()
        self.engine.close()
        self.exporter.close(cancel=True)
        glfw.make_context_current(self.handle)
        self.pictures.close()
        self._painter.close()
        self._binding.close()
        self.context.release()
        close_window(self.handle)

    def on_key(self, _handle, key: int, _scancode: int, action: int, mods: int) -> None:
        """A key went down, repeats or went up."""
        self._binding.key(key, action, mods)

    def on_character(self, _handle, code: int) -> None:
        """A character was typed."""
        self._binding.character(code)

    def on_mouse_move(self, _handle, x: float, y: float) -> None:
        """The mouse moved, in window units."""
        self._binding.mouse_position(x, y)

    def on_mouse_enter(self, _handle, entered: bool) -> None:
        """The mouse came or left; away from the window it points at nothing."""
        if not entered and glfw.get_mouse_button(self.handle, glfw.MOUSE_BUTTON_LEFT) == glfw.RELEASE:
            self._binding.mouse_position(-1e9, -1e9)

    def on_mouse_button(self, _handle, button: int, action: int, mods: int) -> None:
        """A mouse button went down or up."""
        self._binding.mouse_button(button, action == glfw.PRESS, mods)

    def on_wheel(self, _handle, dx: float, dy: float) -> None:
        """The wheel turned."""
        self._binding.wheel(dx, dy)

    def on_focus(self, _handle, has_focus: bool) -> None:
        """The window gained or lost the keyboard."""
        self._binding.focus(bool(has_focus))

    def on_scale(self, _handle, x: float, _y: float) -> None:
        """The window moved to a display of another scale."""
        self._binding.set_scale(self._scale(x))

    def on_drop(self, _handle, paths: list[str], position: tuple[float, float] | None = None) -> None:
        """Files were dropped, where the mouse is unless `position` says otherwise."""
        x, y = position or glfw.get_cursor_pos(self.handle)
        if paths:
            shift = any(glfw.get_key(self.handle, key) for key in (glfw.KEY_LEFT_SHIFT, glfw.KEY_RIGHT_SHIFT))
            take_files(self.state, [Path(path) for path in paths], x, y, as_light=shift)

    def _listen(self) -> None:
        handle = self.handle
        glfw.set_key_callback(handle, self.on_key)
        glfw.set_char_callback(handle, self.on_character)
        glfw.set_cursor_pos_callback(handle, self.on_mouse_move)
        glfw.set_cursor_enter_callback(handle, self.on_mouse_enter)
        glfw.set_mouse_button_callback(handle, self.on_mouse_button)
        glfw.set_scroll_callback(handle, self.on_wheel)
        glfw.set_window_focus_callback(handle, self.on_focus)
        glfw.set_window_content_scale_callback(handle, self.on_scale)
        glfw.set_drop_callback(handle, self.on_drop)

    def _scale(self, content: float) -> float:
        """Window units per unit of the design; systems that scale the framebuffer instead have 1."""
        framebuffer, window = glfw.get_framebuffer_size(self.handle)[0], glfw.get_window_size(self.handle)[0]
        return max(1.0, content * window / framebuffer) if framebuffer and window else 1.0

    def _wait(self) -> None:
        """Sleep until something happens; for a moment after it, tick on, for what needs several frames."""
        now = time.monotonic()
        if now < self._lively_until and not self.state.playing:
            glfw.wait_events_timeout(_LIVELY_STEP_S)
            if time.monotonic() - now < 0.9 * _LIVELY_STEP_S:
                self._lively_until = time.monotonic() + _LIVELY_S
        elif self._binding.wants_text():
            glfw.wait_events_timeout(_CURSOR_BLINK_S)
        elif self.state.playing:
            glfw.wait_events_timeout(_PLAYING_STEP_S)
        elif self._deeds.waiting:
            glfw.wait_events_timeout(_DEEDS_STEP_S)
        else:
            self._memory.keep(self.state, glfw.get_window_size(self.handle))
            glfw.wait_events()
            self._lively_until = time.monotonic() + _LIVELY_S

    def _draw(self) -> None:
        state = self.state
        snapshot = self.engine.snapshot()
        if snapshot is not state.snapshot:
            state.accept(snapshot)
            self.pictures.update(snapshot)
        state.job = self.exporter.status()
        self.pictures.exposure_ev = state.edit.exposure_ev
        self._binding.begin()
        editor.draw(state, self._binding.fonts, self.pictures, Shelf(self.shelf.names, self.shelf.words))
        self._binding.end()

    def _paint(self, target: moderngl.Framebuffer) -> None:
        target.clear(*theme.PANEL)
        self._painter.paint(self._binding.listed(), target)

    def _act(self) -> None:
        """Do what the panels have asked for."""
        request, last = self.state.request(), self._submitted
        self.state.remember(time.monotonic())
        self._deeds.act(time.monotonic())
        if not request.same_as(last):
            self._submitted = request
            self.engine.submit(request)
        if self.state.cancel_wanted:
            self.state.cancel_wanted = False
            self.exporter.cancel()
        if self.state.export_wanted:
            self._export(self.state.export_wanted)
            self.state.export_wanted = None
        self._binding.show_cursor(self.handle)
        opened = self.state.snapshot.opened
        title = f"{opened.source.name} \N{EN DASH} relight" if opened else "relight"
        if title != self._title:
            self._title = title
            glfw.set_window_title(self.handle, title)

    def _export(self, suffix: str) -> None:
        picture = self.state.snapshot.picture
        if picture is not None:
            settings = replace(self.state.export, form=suffix)
            path = export_path(self.state, suffix)
            self.exporter.submit(ExportJob(picture, self.state.edit.exposure_ev, path, settings))
