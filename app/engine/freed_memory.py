"""Memory that was freed goes back to the system: glibc keeps it, some gigabytes after twenty photos."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from functools import lru_cache


def give_back_freed_memory() -> None:
    """Hand freed memory back where the C library would keep it; takes some milliseconds."""
    trim = _trim()
    if trim is not None:
        trim(0)


@lru_cache(maxsize=1)
def _trim() -> Callable[[int], int] | None:
    if sys.platform != "linux":
        return None
    # Other C libraries than glibc have no such function.
    return getattr(ctypes.CDLL(None), "malloc_trim", None)
