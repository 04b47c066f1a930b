"""Images to files: PNG, JPEG and TIFF through the view transform, EXR as radiance. Whole or not at all."""

from __future__ import annotations

import io
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np
import tifffile
from PIL import Image, ImageCms

from relight_core.errors import InputError
from relight_core.imaging.colour import srgb_encode
from relight_core.imaging.display_codes import codes_8_bit
from relight_core.imaging.files import whole_file
from relight_core.imaging.formats import exr
from relight_core.imaging.formats.icc import MatrixProfile, matrix_profile
from relight_core.imaging.formats.png import chunk, write_png
from relight_core.imaging.formats.tiff_exif import with_exif
from relight_core.imaging.half_floats import LARGEST_HALF
from relight_core.imaging.in_order import WORKERS, in_order
from relight_core.imaging.view_transform import LARGEST_FLOAT, displayable, expose

_BITS = {".png": (8, 16), ".jpg": (8,), ".jpeg": (8,), ".tif": (8, 16), ".tiff": (8, 16), ".exr": (8, 16, 32)}
_STRIP_ROWS = 64
_OPAQUE = (".jpg", ".jpeg")
_LONGEST_JPEG_SIDE = 65500
"""Pixels, of every program with libjpeg; the format itself goes 35 further."""


@dataclass(frozen=True)
class FileStyle:
    """How a file is written beside its kind.

    Attributes:
        bits: per channel.
        quality: of a JPEG, 1 to 100.
        exposure_ev: stops.
        icc: an RGB matrix profile to convert to and to embed; None is sRGB. EXR stays linear Rec.709.
        exif: a block of EXIF for PNG, JPEG and TIFF, or None; see `metadata.carried_exif`.
        notes: short texts and numbers by name, for PNG text chunks and EXR headers; other formats leave them out.
    """

    bits: int = 8
    quality: int = 92
    exposure_ev: float = 0.0
    icc: bytes | None = None
    exif: bytes | None = None
    notes: dict[str, str | float] = field(default_factory=dict)


_PLAIN = FileStyle()

Bands = Iterable[tuple[slice, np.ndarray, np.ndarray | None]]
"""Rows, linear (h, W, 3) and alpha (h, W) or None, from the top down without gaps.

What is outside Rec.709 is kept by EXR and by profiles that hold it.
"""


def write_image(
    path: str | Path,
    linear: np.ndarray,
    alpha: np.ndarray | None = None,
    *,
    bits: int = 8,
    quality: int = 92,
    exposure_ev: float = 0.0,
    notes: dict[str, str | float] | None = None,
) -> None:
    """Write an image; the extension says how.

    .png and .tif (8 or 16 bits, straight alpha) and .jpg (8 bits, alpha flattened on white in linear
    light) go through the view transform. .exr (half floats, limited to 65504, or 32-bit ones with bits=32;
    alpha multiplied into the colour) keeps radiance, multiplied by the exposure.

    Args:
        path: .png, .jpg, .jpeg, .tif, .tiff or .exr; replaced if it exists.
        linear: (H, W, 3) linear Rec.709, [0, inf); what is negative, outside Rec.709, only EXR keeps.
        alpha: (H, W) in [0, 1], or None.
        bits: per channel.
        quality: of a JPEG, 1 to 100.
        exposure_ev: stops.
        notes: see `FileStyle`.

    Raises:
        InputError: unknown extension, bits the format can't hold, a side above a JPEG's 65500 pixels, or a
            place that can't be written.
        ValueError: arrays of the wrong shape.
    """
    linear, alpha = _checked(linear, alpha)
    style = FileStyle(bits, quality, exposure_ev, notes=notes or {})
    write_bands(path, linear.shape[:2], cut(linear, alpha), alpha is not None, style)


def cut(linear: np.ndarray, alpha: np.ndarray | None, rows: int = 64) -> Bands:
    """An image in bands of rows."""
    for top in range(0, linear.shape[0], rows):
        band = slice(top, min(top + rows, linear.shape[0]))
        yield band, linear[band], None if alpha is None else alpha[band]


def write_bands(
    path: str | Path, size: tuple[int, int], bands: Bands, has_alpha: bool, style: FileStyle = _PLAIN
) -> None:
    """Write an image that comes in bands of rows, as `write_image`; it is held only as the file's codes.

    Args:
        size: (height, width).
        has_alpha: whether the bands have alpha.

    Raises:
        InputError: as `write_image`, or a profile that pixels can't be converted to.
    """
    path = Path(path)
    suffix = check_output(path, style.bits)
    if suffix in _OPAQUE and max(size) > _LONGEST_JPEG_SIDE:
        too_long = f"{size[1]} x {size[0]} is above the {_LONGEST_JPEG_SIDE} pixels a side that a JPEG holds"
        raise InputError(f"{path}: {too_long}; name a .png or .tif file, or make the picture smaller")
    profile = None if suffix == ".exr" else _target_profile(style.icc)
    coded = in_order(partial(_coded, suffix=suffix, profile=profile, style=style), bands)
    channels = 4 if has_alpha and suffix not in _OPAQUE else 3
    if suffix == ".png":
        notes = _png_notes(style, profile)
        with whole_file(path) as beside, beside.open("wb") as file:
            write_png(file, size, channels, style.bits, (codes for _, codes in coded), notes)
        return
    if suffix == ".exr":
        names, kind = "RGBA"[:channels], _code_type(suffix, style.bits)
        with whole_file(path) as beside:
            exr.write_rows(beside, size, names, kind, (codes for _, codes in coded), _attributes(style.notes))
        return
    pixels = np.empty((*size, channels), _code_type(suffix, style.bits))
    for rows, codes in coded:
        pixels[rows] = codes
    icc = style.icc if profile is not None else None
    with whole_file(path) as beside:
        encoded = _jpeg(pixels, style.quality, icc, style.exif) if suffix in _OPAQUE else _tiff(pixels, icc, style.exif)
        beside.write_bytes(encoded)


def _coded(
    band: tuple[slice, np.ndarray, np.ndarray | None], suffix: str, profile: MatrixProfile | None, style: FileStyle
) -> tuple[slice, np.ndarray]:
    """A band as the file has it."""
    rows, linear, alpha = band
    linear, alpha = _checked(linear, alpha)
    if suffix == ".exr":
        most, kind = LARGEST_FLOAT if style.bits == 32 else LARGEST_HALF, _code_type(suffix, style.bits)
        exposed = expose(linear, style.exposure_ev, darkest=-most, brightest=most)
        return rows, exr.limited(_premultiplied(exposed, alpha), kind)
    if profile is None:
        shown = displayable(expose(linear, style.exposure_ev))
    else:
        # In the profile's own primaries, where what is outside Rec.709 may lie inside.
        shown = displayable(expose(profile.mix(linear), style.exposure_ev), profile.luminance)
    if suffix in _OPAQUE and alpha is not None:
        shown, alpha = shown * alpha[..., None] + (1.0 - alpha[..., None]), None
    if style.bits == 8:
        codes = codes_8_bit(shown, profile)
        return rows, codes if alpha is None else np.dstack([codes, _codes(alpha, 8)])
    encoded = srgb_encode(shown) if profile is None else profile.encode(shown)
    codes = _codes(np.clip(encoded, 0.0, 1.0, out=encoded), style.bits)
    return rows, codes if alpha is None else np.dstack([codes, _codes(alpha, style.bits)])


def _code_type(suffix: str, bits: int) -> type:
    if suffix == ".exr":
        return np.float32 if bits == 32 else np.float16
    return np.uint8 if bits == 8 else np.uint16


def _target_profile(icc: bytes | None) -> MatrixProfile | None:
    """The profile to convert to; None for sRGB."""
    if icc is None:
        return None
    profile = matrix_profile(icc, 3)
    if profile is None:
        raise InputError("the photo's colour profile can't be written back: it is no RGB matrix profile; write sRGB")
    return None if profile.is_srgb else profile


def check_output(path: str | Path, bits: int = 8) -> str:
    """Say early whether `write_image` knows how to write this.

    Returns:
        The extension in lower case.

    Raises:
        InputError: unknown extension, or bits the format can't hold.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in _BITS:
        wrong = f"can't write '{suffix}' files" if suffix else "the end of the name doesn't say which kind of file"
        raise InputError(f"{path}: {wrong}; name a .png, .jpg, .tif or .exr file")
    if bits not in _BITS[suffix]:
        choices = " or ".join(str(choice) for choice in _BITS[suffix])
        raise InputError(f"{path}: {suffix} holds {choices} bits per channel, not {bits}; change the bits")
    return suffix


def write_exr_layers(
    path: str | Path,
    layers: dict[str, np.ndarray],
    *,
    half: bool = True,
    header: dict[str, str | float | int] | None = None,
    step: Callable[[int, int], None] = lambda row, rows: None,
) -> None:
    """Write named layers into one EXR file, ZIP-compressed, band by band.

    "RGB" or "RGBA" becomes the channels R, G, B (, A), alpha being multiplied in by convention; a layer
    "albedo" of 3 or 4 channels becomes albedo.R, albedo.G, ...; one of 1 channel keeps its bare name.

    Args:
        path: ends in .exr; replaced if it exists.
        layers: (H, W) or (H, W, 1, 3 or 4), numbers of any type, all of one size.
        half: 16-bit floats, with values limited to +-65504 where they would become infinite; else 32-bit.
            NaN becomes 0 in both.
        header: attributes to add; numpy scalars are converted and None left out.
        step: told before each band how many rows are done, of how many; what it raises leaves no file.

    Raises:
        InputError: another extension, or a place that can't be written.
        ValueError: no layers, or layers of different sizes or odd shapes.
    """
    path = Path(path)
    if path.suffix.lower() != ".exr":
        raise InputError(f"{path}: layers need an EXR file; name a .exr file")
    kind = np.float16 if half else np.float32
    names = [channel for name, array in layers.items() for channel in _channel_names(name, np.shape(array))]
    sizes = {np.shape(array)[:2] for array in layers.values()}
    if len(sizes) != 1:
        raise ValueError("layers of one EXR have one size, and there is at least one")
    (size,) = sizes
    coded = in_order(partial(_coded_layers, list(layers.values()), kind), _strips(size[0], step))
    with whole_file(path) as beside:
        exr.write_rows(beside, size, names, kind, coded, _attributes(header or {}))


def _checked(linear: np.ndarray, alpha: np.ndarray | None) -> tuple[np.ndarray, np.ndarray | None]:
    linear = np.asarray(linear, np.float32)
    if linear.ndim != 3 or linear.shape[2] != 3 or 0 in linear.shape:
        raise ValueError(f"an image is (H, W, 3), not {linear.shape}")
    if alpha is None:
        return linear, None
    alpha = np.clip(np.nan_to_num(np.asarray(alpha, np.float32)), 0.0, 1.0)
    if alpha.shape != linear.shape[:2]:
        raise ValueError(f"alpha is {linear.shape[:2]}, not {alpha.shape}")
    return linear, alpha


def _premultiplied(linear: np.ndarray, alpha: np.ndarray | None) -> np.ndarray:
    return linear if alpha is None else np.dstack([linear * alpha[..., None], alpha])


def _codes(values: np.ndarray, bits: int) -> np.ndarray:
    kind = np.uint8 if bits == 8 else np.uint16
    rounded = values * np.float32(np.iinfo(kind).max)
    rounded += np.float32(0.5)
    return rounded.astype(kind)


def _srgb_profile() -> bytes:
    return ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()


def _jpeg(pixels: np.ndarray, quality: int, icc: bytes | None, exif: bytes | None) -> bytes:
    buffer = io.BytesIO()
    quality = min(max(int(quality), 1), 100)
    subsampling = 0 if quality >= 90 else 2
    Image.fromarray(pixels).save(
        buffer,
        "JPEG",
        quality=quality,
        subsampling=subsampling,
        icc_profile=icc or _srgb_profile(),
        exif=exif or b"",
    )
    return buffer.getvalue()


def _png_notes(style: FileStyle, profile: MatrixProfile | None) -> bytes:
    """The chunks that say what the pixels are and where they come from."""
    is_srgb = profile is None
    chunks = chunk(b"sRGB", b"\x00") if is_srgb else chunk(b"iCCP", b"icc\x00\x00" + zlib.compress(style.icc))
    if style.exif is not None:
        chunks += chunk(b"eXIf", style.exif.removeprefix(b"Exif\x00\x00"))
    for name, note in style.notes.items():
        # International text, uncompressed, of no named language.
        chunks += chunk(b"iTXt", name.encode("latin-1")[:79] + b"\x00" * 5 + str(note).encode("utf-8"))
    return chunks


def _tiff(pixels: np.ndarray, icc: bytes | None, exif: bytes | None) -> bytes:
    buffer = io.BytesIO()
    extra = ["unassalpha"] if pixels.shape[2] == 4 else None
    tifffile.imwrite(
        buffer,
        np.ascontiguousarray(pixels),
        photometric="rgb",
        extrasamples=extra,
        compression="zlib",
        compressionargs={"level": 1},
        # Differences to the pixel on the left: level 1 then makes smaller files than level 6 without.
        predictor=True,
        rowsperstrip=_STRIP_ROWS,
        maxworkers=WORKERS,
        iccprofile=icc or _srgb_profile(),
        metadata=None,
        software="relight",
        byteorder="<",
    )
    return with_exif(buffer.getvalue(), exif)


def _channel_names(layer: str, shape: tuple[int, ...]) -> list[str]:
    """What the channels of a layer are called in a file."""
    if len(shape) not in (2, 3) or (len(shape) == 3 and shape[2] not in (1, 3, 4)) or 0 in shape:
        raise ValueError(f"layer '{layer}' is (H, W) or (H, W, 1, 3 or 4), not {shape}")
    if len(shape) == 2 or shape[2] == 1:
        return [layer]
    letters = "RGBA"[: shape[2]]
    return list(letters) if layer in ("RGB", "RGBA") else [f"{layer}.{letter}" for letter in letters]


def _strips(height: int, step: Callable[[int, int], None]) -> Iterator[slice]:
    for top in range(0, height, _STRIP_ROWS):
        step(top, height)
        yield slice(top, min(top + _STRIP_ROWS, height))


def _coded_layers(layers: Sequence[np.ndarray], kind: type, rows: slice) -> np.ndarray:
    """Some rows of all layers as the file has them, channel beside channel."""
    band = np.dstack([np.asarray(layer[rows], np.float32) for layer in layers])
    return exr.limited(np.nan_to_num(band, copy=False, nan=0.0, posinf=np.inf, neginf=-np.inf), kind)


def _attributes(notes: dict[str, object]) -> dict[str, str | float | int]:
    """Notes as EXR's library takes them; of other types it drops some, and ends the process at others."""
    return {name: _attribute(value) for name, value in notes.items() if value is not None}


def _attribute(value: object) -> str | float | int:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return int(value)
    return value if isinstance(value, (str, int, float)) else str(value)
