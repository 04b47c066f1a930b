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
