"""Which of a TIFF's pictures is the photo: raw files and some programs' put a thumbnail before it."""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import tifffile

from relight_core.errors import InputError
from relight_core.imaging.formats.exif_block import ORIENTATION

_THUMBNAIL, _MASK = 1, 4
"""Bits of NewSubfileType (TIFF 6.0): a smaller picture of another, and another's transparency."""

_THUMBNAIL_PX = 512
"""Larger pictures may be called smaller ones of others by mistake; where there is no other, they are the photo."""

_MOST_PAGES = 32
"""To look at: a file could lead to the same directory again and again."""


def starting_with_photo(data: bytes, path: Path) -> tuple[bytes, int | None]:
    """A TIFF whose first picture is the first that is no thumbnail or mask of another, among those within pictures too.

    Returns:
        The file, `data` itself where it is so already; and the EXIF orientation of its former first picture, where
        the one that comes first now says none itself, else None.

    Raises:
        InputError: it holds nothing but thumbnails.
    """
    try:
        pages = tifffile.TiffFile(io.BytesIO(data)).pages
        if not _is_of_another(pages[0]):
            return data, None
        photo = next((page for page in islice(_pages(pages), _MOST_PAGES) if not _is_of_another(page)), None)
    except Exception:
        # Decoders tell of damage.
        return data, None
    if photo is None:
        if max(pages[0].imagewidth, pages[0].imagelength) > _THUMBNAIL_PX:
            return data, None
        raise InputError(f"{path}: a TIFF with nothing but a thumbnail; export the picture itself")
    order, is_big = "<" if data[:2] == b"II" else ">", b"+" in data[2:4]
    place = struct.pack(order + ("Q" if is_big else "I"), photo.offset)
    start = 8 if is_big else 4
    moved = b"".join([data[:start], place, memoryview(data)[start + len(place) :]])
    return moved, None if ORIENTATION in photo.tags else stated_orientation(pages[0])


def stated_orientation(page: tifffile.TiffPage) -> int | None:
    """EXIF's orientation of a picture in a TIFF, 1 to 8; None where it states none."""
    tag = page.tags.get(ORIENTATION)
    return int(tag.value) if tag is not None and tag.value in range(1, 9) else None


def _pages(pages: tifffile.TiffPages) -> Iterator[tifffile.TiffPage]:
    for page in pages:
        yield page
        yield from page.pages or ()


def _is_of_another(page: tifffile.TiffPage) -> bool:
    return bool(page.subfiletype & (_THUMBNAIL | _MASK))
