"""How relight tells what went wrong, and owns up to a fault of its own."""

from __future__ import annotations

from relight_core.errors import InputError


def confession(error: Exception) -> str:
    """An unexpected exception in a line that takes the blame."""
    return f"a fault of ours, not of your input ({type(error).__name__}: {' '.join(str(error).splitlines())})"


def error_line(error: Exception) -> str:
    """What the user of the window reads of an exception: an InputError's own line, or a confession."""
    return str(error) if isinstance(error, InputError) else confession(error)
