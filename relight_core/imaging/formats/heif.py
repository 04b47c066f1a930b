"""HEIC and HEIF photos, as phones and some cameras write them, through libheif (decoding only)."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pi_heif

from relight_core.errors import InputError
from relight_core.imaging.formats.limits import check_pixels
from relight_core.imaging.formats.metadata import carried_block
from relight_core.imaging.formats.raster import Raster, at_full_scale, damaged
from relight_core.imaging.formats.stated_colours import numbered_profile

_BRANDS = (b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"mif1", b"msf1")


def is_heif(data: bytes) -> bool:
    """Whether a file says that it is HEIC or HEIF."""
    # Some AVIFs name themselves by the container alone, and themselves only among what they are compatible with.
    return data[4:8] == b"ftyp" and data[8:12] in _BRANDS and b"avif" not in data[16:64]


def decode_heif(data: bytes, path: Path) -> Raster:
    """Decode the main picture, upright, at its own depth.

    What the file says of turning and mirroring the decoder itself applies; EXIF's orientation only repeats it.

    Raises:
        InputError: damaged, too large, or of a kind that can't be read.
    """
    image = _opened(data, path)
    check_pixels(*image.size, path)
    try:
        # A copy: the library's own memory goes with its image.
        codes = np.array(image)
        codes = at_full_scale(codes.reshape(*codes.shape[:2], -1), int(image.info.get("bit_depth") or 8))
    except Exception:
        raise damaged(path, "HEIC") from None
    values, alpha = codes, None
    if image.has_alpha:
        values, alpha = codes[..., :-1], codes[..., -1].astype(np.float32) / np.iinfo(codes.dtype).max
    icc = image.info.get("icc_profile") or _stated_profile(image.info.get("nclx_profile"), values.shape[2], path)
    exif = carried_block(image.info.get("exif"))
    return Raster(np.ascontiguousarray(values), alpha, icc, 1, image.premultiplied_alpha, exif)


def stated_profile(data: bytes, channels: int, path: Path) -> bytes | None:
    """The profile for what an AVIF or HEIF says of its colours by number; None for sRGB or where it says nothing.

    Args:
        channels: of colour, 1 or 3.

    Raises:
        InputError: it is of high dynamic range.
    """
    try:
        info = _opened(data, path).info
    except InputError:
        return None
    return _stated_profile(info.get("nclx_profile"), channels, path)


def _opened(data: bytes, path: Path) -> pi_heif.HeifImage:
    """The main picture, not yet decoded."""
    if not _items_are_named(data):
        raise damaged(path, "HEIC")
    try:
        file = pi_heif.open_heif(data, convert_hdr_to_8bit=False, hdr_to_16bit=False)
        return file[file.primary_index]
    except Exception:
        raise damaged(path, "HEIC") from None


def _items_are_named(data: bytes) -> bool:
    """Whether kinds and names of all items are text, as pi_heif takes for granted: others would end the process.

    Items are boxes "infe" within the box "meta" (ISO/IEC 14496-12, 8.11.6): version, flags, number, protection,
    four letters of kind, names.
    """
    items = _top_box(data, b"meta")
    at = items.find(b"infe")
    while at >= 0:
        (size,) = struct.unpack_from(">I", items, at - 4) if at >= 4 else (0,)
        version = items[at + 4] if at + 4 < len(items) else 0
        try:
            items[at + (12 if version < 3 else 14) : at - 4 + size].decode("utf-8")
        except UnicodeDecodeError:
            return False
        at = items.find(b"infe", at + 4)
    return bool(items)


def _top_box(data: bytes, name: bytes) -> bytes:
    """The content of a box that lies in no other; nothing where there is none or sizes make no sense."""
    at = 0
    while at + 16 <= len(data):
        size, found = struct.unpack_from(">I4s", data, at)
        head = 8
        if size == 1:
            (size,), head = struct.unpack_from(">Q", data, at + 8), 16
        size = len(data) - at if size == 0 else size
        if size < head:
            break
        if found == name:
            return data[at + head : at + size]
        at += size
    return b""


def _stated_profile(nclx: dict | None, channels: int, path: Path) -> bytes | None:
    if not nclx:
        return None
    return numbered_profile(nclx["color_primaries"], nclx["transfer_characteristics"], channels, path)
