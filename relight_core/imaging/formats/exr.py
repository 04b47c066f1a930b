"""OpenEXR files. The only module that hands arrays to OpenEXR, which reads any memory as C-contiguous."""

from __future__ import annotations

import contextlib
import errno
from collections.abc import Collection, Iterable, Iterator, Sequence
from pathlib import Path

import cv2
import Imath
import numpy as np
import OpenEXR

from relight_core.errors import InputError
from relight_core.imaging.files import check_regular, is_legible
from relight_core.imaging.formats.chromaticities import is_rec709, rgb_to_xyz, to_rec709
from relight_core.imaging.formats.exr_head import most_channels
from relight_core.imaging.formats.limits import MAX_PIXELS, check_pixels
from relight_core.imaging.formats.quiet_libraries import quiet
from relight_core.imaging.half_floats import LARGEST_HALF
from relight_core.imaging.in_order import WORKERS

# Left alone it packs and unpacks on one thread.
OpenEXR.set_global_thread_count(WORKERS)

MAX_SAMPLES = 4 * MAX_PIXELS

MAGIC = b"\x76\x2f\x31\x01"

_MAX_CHANNELS = 4096
_BLOCK_ROWS = 256
_LARGEST_SPARE_TILE = 1024
_BYTES_PER_PIXEL = 18
"""Colour and alpha as float32, and what one block of rows takes."""

_PICTURE_LAYERS = ("combined", "composite", "beauty", "rgba", "rgb")
"""What renderers call the picture itself among their passes, which may come before it by name."""

_FLOAT, _HALF = Imath.PixelType(Imath.PixelType.FLOAT), Imath.PixelType(Imath.PixelType.HALF)

_DAMAGE = (RuntimeError, ValueError, TypeError, IndexError, KeyError, AttributeError, OSError, MemoryError)


def read_exr(path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    """The colour of an EXR file as it is stored: values are not cleaned, alpha stays multiplied in.

    Reads R, G, B (or Y, or of the layers that have colour the one named as the picture, else the first) over
    the display window; what lies outside the data window is 0. Other primaries are converted to Rec.709.
    Rows are read some hundred at a time, and only the channels that are wanted: memory holds the result and
    little more.

    Returns:
        (H, W, 3) float32 linear, and (H, W) float32 alpha or None.

    Raises:
        InputError: damaged, too large, or without colour channels.
    """
    header = _read_header(path)
    if header.get("type") in (OpenEXR.deepscanline, OpenEXR.deeptile):
        raise InputError(f"{path}: a deep EXR, with samples at several depths of a pixel; export it flat")
    try:
        sampling = {channel.name: (channel.xSampling, channel.ySampling) for channel in header["channels"]}
        names = _colour_names(sampling)
        if names is None and any(name.rpartition(".")[2] == "RY" for name in sampling):
            raise InputError(f"{path}: its colours are stored as luminance and chroma; export it as RGB")
        if names is None:
            raise InputError(f"{path}: no channels R, G, B or Y in its first part; export it with colour there")
        if any(sampling[name] != (1, 1) for name in names):
            raise InputError(f"{path}: its colour channels differ in size; export it as RGB")
        alpha_name = names[0].rpartition(".")[0] + ".A" if "." in names[0] else "A"
        with_alpha = sampling.get(alpha_name) == (1, 1)
        with quiet():
            values = _read_rows(path, header, [*names, alpha_name] if with_alpha else names)
        values = _on_display_window(values, header)
        colour = _to_rec709(values[..., :3], header)
        return np.ascontiguousarray(colour), np.ascontiguousarray(values[..., 3]) if with_alpha else None
    except InputError:
        raise
    except MemoryError:
        raise InputError(f"{path}: not enough memory is free for it; make it smaller or close other programs") from None
    except _DAMAGE:
        raise InputError(f"{path}: not a complete EXR file; export it again") from None


def exr_size(path: Path) -> tuple[int, int]:
    """Width and height of the display window as the header states it.

    Raises:
        InputError: no regular file, no EXR, or one that is too large.
    """
    low, high = _read_header(path)["displayWindow"]
    return int(high[0] - low[0] + 1), int(high[1] - low[1] + 1)


def _read_header(path: Path) -> dict:
    try:
        check_regular(path)
        if not is_legible(str(path)):
            raise InputError(f"{path}: OpenEXR can't open names that are no text; rename the file or its folder")
        _check_channels(most_channels(path), path)
        with quiet(), OpenEXR.File(str(path), header_only=True) as file:
            header = dict(file.header())
        _check_size(header, path)
    except InputError:
        raise
    except _DAMAGE:
        raise InputError(f"{path}: not a complete EXR file; export it again") from None
    return header


def _read_rows(path: Path, header: dict, names: Sequence[str]) -> np.ndarray:
    """(rows, columns, names) float32 over the data window."""
    (left, top), (right, bottom) = (tuple(int(v) for v in corner) for corner in header["dataWindow"])
    file = OpenEXR.InputFile(str(path))
    try:
        if not file.isComplete():
            raise ValueError("rows are missing")
        width = right - left + 1
        values = np.empty((bottom - top + 1, width, len(names)), np.float32)
        for start in range(top, bottom + 1, _BLOCK_ROWS):
            end = min(start + _BLOCK_ROWS - 1, bottom)
            wanted = list(dict.fromkeys(names))
            rows = dict(zip(wanted, file.channels(wanted, _FLOAT, start, end), strict=True))
            for index, name in enumerate(names):
                values[start - top : end - top + 1, :, index] = np.frombuffer(rows[name], np.float32).reshape(-1, width)
    finally:
        file.close()
    return values


def write_rows(
    path: Path, size: tuple[int, int], names: Sequence[str], kind: type, bands: Iterable[np.ndarray], header: dict
) -> None:
    """Write channels band by band, ZIP-compressed scanlines, to exactly this path; nothing is held whole.

    Args:
        path: overwritten.
        size: (height, width).
        names: of the channels, the main layer's being letters of "RGBA".
        kind: float16 or float32.
        bands: arrays (h, width, len(names)) of that type, from the top down.
        header: attributes beside the standard ones: str, int or float.

    Raises:
        OSError: the library can't write there; what `bands` raises comes through as it is.
    """
    attributes = {name: note.encode("utf-8") if isinstance(note, str) else note for name, note in header.items()}
    attributes |= OpenEXR.Header(size[1], size[0])
    channel = Imath.Channel(_HALF if kind == np.float16 else _FLOAT)
    attributes["channels"] = dict.fromkeys(names, channel)
    attributes["compression"] = Imath.Compression(Imath.Compression.ZIP_COMPRESSION)
    with _refusal_as_os_error():
        file = OpenEXR.OutputFile(_spelt(path), attributes)
    try:
        for band in bands:
            rows = {name: np.ascontiguousarray(band[..., i]).tobytes() for i, name in enumerate(names)}
            with _refusal_as_os_error():
                file.writePixels(rows, len(band))
    finally:
        with _refusal_as_os_error():
            file.close()


def _spelt(path: Path) -> str:
    """The path for OpenEXR, which ends the whole process at one that is no text.

    Raises:
        OSError: it is none.
    """
    if not is_legible(str(path)):
        raise OSError(errno.EILSEQ, "OpenEXR takes no names that are no text")
    return str(path)


def limited(array: np.ndarray, kind: type) -> np.ndarray:
    """The array as float16, limited to +-65504 where it would become infinite, or as float32."""
    if kind != np.float16:
        return np.asarray(array, kind)
    array = np.clip(array, -LARGEST_HALF, LARGEST_HALF)
    if array.dtype != np.float32 or not array.size:
        return np.asarray(array, kind)
    # OpenCV's is ten times as quick as numpy's.
    return cv2.convertFp16(np.ascontiguousarray(array).reshape(1, -1)).view(np.float16).reshape(array.shape)


def _check_channels(channels: int, path: Path) -> None:
    if channels > _MAX_CHANNELS:
        raise InputError(f"{path}: {channels} channels are too many; export fewer layers")


def _check_size(header: dict, path: Path) -> None:
    channels = len(header.get("channels", ()))
    # Again: a head that OpenEXR can follow further than `most_channels` does.
    _check_channels(channels, path)
    for window in ("dataWindow", "displayWindow"):
        low, high = header[window]
        width, height = (int(high[i]) - int(low[i]) + 1 for i in (0, 1))
        check_pixels(width, height, path, _BYTES_PER_PIXEL)
        if width * height * channels > MAX_SAMPLES:
            raise InputError(f"{path}: {channels} channels of {width} x {height} are too many; export fewer layers")
        if window == "dataWindow":
            _check_tiles(header.get("tiles"), width, height, path)


def _check_tiles(tiles: object, width: int, height: int, path: Path) -> None:
    """A tile is decoded as a whole, so one far larger than the picture takes any time and memory."""
    if tiles is None:
        return
    if tiles.xSize > max(width, _LARGEST_SPARE_TILE) or tiles.ySize > max(height, _LARGEST_SPARE_TILE):
        raise InputError(f"{path}: its tiles of {tiles.xSize} x {tiles.ySize} exceed the picture; export it in lines")


def _colour_names(channels: Collection[str]) -> tuple[str, str, str] | None:
    layers = {name.rpartition(".")[0] for name in channels if "." in name}
    of_picture = {layer for layer in layers if layer.rpartition(".")[2].lower() in _PICTURE_LAYERS}
    prefixes = ["", *(layer + "." for layer in [*sorted(of_picture), *sorted(layers - of_picture)])]
    for prefix in prefixes:
        if all(prefix + letter in channels for letter in "RGB"):
            return prefix + "R", prefix + "G", prefix + "B"
    for prefix in prefixes:
        if prefix + "Y" in channels and prefix + "RY" not in channels:
            return (prefix + "Y",) * 3
    return None


def _on_display_window(data: np.ndarray, header: dict) -> np.ndarray:
    (data_low, _), (low, high) = header["dataWindow"], header["displayWindow"]
    width, height = (int(high[i]) - int(low[i]) + 1 for i in (0, 1))
    left, top = (int(data_low[i]) - int(low[i]) for i in (0, 1))
    if (left, top) == (0, 0) and data.shape[:2] == (height, width):
        return data
    canvas = np.zeros((height, width, data.shape[2]), np.float32)
    rows = slice(max(top, 0), max(min(top + data.shape[0], height), 0))
    columns = slice(max(left, 0), max(min(left + data.shape[1], width), 0))
    if rows.start >= rows.stop or columns.start >= columns.stop:
        # Nothing of it is seen; the ends of what is cut out of the data would count from its far side.
        return canvas
    canvas[rows, columns] = data[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left]
    return canvas


def _to_rec709(colour: np.ndarray, header: dict) -> np.ndarray:
    """Convert from the primaries the header names; their white goes to the white of Rec.709."""
    named = header.get("chromaticities")
    if named is None:
        return colour
    try:
        chromaticities = np.asarray(named, np.float64).ravel()
        if chromaticities.shape != (8,) or is_rec709(chromaticities):
            return colour
        matrix = to_rec709(rgb_to_xyz(chromaticities))
    except (ValueError, TypeError):  # no numbers, or primaries in a line
        return colour
    return colour @ matrix.T.astype(np.float32) if np.isfinite(matrix).all() else colour


@contextlib.contextmanager
def _refusal_as_os_error() -> Iterator[None]:
    try:
        yield
    except (RuntimeError, OSError) as error:
        if getattr(error, "strerror", None) is not None:
            raise
        # The library's own words name the file that it was given; what is wrong with that comes last.
        raise OSError(str(error).strip().rstrip(".").rpartition(". ")[2]) from error
