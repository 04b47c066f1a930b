"""Whether Shift is held, also while another program has the keyboard, as it has when files are dragged from it."""

from __future__ import annotations

import ctypes
import ctypes.util
import sys
from functools import cache

import glfw

_X11_SHIFT_MASK, _WINDOWS_SHIFT = 1, 0x10


def shift_is_held(window: object) -> bool:
    """Ask the glfw window, and where it does not know, the system."""
    if any(glfw.get_key(window, key) == glfw.PRESS for key in (glfw.KEY_LEFT_SHIFT, glfw.KEY_RIGHT_SHIFT)):
        return True
    if sys.platform == "win32":
        return bool(ctypes.windll.user32.GetAsyncKeyState(_WINDOWS_SHIFT) & 0x8000)
    if sys.platform == "linux" and glfw.get_platform() == glfw.PLATFORM_X11:
        return _held_on_x11(glfw.get_x11_display())
    return False


def _held_on_x11(display: int | None) -> bool:
    library = _x11()
    if not display or library is None:
        return False
    display = ctypes.c_void_p(display)
    root = ctypes.c_ulong(library.XDefaultRootWindow(display))
    windows, places, mask = (ctypes.c_ulong * 2)(), (ctypes.c_int * 4)(), ctypes.c_uint()
    found = [ctypes.byref(windows, index * ctypes.sizeof(ctypes.c_ulong)) for index in range(2)]
    found += [ctypes.byref(places, index * ctypes.sizeof(ctypes.c_int)) for index in range(4)]
    # False only says that the mouse is on another screen; the keys are told all the same.
    library.XQueryPointer(display, root, *found, ctypes.byref(mask))
    return bool(mask.value & _X11_SHIFT_MASK)


@cache
def _x11() -> ctypes.CDLL | None:
    name = ctypes.util.find_library("X11")
    if name is None:
        return None
    library = ctypes.CDLL(name)
    library.XDefaultRootWindow.restype = ctypes.c_ulong
    return library
