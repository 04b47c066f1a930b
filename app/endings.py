"""How others tell the program to end: it then puts away what is half done, as after Ctrl + C."""

from __future__ import annotations

import signal

ENDINGS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Ctrl + C, a shutdown or `kill`, a terminal that was closed."""


def take_endings_for_interrupts() -> None:
    """Let every one of them raise KeyboardInterrupt, but for those that are ignored, as `nohup` wants it."""
    for number in ENDINGS:
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, signal.default_int_handler)


def raise_no_more() -> None:
    """What was asked to end does: another Ctrl + C changes nothing, and any other ends it where it stands.

    A second interrupt would be raised in what is being let go of, as a traceback that the interpreter ignores.
    """
    for number in ENDINGS:
        if signal.getsignal(number) is signal.default_int_handler:
            signal.signal(number, signal.SIG_IGN if number == signal.SIGINT else signal.SIG_DFL)
