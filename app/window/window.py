"""The editor's window: events in, frames out, asleep while nothing changes."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from pathlib import Path

import glfw
import moderngl
import numpy as np

from app.engine.engine import Engine
from app.engine.exporting import Exporter
from app.engine.light_shelf import LightShelf
from app.engine.sources import LightSource, RelighterLike, Request
from app.ui import editor, theme
from app.ui.light_list import Shelf
from app.ui.news import let_news_pass
from app.ui.state import EditorState
from app.window.deeds import Deeds
from app.window.dropped import take_files
from app.window.finished import Finished
from app.window.frame_limit import FrameLimit, display_hz
from app.window.gl_pictures import GlPictures
from app.window.gl_textures import Canvas
from app.window.glfw_window import NoDisplayError
from app.window.graphics import DRIVER_FAULTS, Graphics, GraphicsLostError, Restarts, one_line
from app.window.held_shift import shift_is_held
from app.window.interrupts import Interrupts
from app.window.leaving import Leaving
from app.window.memory import Memory
from app.window.outputs import Outputs
from app.window.rest import Rest

SIZE = (1440, 900)
_QUIET_FRAMES, _MOST_SETTLING_FRAMES = 4, 60
_NO_TEXT = "A file that was dropped has a name that is no text; rename it, or drop the folder it is in"
_log = logging.getLogger(__name__)


class EditorWindow:
    """The whole editor. Its on_... methods are the glfw callbacks, and may be called to act as a user.

    Args:
        make_relighter: called on the engine's thread when the networks are first needed, and by each job that relights.
        photo, light: what to open at once.
        size: of the window, in units of the design; None is the last one's.
        visible: False keeps it off the screen.
        on_engine_start: called first on each thread that runs networks, as of app.engine.engine.Engine.
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
        settings_path: Path | None = None,
        calibration_path: Path | None = None,
    ) -> None:
        self._memory = Memory(settings_path)
        self._graphics: Graphics | None = None
        self._graphics_lock, self._restarts = threading.Lock(), Restarts()
        folder = settings_path.parent if settings_path else None
        self.shelf = LightShelf(self._wake, folder and folder / "recent-lights")
        self._visible = visible
        self._open_graphics(size or self._memory.window_size or SIZE)
        self.state = EditorState()
        self._memory.recall(self.state)
        if light is not None:
            self.state.choose_light(light)
        if photo is not None:
            self.state.open_photo(photo)
        self.engine = Engine(make_relighter, self._wake, on_engine_start, calibration_path)
        self.exporter = Exporter(self.engine.say, self._wake, on_engine_start)
        self._finished = Finished(self.state, self.engine.say)
        self._outputs = Outputs(self.state, self.exporter, make_relighter, self._finished.then, folder)
        then = self._finished.then
        self._deeds = Deeds(self.state, self.engine.say, folder, outputs=self._outputs, when_finished=then)
        self._leaving = Leaving(
            self.state.asking,
            self._is_making_files,
            lambda: self._finished.failures + self.exporter.failures,
            self._deeds.would_lose_work,
        )
        self._submitted = Request()
        self._rest = Rest()

    @property
    def handle(self) -> object:
        """The glfw window."""
        return self._graphics.handle

    @property
    def context(self) -> moderngl.Context:
        """The window's OpenGL."""
        return self._graphics.context

    @property
    def pictures(self) -> GlPictures:
        """The textures on show."""
        return self._graphics.pictures

    def run(self) -> None:
        """Draw until the user closes the window and, where files are still being made, has said what of them.

        Raises:
            GraphicsLostError: the driver gave up for good; unsaved work is kept.
            KeyboardInterrupt: the program was told to end.
        """
        limit = FrameLimit(display_hz())
        with Interrupts(self._wake) as interrupts:
            while not self.may_close():
                try:
                    self._wait()
                    if limit.wait():
                        glfw.poll_events()
                except UnicodeDecodeError:
                    # The binding of glfw raises it for what was dropped, from wherever events are taken in.
                    self.state.asking.tell(_NO_TEXT, True)
                interrupts.heed()
                self.frame()

    def may_close(self) -> bool:
        """Whether the user wants the window closed and nothing is lost by it; asks where something would be."""
        wanted = glfw.window_should_close(self.handle)
        allowed = self._leaving.allows(wanted)
        if wanted and not allowed:
            glfw.set_window_should_close(self.handle, False)
            self._rest.stir()
        return allowed

    def frame(self) -> None:
        """Take over what the engine published, draw one frame, and tell the engine what is wanted.

        A window that nobody can see draws none, and its light does not turn by itself; what was begun goes on.
        Where the driver fails, the window is opened again.

        Raises:
            GraphicsLostError: that did not help; unsaved work is kept.
        """
        try:
            glfw.make_context_current(self.handle)
            self._take_over()
            if self._is_in_sight():
                self._show()
            self._graphics.check()
        except DRIVER_FAULTS as error:
            self._start_again(error)
        else:
            self._act()

    def _is_in_sight(self) -> bool:
        return not self._is_minimised and 0 not in glfw.get_framebuffer_size(self.handle)

    def _show(self) -> None:
        self._draw()
        let_news_pass(self.state, time.monotonic())
        self._graphics.show()
        if self.pictures.draw_ahead():
            # The frame that shows it follows at once.
            glfw.post_empty_event()

    def settle(self, timeout_s: float = 60.0) -> bool:
        """Draw until the engine has answered all that is wanted; False if it took too long.

        What a frame shows may make the next one want more, so some frames in a row have to find the engine idle.
        """
        until, quiet = time.monotonic() + timeout_s, 0
        for _ in range(_MOST_SETTLING_FRAMES):
            self.frame()
            is_quiet = self.engine.wait_until_idle(0) and not self.pictures.is_unfinished
            quiet = quiet + 1 if is_quiet else 0
            if quiet == _QUIET_FRAMES:
                break
            if not self.engine.wait_until_idle(until - time.monotonic()):
                return False
        return True

    def screenshot(self) -> np.ndarray:
        """(h, w, 3) uint8 sRGB of the whole window."""
        canvas = Canvas(self.context)
        canvas.fit(glfw.get_framebuffer_size(self.handle))
        self._take_over()
        self._draw()
        canvas.framebuffer.clear(*theme.PANEL)
        self._graphics.painter.paint(self._graphics.binding.listed(), canvas.framebuffer)
        pixels = canvas.pixels()[::-1].copy()
        canvas.close()
        return pixels

    def close(self) -> None:
        """Keep the settings and unsaved work, end the threads, free everything.

        Work that still runs is stopped at its next step, and what waits behind it is not begun.
        """
        if self._graphics is not None:
            self._memory.keep(self.state, self._graphics.size)
            glfw.hide_window(self.handle)
        self._deeds.close()
        self.shelf.close()
        self.engine.close()
        self.exporter.close(cancel=True)
        self._close_graphics()

    def on_key(self, _handle, key: int, _scancode: int, action: int, mods: int) -> None:
        """A key went down, repeats or went up."""
        self._graphics.binding.key(key, action, mods)

    def on_character(self, _handle, code: int) -> None:
        """A character was typed."""
        self._graphics.binding.character(code)

    def on_mouse_move(self, _handle, x: float, y: float) -> None:
        """The mouse moved, in window units."""
        self._graphics.binding.mouse_position(x, y)

    def on_mouse_enter(self, _handle, entered: bool) -> None:
        """The mouse came or left; away from the window it points at nothing."""
        if not entered and glfw.get_mouse_button(self.handle, glfw.MOUSE_BUTTON_LEFT) == glfw.RELEASE:
            self._graphics.binding.mouse_position(-1e9, -1e9)

    def on_mouse_button(self, _handle, button: int, action: int, mods: int) -> None:
        """A mouse button went down or up."""
        self._graphics.binding.mouse_button(button, action == glfw.PRESS, mods)

    def on_wheel(self, _handle, dx: float, dy: float) -> None:
        """The wheel turned."""
        self._graphics.binding.wheel(dx, dy)

    def on_focus(self, _handle, has_focus: bool) -> None:
        """The window gained or lost the keyboard."""
        self._graphics.binding.focus(bool(has_focus))

    def on_scale(self, _handle, x: float, _y: float) -> None:
        """The window moved to a display of another scale."""
        self._graphics.binding.set_scale(self._graphics.scale(x))

    def on_refresh(self, _handle) -> None:
        """What the window showed has to be drawn again, as after another window lay over it."""
        self._graphics.painter.forget()

    def on_minimise(self, _handle, is_minimised: bool) -> None:
        """The window was minimised or came back."""
        self._is_minimised = bool(is_minimised)

    def on_drop(self, _handle, paths: list[str], position: tuple[float, float] | None = None) -> None:
        """Files were dropped, where the mouse is unless `position` says otherwise."""
        x, y = position or glfw.get_cursor_pos(self.handle)
        if paths:
            take_files(self.state, [Path(path) for path in paths], x, y, as_light=shift_is_held(self.handle))

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
        glfw.set_window_refresh_callback(handle, self.on_refresh)
        glfw.set_window_iconify_callback(handle, self.on_minimise)
        glfw.set_drop_callback(handle, self.on_drop)

    def _open_graphics(self, size: tuple[int, int]) -> None:
        graphics = Graphics(size, self._visible, self.shelf)
        with self._graphics_lock:
            self._graphics = graphics
        self._title, self._is_minimised = "", False
        self._listen()

    def _close_graphics(self) -> None:
        with self._graphics_lock:
            graphics, self._graphics = self._graphics, None
            if graphics is not None:
                graphics.close()

    def _is_making_files(self) -> bool:
        return self._finished.is_making_files or self.exporter.is_busy()

    def _wake(self) -> None:
        """For other threads: end the window's sleep."""
        with self._graphics_lock:
            if self._graphics is not None:
                glfw.post_empty_event()

    def _start_again(self, error: Exception) -> None:
        """Open the window again after the driver has failed; the state of the edit is none of its business."""
        _log.warning("the graphics driver failed: %s", one_line(error))
        kept = self._deeds.keep_now()
        size = self._graphics.size
        self._close_graphics()
        while self._restarts.allow(time.monotonic()):
            try:
                self._open_graphics(size)
            except NoDisplayError as failure:
                error = failure
                continue
            # Whatever is said makes a new snapshot, whose pictures the new window then uploads.
            self.engine.say("The graphics driver failed and was started again. Nothing is lost.", is_error=True)
            return
        work = "unsaved work is kept, and offered at the next start" if kept else "there was no unsaved work"
        if self.state.is_unsaved() and not kept:
            work = "unsaved work could not be kept"
        mend = "update or restart the graphics driver, or use relight render, which needs none"
        raise GraphicsLostError(f"the graphics driver failed ({one_line(error)}); {work}; {mend}") from error

    def _wait(self) -> None:
        """Rest until something happens, but for what was heard and not yet told to the panels."""
        binding, has_panels = self._graphics.binding, not self._is_minimised
        if has_panels and binding.has_more():
            glfw.poll_events()
            return
        if has_panels and self.pictures.is_unfinished:
            self._rest.stir()
        reasons = has_panels and self.state.playing, has_panels and binding.wants_text(), self._deeds.waiting
        if self._rest.is_deep(*reasons):
            self._memory.keep(self.state, self._graphics.size)
            # Whatever was lost unnoticed meanwhile is mended by the next frame.
            self._graphics.painter.forget()
        self._rest.until_due(*reasons)

    def _take_over(self) -> None:
        """What the engine and the exporter have got done since."""
        state = self.state
        snapshot = self.engine.snapshot()
        is_new = snapshot is not state.snapshot
        if is_new:
            state.accept(snapshot)
            self.shelf.keep(snapshot.light)
        self.pictures.begin_frame(state.edit.exposure_ev, state.is_moving)
        if is_new:
            self.pictures.update(snapshot)
            self._rest.stir()
        state.job = self.exporter.status()

    def _draw(self) -> None:
        state, binding = self.state, self._graphics.binding
        binding.begin()
        if binding.heard():
            self._rest.stir()
        editor.draw(state, binding.fonts, self.pictures, Shelf(self.shelf.names, self.shelf.words))
        binding.end()

    def _act(self) -> None:
        """Do what the panels have asked for."""
        self.state.remember(time.monotonic())
        waited = self._deeds.waiting
        self._deeds.act(time.monotonic())
        if waited and not self._deeds.waiting:
            # What a dialog was told may be something to show.
            self._rest.stir()
        if self.state.export_wanted:
            self._outputs.export(self.state.export_wanted)
            self.state.export_wanted = None
        if self.state.quit_wanted:
            glfw.set_window_should_close(self.handle, True)
            self.state.quit_wanted = False
        self._ask_engine()
        if self.state.cancel_wanted is not None:
            self.exporter.cancel(self.state.cancel_wanted)
            self.state.cancel_wanted = None
        self._graphics.binding.show_cursor(self.handle)
        opened = self.state.snapshot.opened
        title = f"{opened.source.name} \N{EN DASH} relight" if opened else "relight"
        if title != self._title:
            self._title = title
            glfw.set_window_title(self.handle, title)

    def _ask_engine(self) -> None:
        request = self._finished.wanted(self.state.request())
        if request != self._submitted:
            self._submitted = request
            self.engine.submit(request)
        is_idle = self.engine.wait_until_idle(0) and self.engine.snapshot() is self.state.snapshot
        self._finished.hand_out(self.state.snapshot, is_idle)
