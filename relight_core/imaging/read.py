"""Photos and radiance maps from files, into linear Rec.709."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from relight_core.errors import InputError
from relight_core.imaging.colour import srgb_decode_integers
from relight_core.imaging.files import file_bytes, file_head
from relight_core.imaging.formats import decode, exr
from relight_core.imaging.formats.camera_raw import RAW_HEADS
from relight_core.imaging.formats.icc import MatrixProfile
from relight_core.imaging.formats.library_profiles import convert_8_bit
from relight_core.imaging.formats.radiance import decode_radiance_hdr
from relight_core.imaging.half_floats import LARGEST_HALF
from relight_core.imaging.in_order import in_order
from relight_core.imaging.photo import Photo

_BLOCK_ROWS = 128
_NEGLIGIBLE = 1e-5
"""Rounding takes colours this far outside Rec.709."""

_PICTURE_HEADS = (
    *(b"\xff\xd8\xff", b"\x89PNG\r\n\x1a\n", b"BM", b"GIF87a", b"GIF89a"),
    *(b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"),
    *RAW_HEADS,
)
_BRIGHTEST = 1e16
"""Radiance of floating-point files is limited to this, which leaves room for sums, squares and the gains of lights."""


def read_photo(path: str | Path) -> Photo:
    """Read JPEG, PNG, TIFF, HEIC, AVIF, WebP, raw files, EXR or Radiance HDR, upright and in linear Rec.709.

    Integer files are sRGB unless they embed an ICC profile or state their colours in another way, from which they
    are converted: matrix and grey profiles in floating point at the file's own depth, with what lies outside
    Rec.709 in `Photo.beyond`; table-based ones (CMYK among them) at 8 bits through LittleCMS, clipped to sRGB.
    Floating-point TIFFs are linear unless they embed a matrix or grey profile. In floating-point files NaN becomes
    0 and infinity the largest finite value, none above 1e16; what is negative goes to `Photo.beyond`. Alpha
    multiplied into the colour is divided out.

    Raises:
        InputError: missing, a folder, empty, truncated, not an image, above 400 megapixels, unreadable, or without
            any finite value.
    """
    path = Path(path)
    head = file_head(path)
    if _is_radiance(head):
        linear, alpha = _decode_radiance(head, path)
        return _float_photo(linear, alpha, premultiplied=True, path=path)
    raster = decode.decode_raster(file_bytes(path), path)
    if raster.values.dtype.kind == "f":
        return _photo_of_floats(raster, path)
    linear, beyond, bits = _to_linear(raster)
    linear, alpha = _upright(linear, raster.orientation), raster.alpha
    if alpha is not None:
        alpha = np.clip(_upright(alpha, raster.orientation), 0.0, 1.0)
    if beyond is not None:
        beyond = _upright(beyond, raster.orientation)
    return Photo(linear, alpha, path, bits, _kept_profile(raster), raster.exif, beyond)


def read_radiance(path: str | Path) -> np.ndarray:
    """Read an .hdr or .exr file as it is stored: NaN, negative and infinite values are left in.

    Returns:
        (H, W, 3) float32 linear Rec.709.

    Raises:
        InputError: as `read_photo`, or not a radiance format.
    """
    path = Path(path)
    head = file_head(path)
    if not _is_radiance(head):
        raise InputError(f"{path}: not a radiance map; use an .hdr or .exr file")
    return _decode_radiance(head, path)[0]


def is_picture_head(head: bytes) -> bool:
    """Whether a file's first 32 bytes are those of a kind that `read_photo` reads whatever the file is called."""
    if _is_radiance(head) or head.startswith(_PICTURE_HEADS):
        return True
    return head[4:8] == b"ftyp" or (head[:4], head[8:12]) == (b"RIFF", b"WEBP")


def _is_radiance(head: bytes) -> bool:
    return head.startswith((exr.MAGIC, b"#?RADIANCE", b"#?RGBE"))


def _decode_radiance(head: bytes, path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    if head.startswith(exr.MAGIC):
        return exr.read_exr(path)
    return decode_radiance_hdr(file_bytes(path), path), None


def _kept_profile(raster: decode.Raster) -> bytes | None:
    """The profile, for writing it back, if it is an RGB matrix profile other than sRGB."""
    profile = raster.profile
    return None if profile is None or profile.matrix is None or profile.is_srgb else raster.icc


def _photo_of_floats(raster: decode.Raster, path: Path) -> Photo:
    """Values above 1 and below 0 stay, whatever profile they are in."""
    linear, premultiplied, alpha = raster.values, raster.premultiplied, raster.alpha
    if raster.profile is not None:
        linear, premultiplied = raster.profile.decode(_limited(_finite(raster.straight, path))), False
    alpha = None if alpha is None else _upright(alpha, raster.orientation)
    photo = _float_photo(_upright(linear, raster.orientation), alpha, premultiplied, path)
    return replace(photo, icc=_kept_profile(raster), exif=raster.exif)


def _float_photo(linear: np.ndarray, alpha: np.ndarray | None, premultiplied: bool, path: Path) -> Photo:
    if linear.shape[2] == 1:
        linear = np.repeat(linear, 3, axis=2)
    linear = _limited(_finite(linear, path))
    if alpha is not None:
        alpha = np.clip(np.nan_to_num(alpha.astype(np.float32)), 0.0, 1.0)
        if premultiplied:
            with np.errstate(over="ignore"):
                linear = _limited(linear / np.where(alpha > 0.0, alpha, 1.0)[..., None])
    linear, beyond = np.ascontiguousarray(linear, np.float32), None
    if linear.min() < -_NEGLIGIBLE:
        beyond = np.clip(linear, -LARGEST_HALF, 0.0).astype(np.float16)
    return Photo(np.maximum(linear, 0.0, out=linear), alpha, path, 32, beyond=beyond)


def _finite(linear: np.ndarray, path: Path) -> np.ndarray:
    finite = np.isfinite(linear)
    if not finite.any():
        raise InputError(f"{path}: none of its values is a finite number; export it again")
    brightest = float(linear.max(initial=0.0, where=finite))
    return np.nan_to_num(linear, nan=0.0, posinf=brightest, neginf=0.0)


def _limited(linear: np.ndarray) -> np.ndarray:
    """Changed in place and returned."""
    return np.clip(linear, -_BRIGHTEST, _BRIGHTEST, out=linear)


def _to_linear(raster: decode.Raster) -> tuple[np.ndarray, np.ndarray | None, int]:
    """Encoded integers to (H, W, 3) linear, what lies beyond Rec.709, and the bits that are left."""
    values, profile = raster.straight, raster.profile
    bits = 8 * values.dtype.itemsize
    if profile is not None and not profile.is_srgb:
        return *_from_profile(values, profile), bits
    if profile is None and raster.icc:
        codes = values if bits == 8 else (values >> 8).astype(np.uint8)
        converted = convert_8_bit(codes, raster.icc)
        if converted is not None:
            return srgb_decode_integers(converted), None, 8
    linear = srgb_decode_integers(values)
    return (np.repeat(linear, 3, axis=2) if linear.shape[2] == 1 else linear), None, bits


def _from_profile(values: np.ndarray, profile: MatrixProfile) -> tuple[np.ndarray, np.ndarray | None]:
    """(H, W, 1 or 3) integers, encoded, to (H, W, 3) linear within Rec.709, and what lies beyond it."""
    size = (*values.shape[:2], 3)
    linear, beyond = np.empty(size, np.float32), None

    def decode(top: int) -> tuple[slice, np.ndarray]:
        rows = slice(top, top + _BLOCK_ROWS)
        wide = profile.decode(values[rows])
        np.clip(wide, 0.0, 1.0, out=linear[rows])
        wide -= linear[rows]
        return rows, wide

    for rows, part in in_order(decode, range(0, len(values), _BLOCK_ROWS)):
        if max(part.max(), -part.min()) > _NEGLIGIBLE:
            beyond = np.zeros(size, np.float16) if beyond is None else beyond
            beyond[rows] = part
    return linear, beyond


def _upright(image: np.ndarray, orientation: int) -> np.ndarray:
    """Apply an EXIF orientation (1 to 8; JEITA CP-3451, 4.6.4) to rows and columns; C-contiguous."""
    if orientation >= 5:
        image = image.swapaxes(0, 1)
    flip_rows = orientation in (3, 4, 7, 8)
    flip_columns = orientation in (2, 3, 6, 7)
    image = image[:: -1 if flip_rows else 1, :: -1 if flip_columns else 1]
    return np.ascontiguousarray(image)
