"""Opening and closing a glfw window with an OpenGL 3.3 core context."""

from __future__ import annotations

import re
import warnings

import glfw
from PIL import Image

from app.window.gone_windows import forgive_gone_windows
from relight_core.resources import resource_path

SMALLEST = (800, 560)
_ICON_SIDES = (256, 128, 64, 48, 32, 16)
_AS_GLFW_WARNS = re.compile(r"""\(\d+\) b(?P<quote>['"])(?P<words>.*)(?P=quote)""", re.DOTALL)
"""A number for programmers, and GLFW's words as Python writes bytes."""


class NoDisplayError(RuntimeError):
    """There is no display to open a window on, or it has no OpenGL 3.3. The message is one line."""


def open_window(title: str, size: tuple[int, int], visible: bool = True) -> object:
    """Open a window and make its context current.

    Args:
        size: in units of the design, whatever the display's scale; larger than the screen, it is brought within it.

    Raises:
        NoDisplayError: see there.
    """
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        if not glfw.init():
            raise NoDisplayError(f"no display to open a window on{_reason(caught)}")
        _hint(visible)
        handle = glfw.create_window(*_within_screen(size), title, None, None)
        if not handle:
            glfw.terminate()
            raise NoDisplayError(f"this display gives no OpenGL 3.3 window{_reason(caught)}")
    forgive_gone_windows()
    glfw.make_context_current(handle)
    glfw.swap_interval(1)
    glfw.set_window_size_limits(handle, *_smallest(), glfw.DONT_CARE, glfw.DONT_CARE)
    with warnings.catch_warnings():
        # Wayland and macOS take icons from elsewhere and say so.
        warnings.simplefilter("ignore")
        glfw.set_window_icon(handle, len(_ICON_SIDES), _icons())
    return handle


def close_window(handle: object) -> None:
    """Close it and let glfw go."""
    glfw.destroy_window(handle)
    glfw.terminate()


def _hint(visible: bool) -> None:
    glfw.default_window_hints()
    glfw.window_hint(glfw.CONTEXT_VERSION_MAJOR, 3)
    glfw.window_hint(glfw.CONTEXT_VERSION_MINOR, 3)
    glfw.window_hint(glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE)
    glfw.window_hint(glfw.OPENGL_FORWARD_COMPAT, glfw.TRUE)
    # A context that was lost says so in its errors; without this, what happens then is anyone's guess.
    glfw.window_hint(glfw.CONTEXT_ROBUSTNESS, glfw.LOSE_CONTEXT_ON_RESET)
    glfw.window_hint(glfw.SCALE_TO_MONITOR, glfw.TRUE)
    glfw.window_hint(glfw.VISIBLE, glfw.TRUE if visible else glfw.FALSE)
    glfw.window_hint_string(glfw.X11_CLASS_NAME, "relight")
    glfw.window_hint_string(glfw.X11_INSTANCE_NAME, "relight")


def _icons() -> list[Image.Image]:
    with Image.open(resource_path("icon", "icon.png")) as drawn:
        whole = drawn.convert("RGBA")
    return [whole.resize((side, side), Image.Resampling.LANCZOS, reducing_gap=3.0) for side in _ICON_SIDES]


def _within_screen(size: tuple[int, int]) -> tuple[int, int]:
    monitor = glfw.get_primary_monitor()
    if not monitor:
        return size
    _, _, width, height = glfw.get_monitor_workarea(monitor)
    scale = _scale_at_creation(monitor)
    return (min(size[0], int(width / scale)), min(size[1], int(height / scale))) if width and height else size


def _smallest() -> tuple[int, int]:
    """In the units of the window's size: as large as texts and controls ask for, where the screen is."""
    monitor = glfw.get_primary_monitor()
    scale = _scale_at_creation(monitor) if monitor else 1.0
    width, height = _within_screen(SMALLEST)
    return int(width * scale), int(height * scale)


def _scale_at_creation(monitor: object) -> float:
    """What SCALE_TO_MONITOR makes of a unit of the design; systems that scale the framebuffer instead leave it."""
    if glfw.get_platform() not in (glfw.PLATFORM_X11, glfw.PLATFORM_WIN32):
        return 1.0
    return glfw.get_monitor_content_scale(monitor)[0] or 1.0


def _reason(caught: list) -> str:
    if not caught:
        return ""
    said = str(caught[-1].message)
    plain = _AS_GLFW_WARNS.fullmatch(said)
    return f": {' '.join((plain['words'] if plain else said).split())}"
