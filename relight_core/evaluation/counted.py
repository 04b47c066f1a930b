"""Counts in words."""

from __future__ import annotations


def counted(count: int, thing: str) -> str:
    """So many of a thing whose plural has an s, as "1 head" and "8 heads"."""
    return f"{count} {thing}" if count == 1 else f"{count} {thing}s"
