"""What is told on stderr need not arrive, and stops nothing where it does not."""

from __future__ import annotations

import contextlib
import os
import sys
from typing import TextIO


def tell(text: str, end: str = "\n") -> None:
    """Print a line on stderr; where it can't be written it stays unheard."""
    with contextlib.suppress(OSError):
        print(text, end=end, file=sys.stderr, flush=True)


class Heedless:
    """A stream that fails at nothing: what can't be written to it stays unheard."""

    def __init__(self, stream: TextIO) -> None:
        """Write to `stream`."""
        self._stream = stream

    def write(self, text: str) -> int:
        """Write, or don't; returns the length of the text."""
        with contextlib.suppress(OSError):
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Push out what is possible."""
        with contextlib.suppress(OSError):
            self._stream.flush()

    def __getattr__(self, name: str):
        return getattr(self._stream, name)


def let_go_of_streams() -> None:
    """Drop what stdout and stderr can't get rid of: the interpreter would fail at it and exit with its own code."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
