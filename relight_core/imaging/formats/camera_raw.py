"""Cameras' raw files, developed through LibRaw where the `raw` extra is installed."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from relight_core.errors import InputError
from relight_core.imaging.formats.heif import is_heif
from relight_core.imaging.formats.icc_making import DISPLAY_P3, primaries_profile
from relight_core.imaging.formats.limits import check_pixels
from relight_core.imaging.formats.raster import RAW_SUFFIXES, Raster
from relight_core.imaging.formats.tiff_exif import exif_of_tiff

_NEVER_RAW = (b"\xff\xd8\xff", b"\x89PNG\r\n\x1a\n", b"GIF87a", b"GIF89a")
RAW_HEADS = (b"FUJIFILMCCD-RAW", b"IIRO", b"FOVb")
_SRGB_GAMMA = (2.4, 12.92)
_CLIPPED_SHARE = 0.001
"""Of the pixels, what brightening may clip: raw files are exposed for their highlights."""


def is_raw(data: bytes, path: Path) -> bool:
    """Whether a file is a camera's raw one, by its first bytes or, as most begin like any TIFF, by its name."""
    if data.startswith(RAW_HEADS):
        return True
    is_other = data.startswith(_NEVER_RAW) or is_heif(data) or (data[:4], data[8:12]) == (b"RIFF", b"WEBP")
    return path.suffix.lower() in RAW_SUFFIXES and not is_other


def develop_raw(data: bytes, path: Path) -> Raster:
    """Develop a raw file: the camera's white balance, Display P3 with 16 bits, upright.

    Raises:
        InputError: LibRaw is not installed, or the file is damaged, too large or of a camera it doesn't know.
    """
    try:
        import rawpy
    except ImportError:
        raise InputError(
            f"{path}: a camera's raw file, for which this installation lacks LibRaw; install it with "
            "'pip install rawpy', or export a 16-bit TIFF from your raw converter"
        ) from None
    try:
        with rawpy.imread(io.BytesIO(data)) as raw:
            check_pixels(raw.sizes.raw_width, raw.sizes.raw_height, path)
            values = raw.postprocess(
                use_camera_wb=True,
                output_color=rawpy.ColorSpace.P3D65,
                gamma=_SRGB_GAMMA,
                output_bps=16,
                auto_bright_thr=_CLIPPED_SHARE,
            )
    except rawpy.LibRawError:
        raise InputError(
            f"{path}: a raw file that can't be developed here; export it as a 16-bit TIFF from your raw converter"
        ) from None
    # Most raw files are TIFFs inside.
    return Raster(np.ascontiguousarray(values), None, primaries_profile(DISPLAY_P3), 1, False, exif_of_tiff(data))
