"""How large a picture may be: checked against what a header claims, before anything is allocated for it."""

from __future__ import annotations

from pathlib import Path

from relight_core.errors import InputError

MAX_PIXELS = 400_000_000

BYTES_PER_PIXEL = 28
"""What reading takes at its peak: the decoded values, their linear light, and one copy on the way."""


def check_pixels(width: int, height: int, path: Path, bytes_per_pixel: int = BYTES_PER_PIXEL) -> None:
    """Refuse a picture of no pixels, of too many, or one that this machine has no memory for now.

    Raises:
        InputError: see above.
    """
    pixels = width * height
    if width < 1 or height < 1:
        raise InputError(f"{path}: an image of no pixels; export it again")
    if pixels > MAX_PIXELS:
        raise InputError(f"{path}: {width} x {height} is above 400 megapixels; make it smaller")
    free = free_bytes()
    if free is not None and pixels * bytes_per_pixel > free:
        needed_gb, free_gb = pixels * bytes_per_pixel / 1e9, free / 1e9
        raise InputError(
            f"{path}: {width} x {height} needs about {needed_gb:.1f} GB of memory and {free_gb:.1f} GB are free; "
            "make it smaller or close other programs"
        )


def free_bytes() -> int | None:
    """Memory that can be had without swapping; None where the system doesn't tell."""
    try:
        with open("/proc/meminfo", encoding="ascii") as lines:
            found = next(line for line in lines if line.startswith("MemAvailable:"))
        return int(found.split()[1]) * 1024
    except (OSError, StopIteration, ValueError, IndexError):
        return None
