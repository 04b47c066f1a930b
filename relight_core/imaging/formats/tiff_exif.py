"""EXIF in TIFF files: theirs as a block, and a block as theirs (TIFF 6.0; CIPA DC-008, 4.6)."""

from __future__ import annotations

import io
import struct

import tifffile
from PIL import ExifTags, Image

_TEXT_TAGS = (270, 271, 272, 306, 315, 33432)
"""Description, maker, model, time, author, copyright."""

_EXIF_IFD = 34665
_PLACEHOLDER = 34664
"""tifffile writes no directories of others; this keeps the place of one, in the order that tags must have."""

_SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 6: 1, 7: 1, 8: 2, 9: 4, 10: 8, 11: 4, 12: 8}
_CODES = {tag.name: tag.value for tag in ExifTags.Base}
_LEFT_OUT = ("MakerNote", "UserComment", "InteroperabilityTag")


def exif_of_page(page: tifffile.TiffPage) -> bytes | None:
    """What a TIFF page says of camera, time and author, as a block that starts with "Exif"; None if nothing."""
    exif = Image.Exif()
    try:
        for code in _TEXT_TAGS:
            if code in page.tags and str(page.tags[code].value).strip():
                exif[code] = str(page.tags[code].value)
        inner = page.tags[_EXIF_IFD].value if _EXIF_IFD in page.tags else {}
        found = {_CODES[name]: _plain(value) for name, value in inner.items() if name in _CODES}
        for name in _LEFT_OUT:
            found.pop(_CODES.get(name), None)
        if found:
            exif[_EXIF_IFD] = found
        return exif.tobytes() if len(exif) else None
    except Exception:
        return None


def tags_of_block(block: bytes | None) -> list[tuple]:
    """A block's texts as tifffile's extra tags, and a place for what else it holds; see `with_exif`."""
    if block is None:
        return []
    exif = Image.Exif()
    exif.load(block)
    texts = [(code, "s", 0, str(exif[code]), True) for code in _TEXT_TAGS if code in exif]
    return texts + ([(_PLACEHOLDER, "I", 1, 0, True)] if exif.get_ifd(_EXIF_IFD) else [])


def with_exif(tiff: bytes, block: bytes | None) -> bytes:
    """A little-endian TIFF that was written with `tags_of_block`, the block's camera settings added."""
    if block is None:
        return tiff
    with tifffile.TiffFile(io.BytesIO(tiff)) as file:
        tag = file.pages[0].tags.get(_PLACEHOLDER)
    if tag is None:
        return tiff
    exif = Image.Exif()
    exif.load(block)
    only_inner = Image.Exif()
    only_inner.endian = "<"
    only_inner[_EXIF_IFD] = exif.get_ifd(_EXIF_IFD)
    data = bytearray(only_inner.tobytes().removeprefix(b"Exif\0\0"))
    start = len(tiff) + len(tiff) % 2
    inner = _relocated(data, start)
    result = bytearray(tiff.ljust(start, b"\0")) + data
    struct.pack_into("<H", result, tag.offset, _EXIF_IFD)
    struct.pack_into("<I", result, tag.valueoffset, start + inner)
    return bytes(result)


def _relocated(data: bytearray, start: int) -> int:
    """Move a small TIFF's EXIF directory to begin at `start` of another file; where it lies in the data."""
    (main,) = struct.unpack_from("<I", data, 4)
    entries = struct.unpack_from("<H", data, main)[0]
    places = {struct.unpack_from("<H", data, main + 2 + 12 * i)[0]: main + 10 + 12 * i for i in range(entries)}
    (inner,) = struct.unpack_from("<I", data, places[_EXIF_IFD])
    for entry in range(struct.unpack_from("<H", data, inner)[0]):
        place = inner + 2 + 12 * entry
        _, kind, count = struct.unpack_from("<HHI", data, place)
        if _SIZES.get(kind, 1) * count > 4:
            (offset,) = struct.unpack_from("<I", data, place + 8)
            struct.pack_into("<I", data, place + 8, offset + start)
    return inner


def _plain(value: object) -> object:
    """A pair of whole numbers, as tifffile gives a fraction, as a number; the rest as it is."""
    if isinstance(value, tuple) and len(value) == 2 and all(isinstance(part, int) for part in value) and value[1]:
        return value[0] / value[1]
    return value
