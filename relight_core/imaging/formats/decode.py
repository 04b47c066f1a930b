"""Raster files to arrays: pixel values as stored, with what is needed to make light of them."""

from __future__ import annotations

import io
import struct
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image, ImageChops

from relight_core.errors import InputError
from relight_core.imaging.formats.camera_raw import develop_raw, is_raw
from relight_core.imaging.formats.deep_tiff import decode_deep_tiff, decode_flat_tiff, unread_tiff
from relight_core.imaging.formats.exif_block import ORIENTATION
from relight_core.imaging.formats.heif import decode_heif, is_heif, stated_profile
from relight_core.imaging.formats.icc import stated_transfer
from relight_core.imaging.formats.jpeg_scans import has_all_scans
from relight_core.imaging.formats.library_profiles import through_library_profile
from relight_core.imaging.formats.limits import check_pixels
from relight_core.imaging.formats.metadata import carried_exif, exif_of
from relight_core.imaging.formats.opencv_decoding import decoded_by_opencv, in_rgb_order
from relight_core.imaging.formats.png_colours import png_profile
from relight_core.imaging.formats.quiet_libraries import quiet
from relight_core.imaging.formats.raster import Raster, damaged
from relight_core.imaging.formats.stated_colours import exif_profile, refuse_luminous
from relight_core.imaging.formats.tiff_exif import exif_of_tiff
from relight_core.imaging.formats.tiff_pages import starting_with_photo

_FORMATS = ("JPEG", "PNG", "TIFF", "WEBP", "BMP", "GIF", "AVIF")
_TIFF_HEADS = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_GREYS = ("1", "L", "LA", "La")
_BY_LIBRARY = ("CMYK", "LAB")
_PNG, _PNG_PLAIN_GREY, _PNG_GREYS = b"\x89PNG\r\n\x1a\n", 0, (0, 4)
_PNG_SAMPLES = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
_MOST_DEFLATED = 1032
"""Bytes that one byte of deflated data can stand for at the most (zlib's technical notes)."""

_JPEG_END, _SOMETHING = b"\xff\xd9", b"\x55" * 64

_LARGE_PIXELS = 16_000_000
_MOST_PIXELS_A_BYTE = 4096
"""Pixels that one byte of a large photo can stand for: a lossy WebP's modes alone take a byte for 600 (RFC 6386)."""
_pillow_state = threading.Lock()
"""Of Pillow's limit and of Python's warnings, which are the whole process's."""


def decode_raster(data: bytes, path: Path) -> Raster:
    """Decode JPEG, PNG, TIFF, WebP, AVIF, HEIC, raw files and what else Pillow reads safely.

    Raises:
        InputError: not an image, damaged, too large or of an unsupported kind.
    """
    raster = _decoded(data, path)
    if raster.icc is not None:
        refuse_luminous(stated_transfer(raster.icc), path)
        if raster.profile is not None and raster.profile.is_flat:
            return replace(raster, icc=None)
    return raster


def _decoded(data: bytes, path: Path) -> Raster:
    if is_raw(data, path):
        return develop_raw(data, path)
    if is_heif(data):
        return decode_heif(data, path)
    if data.startswith(_TIFF_HEADS):
        return _decode_tiff(data, path)
    return _decode_by_pillow(data, path)


def _decode_tiff(data: bytes, path: Path) -> Raster:
    photo, orientation = starting_with_photo(data, path)
    raster = decode_deep_tiff(photo, path)
    if raster is None:
        try:
            raster = _decode_by_pillow(photo, path)
        except InputError:
            raster = decode_flat_tiff(photo, path)
            if raster is None:
                raise
    if photo is data:
        return raster
    # The file's first directory tells of the camera, whichever picture it holds.
    return replace(raster, exif=exif_of_tiff(data) or raster.exif, orientation=orientation or raster.orientation)


def _decode_by_pillow(data: bytes, path: Path) -> Raster:
    """What Pillow reads, and PNGs of 16 bits, which it opens."""
    image = _open_with_pillow(data, path)
    icc = _profile_of(image, data, path)
    if data.startswith(_PNG):
        if data[24] == 16:
            return replace(_decode_deep_png(data, image, icc, path), exif=carried_exif(image, data))
        _scale_key(image, bits=data[24])
    try:
        # As of TIFFs with more bits; whichever program wrote the file, and its dots per inch, is of no camera.
        exif = exif_of_tiff(data) if image.format == "TIFF" else carried_exif(image, data)
        return replace(_from_pillow(image, icc), exif=exif)
    except Exception:
        raise InputError(f"{path}: a damaged image; fetch or export it again") from None


def _open_with_pillow(data: bytes, path: Path) -> Image.Image:
    """The image fully decoded, so that a truncated file fails here."""
    with _without_warnings():
        limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
        try:
            image = Image.open(io.BytesIO(data), formats=_FORMATS)
            check_pixels(*image.size, path)
            _check_plausible(data, image, path)
            image = _loaded(image, data)
        except Image.UnidentifiedImageError:
            if _is_avif(data):
                raise damaged(path) from None
            if data.startswith(_TIFF_HEADS):
                raise unread_tiff(path) from None
            raise InputError(f"{path}: not an image; use a JPEG, PNG, TIFF, HEIC, WebP, EXR or HDR file") from None
        except InputError:
            raise
        except Exception:
            raise damaged(path) from None
        finally:
            Image.MAX_IMAGE_PIXELS = limit
    return image


@contextmanager
def _without_warnings() -> Iterator[None]:
    """Pillow tells of every odd tag, with a line of its own source."""
    with _pillow_state, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def _loaded(image: Image.Image, data: bytes) -> Image.Image:
    """An image with its pixels, also a JPEG of which nothing but the marker at its end is missing.

    Raises:
        OSError: more is missing.
    """
    try:
        # The library for packed TIFFs prints what it finds wrong.
        with quiet() if image.format == "TIFF" else nullcontext():
            image.load()
        return image
    except OSError:
        if image.format not in ("JPEG", "MPO") or not has_all_scans(data):
            raise
    picture = data.removesuffix(_JPEG_END[:1])
    ended = [Image.open(io.BytesIO(picture + tail + _JPEG_END), formats=("JPEG",)) for tail in (b"", _SOMETHING)]
    # Pixels that are missing are made of whatever follows.
    if not np.array_equal(*(np.asarray(one) for one in ended)):
        raise OSError
    return ended[0]


def _is_avif(data: bytes) -> bool:
    """Whether a file says that it is AVIF; of a cut one Pillow only says that it knows it not."""
    return data[4:8] == b"ftyp" and (b"avif" in data[8:64] or b"avis" in data[8:64])


def _check_plausible(data: bytes, image: Image.Image, path: Path) -> None:
    """Refuse a file that is too short for the pixels it claims, before memory is taken for them."""
    pixels = image.width * image.height
    if pixels > max(_LARGE_PIXELS, _MOST_PIXELS_A_BYTE * len(data)):
        claim = f"{image.width} x {image.height} pixels in {len(data)} bytes"
        raise damaged(path, f"image ({claim})")
    if image.format != "PNG" or len(data) < 26:
        return
    claimed = pixels * _PNG_SAMPLES.get(data[25], 1) * data[24] // 8
    if claimed > _MOST_DEFLATED * len(data):
        raise damaged(path)


def _profile_of(image: Image.Image, data: bytes, path: Path) -> bytes | None:
    """The profile that its values are in, embedded or stated in another way; None for sRGB."""
    embedded = image.info.get("icc_profile")
    # A TIFF may have anything under its number.
    embedded = embedded if isinstance(embedded, bytes) and embedded else None
    if image.format == "PNG":
        return png_profile(data, embedded, path)
    if embedded is not None or image.mode in _BY_LIBRARY:
        return embedded
    if image.format == "AVIF":
        return stated_profile(data, 1 if image.mode in _GREYS else 3, path)
    # Programs copy a camera's EXIF into files of other formats, whatever they make of its colours.
    if image.format in ("JPEG", "MPO", "TIFF"):
        return exif_profile(exif_of(image, data), 1 if image.mode in _GREYS else 3)
    return None


def _scale_key(image: Image.Image, bits: int) -> None:
    """Bring the grey that a PNG has transparent to 8 bits, as Pillow does with pixels of 2 and 4, but not with it."""
    key = image.info.get("transparency")
    if image.mode == "L" and isinstance(key, int):
        most = 2**bits - 1
        image.info["transparency"] = (key & most) * 255 // most


def _from_pillow(image: Image.Image, icc: bytes | None) -> Raster:
    orientation = _orientation(image)
    if image.format == "JPEG" and image.mode == "CMYK" and "adobe" not in image.info:
        # Only Adobe's programs store inks the other way round; Pillow takes every file for theirs.
        image = ImageChops.invert(image)
    if image.mode in _BY_LIBRARY:
        return Raster(through_library_profile(image, icc), None, None, orientation)
    alpha = None
    if image.has_transparency_data:
        # Grey stays grey: its profile, if it has one, is for one channel.
        image = image.convert("LA" if image.mode in _GREYS else "RGBA")
        alpha = np.asarray(image.getchannel("A"), np.float32) / 255.0
    is_grey = image.mode in _GREYS
    values = np.asarray(image.convert("L"))[..., None] if is_grey else np.asarray(image.convert("RGB"))
    return Raster(values, alpha, icc, orientation)


def _orientation(image: Image.Image) -> int:
    try:
        with _without_warnings():
            value = image.getexif().get(ORIENTATION, 1)
    except (ValueError, TypeError, OSError, SyntaxError, struct.error):
        return 1
    return value if value in range(1, 9) else 1


def _decode_deep_png(data: bytes, image: Image.Image, icc: bytes | None, path: Path) -> Raster:
    """A PNG of 16 bits per channel, which Pillow would cut to 8."""
    # OpenCV takes the memory that a chunk claims, up to 4 GiB, before it looks for its bytes.
    values = decoded_by_opencv(data) if _chunks_fit(data) else None
    if values is None or values.dtype != np.uint16:
        raise damaged(path)
    values, alpha = in_rgb_order(values), None
    if values.shape[2] == 4:
        colours = 1 if data[25] in _PNG_GREYS else 3
        alpha = values[..., 3].astype(np.float32) / np.float32(65535.0)
        values = np.ascontiguousarray(values[..., :colours])
    elif data[25] == _PNG_PLAIN_GREY and isinstance(key := image.info.get("transparency"), int):
        # OpenCV turns the key of a colour into alpha, and leaves that of a grey out.
        alpha = (values[..., 0] != key).astype(np.float32)
    return Raster(values, alpha, icc, _orientation(image))


def _chunks_fit(data: bytes) -> bool:
    """Whether every chunk of a PNG up to its end is as long as it says."""
    at = 8
    while at + 12 <= len(data):
        (length,) = struct.unpack_from(">I", data, at)
        if data[at + 4 : at + 8] == b"IEND":
            return True
        at += 12 + length
    return False
