"""How relight tells what went wrong, and owns up to a fault of its own."""

from __future__ import annotations

from relight_core.errors import InputError


def confession(error: Exception) -> str:
    """An unexpected exception in a line that takes the blame."""
    return f"a fault of ours, not of your input ({type(error).__name__}: {' '.join(str(error).splitlines())})"


def error_line(error: Exception) -> str:
    """What the user of the window reads of an exception: an InputError's own line, or a confession.

    There a line stands alone, and begins with a capital where it doesn't with the name of a file.
    """
    if isinstance(error, InputError):
        return str(error)
    words = confession(error)
    return words[0].upper() + words[1:]
