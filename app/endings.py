"""How others tell the program to end: it then puts away what is half done, as after Ctrl + C."""

from __future__ import annotations

import _thread
import signal
import sys
import threading
import time
from importlib.machinery import ExtensionFileLoader
from types import FrameType

ENDINGS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Ctrl + C, a shutdown or `kill`, a terminal that was closed."""

_INITIALISES = (ExtensionFileLoader.create_module.__code__, ExtensionFileLoader.exec_module.__code__)
"""What lets C code make a module of itself."""

_OF_IMPORTS = ("<frozen importlib._bootstrap>", "<frozen importlib._bootstrap_external>")
"""The files of Python's own code that imports."""

_LOOKS_EVERY_S = 0.01

_waits = threading.Event()
"""Set while an interrupt waits."""


def take_endings_for_interrupts() -> None:
    """Let every one of them raise KeyboardInterrupt, but for those that are ignored, as `nohup` wants it."""
    for number in ENDINGS:
        if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, _interrupt)


def raises_interrupts(number: int) -> bool:
    """Whether a signal raises KeyboardInterrupt now."""
    return signal.getsignal(number) in (signal.default_int_handler, _interrupt)


def raise_no_more() -> None:
    """What was asked to end does: another Ctrl + C changes nothing, and any other ends it where it stands.

    A second interrupt would be raised in what is being let go of, as a traceback that the interpreter ignores.
    """
    for number in ENDINGS:
        if raises_interrupts(number):
            signal.signal(number, signal.SIG_IGN if number == signal.SIGINT else signal.SIG_DFL)


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt; where an import would drop it only after that, unless another one waits already.

    The C code of NumPy and PyTorch does while it makes a module of itself: the program would go on as if nobody had
    interrupted it, or take itself for broken.
    """
    if _waits.is_set() or not _drops_interrupts(frame):
        _waits.clear()
        raise KeyboardInterrupt
    _waits.set()
    threading.Thread(target=_interrupt_later, args=(number,), name="relight-ending", daemon=True).start()


def _drops_interrupts(frame: FrameType | None) -> bool:
    """Whether a module is being made of C code there, or Python's code that imports is at work, part of it unheard.

    Or whether an interrupt is being put off there at this moment.
    """
    if frame is not None and frame.f_code.co_filename in _OF_IMPORTS:
        return True
    while frame is not None and frame.f_code not in (*_INITIALISES, _interrupt.__code__):
        frame = frame.f_back
    return frame is not None


def _interrupt_later(number: int) -> None:
    main = threading.main_thread().ident
    while _drops_interrupts(sys._current_frames().get(main)):
        time.sleep(_LOOKS_EVERY_S)
    if not _waits.is_set():
        return
    _waits.clear()
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(main, number)
    else:
        _thread.interrupt_main(number)
