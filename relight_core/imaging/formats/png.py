"""PNG files written a band of rows at a time, compressed on several threads (PNG specification, third edition).

Each band is filtered and deflated by itself; the parts end on byte borders and are laid one after the other
into one zlib stream, so that neither the file nor the picture is ever held whole.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable
from typing import BinaryIO

import numpy as np

from relight_core.imaging.in_order import in_order

SIGNATURE = b"\x89PNG\r\n\x1a\n"
_COLOUR_TYPES = {3: 2, 4: 6}
_SUB, _UP = 1, 2
_ZLIB_HEADER = b"\x78\x01"
_LEVEL = 1


def chunk(kind: bytes, data: bytes) -> bytes:
    """A PNG chunk with its length and checksum."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def write_png(file: BinaryIO, size: tuple[int, int], channels: int, bits: int, bands: Iterable, notes: bytes) -> None:
    """Write a PNG of colour, or of colour and alpha.

    Args:
        size: (height, width).
        channels: 3 or 4.
        bits: per channel, 8 or 16.
        bands: arrays (h, width, channels) of uint8 or uint16, from the top down.
        notes: chunks that come before the pixels.
    """
    header = struct.pack(">IIBBBBB", size[1], size[0], bits, _COLOUR_TYPES[channels], 0, 0, 0)
    file.write(SIGNATURE + chunk(b"IHDR", header) + notes)
    file.write(chunk(b"IDAT", _ZLIB_HEADER))
    checksum = 1
    for packed, filtered in in_order(_deflated, bands):
        checksum = zlib.adler32(filtered, checksum)
        file.write(chunk(b"IDAT", packed))
    ending = zlib.compressobj(_LEVEL, zlib.DEFLATED, -15).flush(zlib.Z_FINISH)
    file.write(chunk(b"IDAT", ending + struct.pack(">I", checksum)))
    file.write(chunk(b"IEND", b""))


def _deflated(band: np.ndarray) -> tuple[bytes, bytes]:
    """A band's part of the deflate stream, and the bytes it stands for."""
    filtered = _filtered(band)
    packer = zlib.compressobj(_LEVEL, zlib.DEFLATED, -15, 9, zlib.Z_RLE)
    return packer.compress(filtered) + packer.flush(zlib.Z_FULL_FLUSH), filtered


def _filtered(band: np.ndarray) -> bytes:
    """Rows as differences to the row above, a band's first row to the pixel on the left; filter type first."""
    height, width, channels = band.shape
    data = np.ascontiguousarray(band, band.dtype.newbyteorder(">")).view(np.uint8).reshape(height, -1)
    step = channels * band.dtype.itemsize
    rows = np.empty((height, data.shape[1] + 1), np.uint8)
    rows[:, 0] = _UP
    rows[0, 0] = _SUB
    rows[0, 1 : step + 1] = data[0, :step]
    np.subtract(data[0, step:], data[0, :-step], out=rows[0, step + 1 :])
    np.subtract(data[1:], data[:-1], out=rows[1:, 1:])
    return rows.tobytes()
