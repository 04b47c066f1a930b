"""How relight owns up to a fault of its own."""

from __future__ import annotations


def confession(error: Exception) -> str:
    """An unexpected exception in a line that takes the blame."""
    return f"a fault of ours, not of your input ({type(error).__name__}: {' '.join(str(error).splitlines())})"
