"""The window on the screen and everything that lives in its OpenGL context, which a driver may lose at any time."""

from __future__ import annotations

import contextlib
import math
import os

import glfw
import moderngl

from app.engine.light_shelf import LightShelf
from app.ui import theme
from app.ui.binding import Binding
from app.window.gl_interface import InterfacePainter
from app.window.gl_pictures import GlPictures
from app.window.gl_textures import Canvas
from app.window.gl_viewport import draws_in_software
from app.window.glfw_window import NoDisplayError, close_window, open_window

FORGIVEN_S = 60.0
"""After this long without a fault the next one counts as the first."""

_TRIAL_SHADES = (theme.PANEL[0], theme.PANEL[0] + 0.02)
"""Shown for a moment in the empty window, so they hardly differ from its colour."""

_ROUNDING = 1e-3
"""Of a size that was divided by a scale; glfw cuts fractions off where it multiplies."""

_SOFTWARE = {"LIBGL_ALWAYS_SOFTWARE": "1", "__GLX_VENDOR_LIBRARY_NAME": "mesa"}


class DriverError(RuntimeError):
    """The driver has noted an error."""


DRIVER_FAULTS = (moderngl.Error, DriverError)
"""What is raised where the driver refuses: a lost context, no memory, a shader it can't compile."""


class GraphicsLostError(RuntimeError):
    """The driver gave up, and opening the window again did not help. The message is one line."""


class Graphics:
    """A window, its context, and what draws into it.

    Args:
        size: in units of the design.
        visible: False keeps it off the screen.
        shelf: the balls of the bundled lights.

    Raises:
        NoDisplayError: no display, or one whose OpenGL is too old or can't compile the editor's shaders.
    """

    def __init__(self, size: tuple[int, int], visible: bool, shelf: LightShelf) -> None:
        self.handle = open_window("relight", size, visible)
        try:
            self.context = moderngl.create_context(require=330)
            self.pictures = GlPictures(self.context, shelf, theme.CANVAS_SRGB)
            self.binding = Binding(self.handle, self.scale(glfw.get_window_content_scale(self.handle)[0]))
            self.painter = InterfacePainter(self.context)
            self._keeps_frames = draws_in_software(self.context) and keeps_frames(self.context, self.handle)
        except Exception as error:
            # What moderngl raises for a version that is too old is no class of its own.
            close_window(self.handle)
            raise NoDisplayError(f"this display's OpenGL can't run the editor ({one_line(error)})") from error

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in units of the design: a window opened with them is as large as this one."""
        exact = self._exact_scale(glfw.get_window_content_scale(self.handle)[0])
        width, height = (math.ceil(side / exact - _ROUNDING) for side in glfw.get_window_size(self.handle))
        return width, height

    def scale(self, content: float) -> float:
        """Window units per unit of the design, for what is drawn; systems that scale the framebuffer have 1."""
        return max(1.0, self._exact_scale(content))

    def _exact_scale(self, content: float) -> float:
        framebuffer, window = glfw.get_framebuffer_size(self.handle)[0], glfw.get_window_size(self.handle)[0]
        return content * window / framebuffer if framebuffer and window and content else 1.0

    def show(self) -> None:
        """Bring the frame that was listed last onto the screen, as far as it differs from what is there."""
        screen = self.context.screen
        if self.painter.repaint(self.binding.listed(), screen, theme.PANEL, self._keeps_frames):
            glfw.swap_buffers(self.handle)

    def check(self) -> None:
        """Look for what the driver has noted since the last time, a lost context among it.

        Raises:
            DriverError: there is something.
        """
        error = self.context.error
        if error != "GL_NO_ERROR":
            raise DriverError(error)

    def close(self) -> None:
        """Free everything; a driver that refuses even that is left to the system."""
        with contextlib.suppress(*DRIVER_FAULTS):
            glfw.make_context_current(self.handle)
            self.pictures.close()
        with contextlib.suppress(*DRIVER_FAULTS):
            self.painter.close()
        self.binding.close()
        with contextlib.suppress(*DRIVER_FAULTS):
            self.context.release()
        close_window(self.handle)


def keeps_frames(context: moderngl.Context, handle: object) -> bool:
    """Whether the back buffer still holds the frame after `swap_buffers`, so that only parts need be redrawn.

    OpenGL leaves the buffer undefined, so this is tried out. Software renderers mostly copy the frame to the screen;
    others swap to another buffer, which holds an older frame.
    """
    sample, found = Canvas(context), []
    sample.fit((1, 1))
    for shade in _TRIAL_SHADES:
        context.screen.clear(shade, shade, shade)
        glfw.swap_buffers(handle)
        sample.framebuffer.clear()
        context.copy_framebuffer(sample.framebuffer, context.screen)
        found.append(abs(int(sample.pixels()[0, 0, 0]) - 255 * shade) < 1.0)
    sample.close()
    return all(found)


class Restarts:
    """How often graphics that failed may be restarted: once as they were, once in software, then no more."""

    def __init__(self) -> None:
        self._count, self._last_s = 0, 0.0

    def allow(self, now_s: float) -> bool:
        """Count a fault; False if opening again has been tried enough. The second try is made in software."""
        if now_s - self._last_s > FORGIVEN_S:
            self._count = 0
        self._count, self._last_s = self._count + 1, now_s
        if self._count == 2:
            os.environ.update(_SOFTWARE)
        return self._count <= 2


def one_line(error: Exception) -> str:
    """What an error says, without its line breaks."""
    return " ".join(str(error).split())[:200] or type(error).__name__
