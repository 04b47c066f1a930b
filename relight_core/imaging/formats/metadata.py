"""What a photo's file says beside its pixels, as far as a result may say it too."""

from __future__ import annotations

import struct

from PIL import Image

from relight_core.imaging.formats.exif_block import (
    EXIF_IFD,
    INTEROPERABILITY_IFD,
    ORIENTATION,
    Directory,
    Entry,
    block_of,
    read_directory,
)

_PICTURE_ITSELF = (
    *(256, 257, 258, 259, 262, 273, 277, 278, 279, 284, 301, 317, 318, 319, 320, 322, 323, 324, 325, 330),
    *(338, 339, 347, 529, 530, 531, 532, 700, 34675),
)
"""How its pixels are stored, other pictures in the file, the colours and the profile; XMP would tell of edits that
are undone."""

_PICTURE_ITSELF_IN_SETTINGS = (37122, 40961, 40962, 40963, 42240)
"""Among the camera's settings: how tightly it is packed, its colour space, sides and gamma."""

_PROGRAMS_OWN = (33723, 34377, 37724)
"""IPTC, Photoshop's resources and its layers: of the file as it was, and of many megabytes at times."""

_UPRIGHT = 1
_LARGEST_BLOCK = 60_000
"""Bytes: a JPEG's segment holds 65,533."""


def carried_exif(image: Image.Image, data: bytes) -> bytes | None:
    """An opened file's EXIF as a result may carry it: camera, time, place and author, upright, no thumbnail.

    Args:
        data: the file.

    Returns:
        A block that starts with "Exif"; None where there is nothing or it is damaged.
    """
    return carried_block(exif_of(image, data))


def exif_of(image: Image.Image, data: bytes) -> bytes | None:
    """An opened file's EXIF as it stands, a TIFF's being the TIFF itself; None where there is none."""
    block = image.info.get("exif")
    if block is None and image.format == "TIFF":
        block = data
    if block is None and "Raw profile type exif" in image.info:
        # ImageMagick's way of before PNG had EXIF: a name, a length, and the block in hexadecimal digits.
        try:
            block = bytes.fromhex("".join(image.info["Raw profile type exif"].split("\n")[3:]))
        except ValueError:
            return None
    return block


def carried_block(block: bytes | None) -> bytes | None:
    """The same for a file's EXIF as a block of bytes, or for a TIFF, whose directories are EXIF's."""
    found = read_directory(block) if isinstance(block, bytes) else None
    if found is None:
        return None
    for tag in (*_PICTURE_ITSELF, *_PROGRAMS_OWN):
        found.entries.pop(tag, None)
    leave_picture_behind(found)
    if not found.entries and not found.inner:
        return None
    found.entries[ORIENTATION] = Entry(3, 1, struct.pack(found.order + "H", _UPRIGHT))
    return fitting_block(found)


def leave_picture_behind(directory: Directory) -> None:
    """Take out of a file's first directory what the camera's settings say of the picture as it was stored."""
    settings = directory.inner.get(EXIF_IFD)
    if settings is None:
        return
    for tag in _PICTURE_ITSELF_IN_SETTINGS:
        settings.entries.pop(tag, None)
    # By which rules the file was named and which colours it is in.
    settings.inner.pop(INTEROPERABILITY_IFD, None)
    if not settings.entries:
        del directory.inner[EXIF_IFD]


def fitting_block(directory: Directory) -> bytes:
    """A directory as a block that every format holds: its largest values, makers' notes mostly, go if they must."""
    excess = directory.size_bytes - _LARGEST_BLOCK
    holders, entries = [directory], []
    for holder in holders:
        holders += holder.inner.values()
        entries += [(len(entry.data), holder, tag) for tag, entry in holder.entries.items()]
    for size, holder, tag in sorted(entries, key=lambda entry: entry[0], reverse=True):
        if excess <= 0:
            break
        del holder.entries[tag]
        excess -= size + 12
    return block_of(directory)
