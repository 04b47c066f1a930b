"""EXIF in TIFF files: theirs as a block, and a block as theirs (TIFF 6.0; CIPA DC-008, 4.6)."""

from __future__ import annotations

import struct

from relight_core.imaging.formats.exif_block import EXIF_IFD, GPS_IFD, Directory, laid_out, read_directory
from relight_core.imaging.formats.metadata import fitting_block, leave_picture_behind

_TEXT_TAGS = (270, 271, 272, 306, 315, 33432)
"""Description, maker, model, time, author, copyright."""

_MAKER_NOTE = 37500
_BLANK_BYTES = 256
"""A text whose first ones are blank says nothing."""

_CLASSIC_TIFF = b"II*\0"


def exif_of_tiff(data: bytes) -> bytes | None:
    """What a TIFF says of camera, time, place and author, as a block that starts with "Exif"; None if nothing.

    Its maker's notes stay behind: a raw file's are large and speak of the raw picture.
    """
    found = read_directory(data)
    if found is None:
        return None
    leave_picture_behind(found)
    said = _said(found)
    if EXIF_IFD in said.inner:
        said.inner[EXIF_IFD].entries.pop(_MAKER_NOTE, None)
    return fitting_block(said) if said.entries or said.inner else None


def with_exif(tiff: bytes, block: bytes | None) -> bytes:
    """A little-endian TIFF with what a block of EXIF says of camera, time, place and author.

    Its directory is written anew at the end, where there is room for more tags; what it says itself stays.
    """
    found = read_directory(block) if block else None
    own = read_directory(tiff) if tiff.startswith(_CLASSIC_TIFF) else None
    if found is None or own is None:
        return tiff
    said = _said(found).in_byte_order(own.order)
    start = len(tiff) + len(tiff) % 2
    whole = laid_out(Directory(own.order, {**said.entries, **own.entries}, said.inner), start)
    pixels = memoryview(tiff)[8:]
    return b"".join([_CLASSIC_TIFF, struct.pack("<I", start), pixels, bytes(start - len(tiff)), whole])


def _said(found: Directory) -> Directory:
    """The part of a directory that tells of the taking of the photo, not of the file."""
    texts = {tag: found.entries[tag] for tag in _TEXT_TAGS if tag in found.entries}
    texts = {tag: entry for tag, entry in texts.items() if bytes(entry.data[:_BLANK_BYTES]).strip(b"\0 ")}
    inner = {tag: found.inner[tag] for tag in (EXIF_IFD, GPS_IFD) if tag in found.inner}
    return Directory(found.order, texts, {tag: one for tag, one in inner.items() if one.entries or one.inner})
