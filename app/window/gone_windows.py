"""X11's errors about windows of other programs: one that goes while files are dragged from it must not take ours along.

Xlib ends a program at the first error that nobody handles, with all work that is not saved.
"""

from __future__ import annotations

import ctypes
import sys

import glfw

_XLIB = "libX11.so.6"
"""By this name GLFW has loaded it where it speaks X11."""
_BAD_WINDOW = 3
_CONVERSATION = frozenset({18, 19, 20, 24, 25})
"""Requests that speak to another program's window: set, delete and get a property, ask for a selection, send."""


class _ErrorEvent(ctypes.Structure):
    _fields_ = (
        ("kind", ctypes.c_int),
        ("display", ctypes.c_void_p),
        ("resource", ctypes.c_ulong),
        ("serial", ctypes.c_ulong),
        ("error", ctypes.c_ubyte),
        ("request", ctypes.c_ubyte),
        ("part", ctypes.c_ubyte),
    )


_Handler = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.POINTER(_ErrorEvent))
_installed: list[object] = []


def forgive_gone_windows() -> None:
    """From now on such errors are passed over, and all others left to who handled them before. X11 alone has them."""
    if _installed or sys.platform != "linux" or glfw.get_platform() != glfw.PLATFORM_X11:
        return
    set_handler = ctypes.CDLL(_XLIB).XSetErrorHandler
    set_handler.argtypes, set_handler.restype = [_Handler], _Handler

    @_Handler
    def handle(display: int | None, event: ctypes._Pointer) -> int:
        error = event.contents
        if error.error == _BAD_WINDOW and error.request in _CONVERSATION:
            return 0
        return before(display, event)

    before = set_handler(handle)
    _installed.extend((handle, before))
