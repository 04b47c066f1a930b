"""TIFFs that Pillow would cut to 8 bits or refuse: of 16 or more bits per channel, or with unusual channels."""

from __future__ import annotations

import io
import logging
import math
import zlib
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import tifffile
from PIL import Image

from relight_core.errors import InputError
from relight_core.imaging.formats.library_profiles import through_library_profile
from relight_core.imaging.formats.limits import BYTES_PER_PIXEL, check_pixels
from relight_core.imaging.formats.opencv_decoding import decoded_by_opencv, in_rgb_order
from relight_core.imaging.formats.raster import Raster, at_full_scale, damaged
from relight_core.imaging.formats.stated_colours import exif_profile
from relight_core.imaging.formats.tiff_exif import exif_of_tiff
from relight_core.imaging.formats.tiff_pages import stated_orientation

# It tells of every odd tag; what can't be read is told by our own errors.
logging.getLogger("tifffile").setLevel(logging.CRITICAL)

_PROFILE = 34675
_WHITE_IS_0, _BLACK_IS_0, _RGB, _CMYK, _ICC_LAB = 0, 1, 2, 5, 9
_BY_LIBRARY = {_CMYK: "CMYK", _ICC_LAB: "LAB"}
_BY_PILLOW = (0, 1, 2, 3, 5, 6, 8)
_COLOURS = {_WHITE_IS_0: 1, _BLACK_IS_0: 1, _RGB: 3, _CMYK: 4, _ICC_LAB: 3}
_ALPHAS = _ASSOCIATED, _STRAIGHT = 1, 2
_IN_PLANES = 2
_NUMBERS = ("uint8", "uint16", "float16", "float32")
_PLAIN, _PACKBITS, _DEFLATE = 1, 32773, (8, 32946)


class _Kind(NamedTuple):
    """How a page stores its picture, by the numbers of TIFF 6.0."""

    bits: int
    photometric: int
    samples: int
    planes: int
    compression: int


def decode_deep_tiff(data: bytes, path: Path) -> Raster | None:
    """Decode the first picture; None where it has 8 bits or fewer, which Pillow reads, though signed ones wrongly.

    Raises:
        InputError: damaged, too large or of an unsupported kind.
    """
    page, kind = _described(data, path)
    if kind.bits <= 8:
        if page.dtype is not None and page.dtype.kind == "i":
            raise unread_tiff(path)
        return None
    raster = _decoded(page, kind, data)
    if raster is None:
        raise unread_tiff(path, kind.bits)
    return raster


def decode_flat_tiff(data: bytes, path: Path) -> Raster | None:
    """Decode the first picture where Pillow refuses it for its channels or colours and it has 8 bits.

    Returns:
        None where it is another, as one that is damaged.

    Raises:
        InputError: damaged, too large or of an unsupported kind.
    """
    page, kind = _described(data, path)
    raster = _decoded(page, kind, data) if kind.bits == 8 else None
    if raster is None and (_has_unusual_channels(page, kind) or kind.photometric not in _BY_PILLOW):
        raise unread_tiff(path, kind.bits)
    return raster


def unread_tiff(path: Path, bits: int | None = None) -> InputError:
    """The error for a TIFF that is whole and of a kind that nothing here reads."""
    depth = "" if bits is None else f", with {bits} bits"
    unread = f"a TIFF of a kind this program doesn't read{depth}"
    return InputError(f"{path}: {unread}; save it as 8- or 16-bit or 32-bit float RGB")


def _has_unusual_channels(page: tifffile.TiffPage, kind: _Kind) -> bool:
    """Whether Pillow refuses its channels, however they are packed."""
    extra = kind.samples - _COLOURS.get(kind.photometric, kind.samples)
    if extra <= 0:
        return False
    place, transparency = _transparency(page, extra)
    return place > 0 or (kind.planes == _IN_PLANES if transparency is None else kind.photometric == _CMYK)


def _described(data: bytes, path: Path) -> tuple[tifffile.TiffPage, _Kind]:
    """The first picture, whole and not too large."""
    try:
        page = tifffile.TiffFile(io.BytesIO(data)).pages[0]
        stored = page.bitspersample, page.photometric, page.samplesperpixel, page.planarconfig, page.compression
        kind = _Kind(*(int(number) for number in stored))
        end = max(np.add(page.dataoffsets, page.databytecounts))
        width, height = int(page.imagewidth), int(page.imagelength)
        is_whole = len(page.dataoffsets) >= math.prod(page.chunked) and end <= len(data)
    except Exception:
        raise damaged(path) from None
    # There may be thousands of channels beside the colours, and Deflate holds them in next to nothing.
    check_pixels(width, height, path, max(BYTES_PER_PIXEL, kind.samples * kind.bits // 8))
    # Pillow takes strips that are missing for black ones.
    if not is_whole:
        raise damaged(path)
    return page, kind


def _decoded(page: tifffile.TiffPage, kind: _Kind, data: bytes) -> Raster | None:
    by_opencv = _opencv_reads(page, kind)
    values = _by_opencv(data, kind.bits) if by_opencv else _by_tifffile(page, kind, data)
    if values is None:
        return None
    raster = _as_raster(values, page, kind.photometric)
    if raster.icc is None and values.dtype.kind == "u" and kind.photometric not in _BY_LIBRARY:
        raster = replace(raster, icc=exif_profile(data, raster.values.shape[2]))
    # OpenCV turns pictures upright by itself.
    orientation = 1 if by_opencv else stated_orientation(page) or 1
    return replace(raster, orientation=orientation, exif=exif_of_tiff(data))


def _opencv_reads(page: tifffile.TiffPage, kind: _Kind) -> bool:
    """It knows every compression, but takes pictures in planes for others, and those of two channels for none."""
    if page.dtype is None or page.dtype in (np.uint8, np.float16) or kind.planes == _IN_PLANES:
        return False
    return kind.photometric in (_BLACK_IS_0, _RGB) and kind.samples in (1, 3, 4)


def _by_opencv(data: bytes, bits: int) -> np.ndarray | None:
    """(H, W, channels) upright, or None."""
    values = decoded_by_opencv(data)
    if values is None or values.dtype not in (np.uint16, np.float32, np.float64):
        return None
    if values.dtype == np.uint16 and bits < 16:
        # OpenCV fills up fewer bits with zeros, which leaves white a little grey.
        values = at_full_scale(values >> (16 - bits), bits)
    return in_rgb_order(values.astype(np.float32) if values.dtype == np.float64 else values)


def _by_tifffile(page: tifffile.TiffPage, kind: _Kind, data: bytes) -> np.ndarray | None:
    """(H, W, channels), or None where it doesn't know the compression or the numbers."""
    colours = _COLOURS.get(kind.photometric)
    if page.dtype is None or kind.compression not in (_PLAIN, _PACKBITS, *_DEFLATE) or colours is None:
        return None
    if kind.photometric == _ICC_LAB and page.dtype.kind != "u":
        return None
    if kind.compression in _DEFLATE and not _inflates_as_it_should(page, data):
        return None
    try:
        values = page.asarray(maxworkers=1)
    except Exception:
        return None
    if values.ndim == 3 and kind.planes == _IN_PLANES:
        values = np.moveaxis(values, 0, -1)
    values = values[..., None] if values.ndim == 2 else values
    if values.ndim != 3 or values.shape[2] < colours or values.dtype.name not in _NUMBERS:
        return None
    return np.ascontiguousarray(values, values.dtype if values.dtype.kind == "u" else np.float32)


def _inflates_as_it_should(page: tifffile.TiffPage, data: bytes) -> bool:
    """Whether no strip or tile inflates to more than its pixels take: tifffile would make room for all of it."""
    most = math.prod(page.chunks) * page.dtype.itemsize
    for start, count in zip(page.dataoffsets, page.databytecounts, strict=True):
        try:
            if len(zlib.decompressobj().decompress(data[start : start + count], most + 1)) > most:
                return False
        except zlib.error:
            return False
    return True


def _as_raster(values: np.ndarray, page: tifffile.TiffPage, photometric: int) -> Raster:
    tag = page.tags.get(_PROFILE)
    icc = tag.value if tag is not None and isinstance(tag.value, bytes) else None
    colours, alpha, kind = _COLOURS[photometric], None, None
    white = np.iinfo(values.dtype).max if values.dtype.kind == "u" else 1
    if values.shape[2] > colours:
        place, kind = _transparency(page, values.shape[2] - colours)
        alpha = None if kind is None else values[..., colours + place].astype(np.float32) / np.float32(white)
    values = np.ascontiguousarray(values[..., :colours])
    if photometric == _WHITE_IS_0:
        values = white - values
    raster = Raster(values, alpha, icc, premultiplied=kind == _ASSOCIATED)
    return _through_library(raster, _BY_LIBRARY[photometric]) if photometric in _BY_LIBRARY else raster


def _transparency(page: tifffile.TiffPage, count: int) -> tuple[int, int | None]:
    """Which of so many channels beside the colours is the first of transparency, and its kind; None where none is."""
    if not page.extrasamples:
        # Programs that write transparency without saying so leave the whole tag out, as Pillow takes it for 8 bits.
        return 0, _STRAIGHT
    return next(((i, kind) for i, kind in enumerate(page.extrasamples[:count]) if kind in _ALPHAS), (0, None))


def _through_library(raster: Raster, mode: str) -> Raster:
    """CMYK or Lab to sRGB at 8 bits, with transparency out of the inks first: less ink is a lighter colour."""
    codes = raster.straight
    if codes.dtype == np.uint16:
        codes = (codes >> 8).astype(np.uint8)
    elif codes.dtype != np.uint8:
        codes = (np.clip(np.nan_to_num(codes), 0, 1) * 255).astype(np.uint8)
    # Merged and not read as one, for which Pillow would take the colours of Lab for signed ones.
    image = Image.merge(mode, [Image.fromarray(np.ascontiguousarray(band)) for band in np.moveaxis(codes, -1, 0)])
    return replace(raster, values=through_library_profile(image, raster.icc), icc=None, premultiplied=False)
