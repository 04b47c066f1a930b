"""What is said on stdout has to arrive; what is told on stderr need not, and stops nothing where it does not."""

from __future__ import annotations

import contextlib
import os
import sys
from typing import TextIO

from relight_core.errors import InputError


def say(text: str) -> None:
    """Print a line of what was asked for on stdout.

    Raises:
        InputError: it can't be written.
        BrokenPipeError: whoever read it has left.
    """
    with _refusal_in_a_line():
        print(text, flush=True)


def flush_said() -> None:
    """Push out what has been printed on stdout; raises as `say`."""
    with _refusal_in_a_line():
        sys.stdout.flush()


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


@contextlib.contextmanager
def _refusal_in_a_line():
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(f"the output can't be written ({reason})") from error
