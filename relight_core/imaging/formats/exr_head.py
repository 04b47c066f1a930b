"""The head of an EXR file, looked through before OpenEXR's, whose time grows with the square of the channels."""

from __future__ import annotations

import struct
from io import BufferedReader
from pathlib import Path

_CHANNEL_LIST = b"chlist"
_IN_PARTS = 0x1000
_LONGEST_TEXT = 256
_CHANNEL_BYTES = 16
"""What a list says of a channel after its name: kind, linearity and sampling."""

_LONGEST_LIST = 1 << 26


def most_channels(path: Path) -> int:
    """How many channels the fullest part of a file lists, as far as its head can be followed.

    Raises:
        OSError: it can't be read.
    """
    most = 0
    with path.open("rb") as file:
        try:
            _, version = struct.unpack("<4sI", file.read(8))
            while (of_part := _channels_of_part(file)) is not None:
                most = max(most, of_part)
                if not version & _IN_PARTS:
                    break
        except (struct.error, ValueError):
            # Cut or damaged, which OpenEXR says soon.
            pass
    return most


def _channels_of_part(file: BufferedReader) -> int | None:
    """The channels that one part's attributes list; None where there is no other part."""
    count = None
    while _text(file):
        count, kind = count or 0, _text(file)
        (size,) = struct.unpack("<I", file.read(4))
        if kind == _CHANNEL_LIST:
            count += _listed(file.read(min(size, _LONGEST_LIST)))
        else:
            file.seek(size, 1)
    return count


def _text(file: BufferedReader) -> bytes:
    """What stands before the next zero byte.

    Raises:
        ValueError: there is none near.
    """
    start = file.tell()
    text = file.read(_LONGEST_TEXT)
    length = text.index(b"\0")
    file.seek(start + length + 1)
    return text[:length]


def _listed(channels: bytes) -> int:
    count, at = 0, 0
    while (end := channels.find(b"\0", at)) > at:
        count, at = count + 1, end + 1 + _CHANNEL_BYTES
    return count
