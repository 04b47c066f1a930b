"""The window's size on a display whose units are not those of the design."""

import ctypes
import ctypes.util

import glfw
import moderngl
import pytest
from fake_relighter import FakeRelighter

from app.settings import read_settings
from app.window.graphics import Graphics
from app.window.window import EditorWindow

XA_RESOURCE_MANAGER, XA_STRING, REPLACE = 23, 31, 0


def tell_dots_per_inch(display, dots):
    """Says it as desktops do, in a property of the root window; None takes it back."""
    x11 = ctypes.CDLL(ctypes.util.find_library("X11"))
    x11.XOpenDisplay.restype = ctypes.c_void_p
    x11.XDefaultRootWindow.restype = ctypes.c_ulong
    connection = ctypes.c_void_p(x11.XOpenDisplay(display.encode()))
    root = ctypes.c_ulong(x11.XDefaultRootWindow(connection))
    words = b"" if dots is None else f"Xft.dpi:\t{dots}\n".encode()
    names = ctypes.c_ulong(XA_RESOURCE_MANAGER), ctypes.c_ulong(XA_STRING)
    x11.XChangeProperty(connection, root, *names, 8, REPLACE, words, len(words))
    x11.XCloseDisplay(connection)


@pytest.fixture
def dots_per_inch(display):
    yield lambda dots: tell_dots_per_inch(display, dots)
    tell_dots_per_inch(display, None)


def start_and_close(settings_path, size=None):
    """The window's size in pixels at one start of the editor."""
    window = EditorWindow(FakeRelighter, size=size, settings_path=settings_path)
    found = glfw.get_window_size(window.handle)
    window.close()
    return found


@pytest.mark.parametrize(
    ("dots", "pixels"), [(192, (1440, 940)), (132, (990, 646)), (96, (720, 470)), (72, (540, 352))]
)
def test_a_window_has_the_same_size_at_every_start(dots_per_inch, tmp_path, dots, pixels):
    dots_per_inch(dots)
    path = tmp_path / "settings.json"
    assert start_and_close(path, (720, 470)) == pixels
    assert [start_and_close(path) for _ in range(2)] == [pixels] * 2
    assert read_settings(path).window_size == (720, 470)


def test_a_scaled_window_stays_within_the_screen(dots_per_inch, display):
    dots_per_inch(192)
    window = EditorWindow(FakeRelighter, size=(1440, 900))
    screen = glfw.get_monitor_workarea(glfw.get_primary_monitor())[2:]
    assert glfw.get_window_size(window.handle) == screen
    window.close()


def test_graphics_that_start_again_do_so_at_the_same_size(dots_per_inch, photo_path, monkeypatch):
    dots_per_inch(192)
    window = EditorWindow(FakeRelighter, photo_path, size=(720, 470))
    handle = window.handle
    with monkeypatch.context() as patch:
        patch.setattr(Graphics, "show", lambda _: (_ for _ in ()).throw(moderngl.Error("out of memory")))
        window.frame()
    assert window.handle is not handle
    assert glfw.get_window_size(window.handle) == (1440, 940)
    window.close()


@pytest.mark.parametrize(("dots", "smallest"), [(96, (800, 560)), (132, (1100, 770))])
def test_the_smallest_window_holds_as_much_on_every_display(dots_per_inch, monkeypatch, dots, smallest):
    dots_per_inch(dots)
    asked = []
    monkeypatch.setattr(glfw, "set_window_size_limits", lambda handle, *limits: asked.append(limits[:2]))
    EditorWindow(FakeRelighter).close()
    assert asked == [smallest]
