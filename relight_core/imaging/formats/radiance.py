"""Radiance pictures (.hdr), in any order of rows and columns, packed in any way, as RGBE or XYZE."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from relight_core.errors import InputError
from relight_core.imaging.formats.chromaticities import to_rec709
from relight_core.imaging.formats.limits import check_pixels
from relight_core.imaging.formats.opencv_decoding import decoded_by_opencv

_BLOCK_ROWS = 256
_LONGEST_HEADER = 65536
_HEADER_END = re.compile(rb"\r?\n\r?\n")
_SIZE = re.compile(rb"\s*([+-])([XY])\s+(\d{1,9})\s+([+-])([XY])\s+(\d{1,9})[ \t]*\r?\n")
_XYZE = re.compile(rb"^FORMAT\s*=\s*32-bit_rle_xyze\s*$", re.MULTILINE)
_PACKED_WIDTHS = range(8, 32768)


@dataclass(frozen=True)
class _Layout:
    """A file's order of pixels: `lines` of `length`, columns if `upended`, and which ends they start at."""

    lines: int
    length: int
    upended: bool
    lines_reversed: bool
    length_reversed: bool
    is_xyz: bool


def decode_radiance_hdr(data: bytes, path: Path) -> np.ndarray:
    """Radiance .hdr to (H, W, 3) float32 linear Rec.709; what the file says of exposure is left aside.

    Raises:
        InputError: damaged or too large.
    """
    layout, pixels = _header(data, path)
    check_pixels(layout.length, layout.lines, path)
    if not _is_packed_by_channels(pixels, layout.length):
        pixels = _unpacked(pixels, layout.lines * layout.length, path)
    size = b"-Y %d +X %d\n" % (layout.lines, layout.length)
    # OpenCV knows this one order of header, rows and columns.
    bgr = decoded_by_opencv(b"".join([b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n", size, pixels]))
    if bgr is None or bgr.dtype != np.float32:
        raise _incomplete(path)
    # XYZ of Radiance has a white of 1, 1, 1.
    matrix = to_rec709(np.eye(3)).T.astype(np.float32) if layout.is_xyz else None
    for start in range(0, len(bgr), _BLOCK_ROWS):
        rows = bgr[start : start + _BLOCK_ROWS]
        rows[:] = rows[..., ::-1].copy() if matrix is None else rows[..., ::-1] @ matrix
    return _upright(bgr, layout)


def _header(data: bytes, path: Path) -> tuple[_Layout, memoryview]:
    """What the header says, and the bytes behind it."""
    end = _HEADER_END.search(data, 0, _LONGEST_HEADER)
    size = _SIZE.match(data, end.end()) if end else None
    if size is None or {size[2], size[5]} != {b"X", b"Y"}:
        raise _incomplete(path)
    lines_sign, first, lines, length_sign, _, length = size.groups()
    upended = first == b"X"
    # Y counts from the bottom up.
    backwards = [
        sign == (b"-" if axis_is_x else b"+") for sign, axis_is_x in ((lines_sign, upended), (length_sign, not upended))
    ]
    is_xyz = _XYZE.search(data, 0, end.start() + 1) is not None
    return _Layout(int(lines), int(length), upended, *backwards, is_xyz), memoryview(data)[size.end() :]


def _is_packed_by_channels(pixels: memoryview, width: int) -> bool:
    """Whether scanlines hold one channel after the other, each packed by itself, as all programs write them now."""
    return width in _PACKED_WIDTHS and bytes(pixels[:2]) == b"\2\2" and len(pixels) > 2 and pixels[2] < 128


def _unpacked(pixels: memoryview, count: int, path: Path) -> memoryview:
    """Pixels of four bytes each, among which mantissas of 1, 1, 1 say how often the one before comes again."""
    stored = np.frombuffer(pixels[: len(pixels) // 4 * 4], np.uint8).reshape(-1, 4)[:count]
    again = (stored[:, :3] == 1).all(axis=1)
    if not again.any():
        return pixels
    places = np.arange(len(stored))
    last = np.maximum.accumulate(np.where(again, -1, places))
    # Each repetition straight after another counts 256 times as much.
    power = np.minimum(8 * (places - last - 1), 32)
    repeats = np.where(again, stored[:, 3].astype(np.int64) << np.where(again, power, 0), 1)
    ends = np.cumsum(np.minimum(repeats, count + 1))
    used = int(np.searchsorted(ends, count)) + 1
    if again[0] or used > len(stored) or ends[used - 1] != count:
        raise _incomplete(path)
    return memoryview(np.repeat(stored[last[:used]], repeats[:used], axis=0)).cast("B")


def _upright(picture: np.ndarray, layout: _Layout) -> np.ndarray:
    picture = picture[:: -1 if layout.lines_reversed else 1, :: -1 if layout.length_reversed else 1]
    return np.ascontiguousarray(picture.swapaxes(0, 1) if layout.upended else picture)


def _incomplete(path: Path) -> InputError:
    return InputError(f"{path}: not a complete Radiance file; export it again")
