"""The other side of a drag and drop on X11: a file manager that hands over files (XDND version 5)."""

import ctypes
import ctypes.util
from pathlib import Path

import glfw
from window_hand import PATIENCE

CLIENT_MESSAGE, SELECTION_REQUEST, SELECTION_NOTIFY = 33, 30, 31
VERSION = 5


class Message(ctypes.Structure):
    """XClientMessageEvent, format 32."""

    _fields_ = [
        ("kind", ctypes.c_int),
        ("serial", ctypes.c_ulong),
        ("sent", ctypes.c_int),
        ("display", ctypes.c_void_p),
        ("window", ctypes.c_ulong),
        ("name", ctypes.c_ulong),
        ("format", ctypes.c_int),
        ("data", ctypes.c_long * 5),
    ]


class Request(ctypes.Structure):
    """XSelectionRequestEvent; without its owner it is an XSelectionEvent."""

    _fields_ = [
        ("kind", ctypes.c_int),
        ("serial", ctypes.c_ulong),
        ("sent", ctypes.c_int),
        ("display", ctypes.c_void_p),
        ("owner", ctypes.c_ulong),
        ("requestor", ctypes.c_ulong),
        ("selection", ctypes.c_ulong),
        ("target", ctypes.c_ulong),
        ("answer", ctypes.c_ulong),
        ("time", ctypes.c_ulong),
    ]


class Answer(ctypes.Structure):
    """XSelectionEvent."""

    _fields_ = [field for field in Request._fields_ if field[0] != "owner"]


class Event(ctypes.Union):
    _fields_ = [("kind", ctypes.c_int), ("message", Message), ("request", Request), ("room", ctypes.c_long * 24)]


class FileManager:
    """A window of another X client, with files in its hand."""

    def __init__(self, display_name: str):
        self.x = ctypes.CDLL(ctypes.util.find_library("X11"))
        for name, result in {"XOpenDisplay": ctypes.c_void_p, "XDefaultRootWindow": ctypes.c_ulong}.items():
            getattr(self.x, name).restype = result
        self.x.XInternAtom.restype = self.x.XCreateSimpleWindow.restype = ctypes.c_ulong
        self.display = ctypes.c_void_p(self.x.XOpenDisplay(display_name.encode()))
        assert self.display
        self.root = self.x.XDefaultRootWindow(self.display)
        place = [ctypes.c_int(0)] * 2 + [ctypes.c_uint(1)] * 2 + [ctypes.c_uint(0)] + [ctypes.c_ulong(0)] * 2
        self.window = self.x.XCreateSimpleWindow(self.display, ctypes.c_ulong(self.root), *place)

    def atom(self, name: str) -> int:
        return self.x.XInternAtom(self.display, name.encode(), 0)

    def drop(self, paths: list[Path], target: int, at: tuple[int, int]) -> None:
        """Carry files to a place on the screen, in root coordinates, above a window, and let go."""
        uris = "".join(f"{path.resolve().as_uri()}\r\n" for path in paths).encode()
        selection, kind = self.atom("XdndSelection"), self.atom("text/uri-list")
        self.x.XSetSelectionOwner(
            self.display, ctypes.c_ulong(selection), ctypes.c_ulong(self.window), ctypes.c_ulong(0)
        )
        self.move_pointer(at)
        self.send(target, "XdndEnter", VERSION << 24, kind)
        self.send(target, "XdndPosition", 0, at[0] << 16 | at[1], 0, self.atom("XdndActionCopy"))
        status = self.wait_for("XdndStatus", uris)
        assert status.data[1] & 1, "the window does not take the drop"
        self.send(target, "XdndDrop", 0, 0)
        self.wait_for("XdndFinished", uris)

    def move_pointer(self, at: tuple[int, int]) -> None:
        nowhere = [ctypes.c_int(0)] * 2 + [ctypes.c_uint(0)] * 2
        place = [ctypes.c_int(coordinate) for coordinate in at]
        self.x.XWarpPointer(self.display, ctypes.c_ulong(0), ctypes.c_ulong(self.root), *nowhere, *place)
        self.x.XSync(self.display, 0)

    def send(self, target: int, name: str, *data: int) -> None:
        event = Event()
        event.message = Message(CLIENT_MESSAGE, 0, 1, self.display, target, self.atom(name), 32)
        for place, value in enumerate((self.window, *data)):
            event.message.data[place] = value
        self.x.XSendEvent(self.display, ctypes.c_ulong(target), 0, ctypes.c_long(0), ctypes.byref(event))
        self.x.XFlush(self.display)

    def wait_for(self, name: str, uris: bytes) -> Message:
        """Answer requests until a message of this name comes; the window's own events are handled meanwhile."""
        event, wanted = Event(), self.atom(name)
        for _ in range(PATIENCE):
            glfw.wait_events_timeout(0.02)
            while self.x.XPending(self.display):
                self.x.XNextEvent(self.display, ctypes.byref(event))
                if event.kind == SELECTION_REQUEST:
                    self.hand_over(event.request, uris)
                elif event.kind == CLIENT_MESSAGE and event.message.name == wanted:
                    return event.message
        raise AssertionError(f"no {name} came")

    def hand_over(self, asked: Request, uris: bytes) -> None:
        where = (ctypes.c_ulong(asked.requestor), ctypes.c_ulong(asked.answer), ctypes.c_ulong(asked.target))
        self.x.XChangeProperty(self.display, *where, 8, 0, uris, len(uris))
        answer = Answer(
            SELECTION_NOTIFY, 0, 1, self.display, asked.requestor, asked.selection, asked.target, asked.answer, 0
        )
        event = Event()
        ctypes.memmove(ctypes.byref(event), ctypes.byref(answer), ctypes.sizeof(answer))
        self.x.XSendEvent(self.display, ctypes.c_ulong(asked.requestor), 0, ctypes.c_long(0), ctypes.byref(event))
        self.x.XFlush(self.display)

    def close(self) -> None:
        self.x.XCloseDisplay(self.display)
