"""Blocks of EXIF and the directories of TIFFs, byte for byte (TIFF 6.0, section 2; CIPA DC-008, 4.6).

Texts stay the bytes they are: EXIF calls them ASCII, and programs write UTF-8 or Latin-1.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

ORIENTATION, EXIF_IFD, GPS_IFD, INTEROPERABILITY_IFD = 274, 34665, 34853, 40965
_INNER = {EXIF_IFD: {INTEROPERABILITY_IFD: {}}, GPS_IFD: {}}
"""Tags that lead to a directory within one, and those within that."""

_PREFIX = b"Exif\0\0"
_ORDERS = {b"II": "<", b"MM": ">"}
_SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 6: 1, 7: 1, 8: 2, 9: 4, 10: 8, 11: 4, 12: 8, 129: 1}
"""Bytes of one value by its kind; places in the file, which wouldn't survive a move, are left out."""

_WORDS = {3: 2, 4: 4, 5: 4, 8: 2, 9: 4, 10: 4, 11: 4, 12: 8}
"""Bytes that the order of bytes turns round, by the kind of value."""

_SHORT_PLACES = (4, 13)
"""Kinds of values that are places of 4 bytes, in a BigTIFF too."""

_BIG = 43
_SMALL = (42, 0x55, 0x4F52, 0x5352)
"""TIFF's number, and those of Panasonic's and Olympus's raw files, which are TIFFs otherwise."""

_MOST_ENTRIES = 65535


class _Layout(NamedTuple):
    """How wide numbers are in a TIFF.

    Attributes:
        first: where the place of the first directory stands.
        count: the code of a directory's number of entries.
        place: the code of places and of numbers of values.
    """

    first: int
    count: str
    place: str


_CLASSIC, _WIDE = _Layout(4, "H", "I"), _Layout(8, "Q", "Q")


class Entry(NamedTuple):
    """A tag's value.

    Attributes:
        kind: TIFF's number of its type.
        count: how many values.
        data: their bytes, in the directory's order.
    """

    kind: int
    count: int
    data: bytes | memoryview


@dataclass(frozen=True)
class Directory:
    """What tags say.

    Attributes:
        order: of bytes, "<" or ">".
        entries: by tag.
        inner: the directories within, by tag.
    """

    order: str
    entries: dict[int, Entry]
    inner: dict[int, Directory]

    @property
    def size_bytes(self) -> int:
        """What it takes in a file at the most."""
        own = sum(len(entry.data) + 13 for entry in self.entries.values()) + 6
        return own + sum(directory.size_bytes + 12 for directory in self.inner.values())

    def in_byte_order(self, order: str) -> Directory:
        """The same in an order of bytes, "<" or ">"; makers' notes and comments stay as they are."""
        if order == self.order:
            return self
        entries = {tag: entry._replace(data=_turned(entry)) for tag, entry in self.entries.items()}
        return Directory(order, entries, {tag: one.in_byte_order(order) for tag, one in self.inner.items()})


def read_directory(data: bytes) -> Directory | None:
    """The first directory of an EXIF block, a TIFF or a BigTIFF, with those of EXIF, place and interoperability.

    Values that lie outside the data, or are of an unknown kind, are left out. Values are views: nothing is copied.

    Returns:
        None where it is none of them or holds no directory.
    """
    data = data.removeprefix(_PREFIX).removeprefix(_PREFIX)
    order = _ORDERS.get(data[:2])
    if order is None:
        return None
    try:
        (number,) = struct.unpack_from(order + "H", data, 2)
        if number != _BIG and number not in _SMALL:
            return None
        layout = _WIDE if number == _BIG else _CLASSIC
        (start,) = struct.unpack_from(order + layout.place, data, layout.first)
        return _directory(memoryview(data), order, layout, start, _INNER)
    except struct.error:
        return None


def block_of(directory: Directory) -> bytes:
    """A directory as a block of EXIF that starts with "Exif"."""
    mark = next(name for name, order in _ORDERS.items() if order == directory.order)
    return _PREFIX + mark + struct.pack(directory.order + "HI", 42, 8) + laid_out(directory, 8)


def laid_out(directory: Directory, start: int) -> bytes:
    """A directory as it stands in a TIFF, with its values and the directories within.

    Args:
        start: its place in the file, even.
    """
    order, tags = directory.order, sorted([*directory.entries, *directory.inner])
    table, values = bytearray(struct.pack(order + "H", len(tags))), bytearray()
    first_value = start + 2 + 12 * len(tags) + 4
    for tag in tags:
        place = first_value + len(values)
        if tag in directory.inner:
            table += struct.pack(order + "HHII", tag, 4, 1, place)
            values += laid_out(directory.inner[tag], place)
        else:
            kind, count, data = directory.entries[tag]
            table += struct.pack(order + "HHI", tag, kind, count)
            table += bytes(data).ljust(4, b"\0") if len(data) <= 4 else struct.pack(order + "I", place)
            values += data if len(data) > 4 else b""
        values += bytes(len(values) % 2)
    return bytes(table + bytes(4) + values)


def _directory(data: memoryview, order: str, layout: _Layout, start: int, inner: dict) -> Directory:
    found = Directory(order, {}, {})
    (count,) = struct.unpack_from(order + layout.count, data, start)
    width = struct.calcsize("=" + layout.place)
    first = start + struct.calcsize("=" + layout.count)
    for i in range(min(count, _MOST_ENTRIES)):
        at = first + (4 + 2 * width) * i
        if at + 4 + 2 * width > len(data):
            break
        tag, kind, number = struct.unpack_from(order + "HH" + layout.place, data, at)
        value, size = at + 4 + width, _SIZES.get(kind, 0) * number
        if tag in inner:
            (lies,) = struct.unpack_from(order + ("I" if kind in _SHORT_PLACES else layout.place), data, value)
            # Each once: many entries that lead to one long directory would take forever.
            if tag not in found.inner and lies + 8 <= len(data):
                found.inner[tag] = _directory(data, order, layout, lies, inner[tag])
            continue
        if size > width:
            (value,) = struct.unpack_from(order + layout.place, data, value)
        if 0 < size <= len(data) - value:
            found.entries[tag] = Entry(kind, number, data[value : value + size])
    return found


def _turned(entry: Entry) -> bytes:
    """Its bytes in the other order."""
    word = _WORDS.get(entry.kind)
    return bytes(entry.data) if word is None else np.frombuffer(entry.data, f"u{word}").byteswap().tobytes()
