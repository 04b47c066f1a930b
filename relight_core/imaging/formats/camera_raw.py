"""Cameras' raw files, developed through LibRaw where the `raw` extra is installed."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from relight_core.errors import InputError
from relight_core.imaging.formats.icc_making import DISPLAY_P3, primaries_profile
from relight_core.imaging.formats.limits import check_pixels
from relight_core.imaging.formats.raster import RAW_SUFFIXES, Raster
from relight_core.imaging.formats.tiff_exif import exif_of_tiff

RAW_HEADS = (b"FUJIFILMCCD-RAW", b"IIRO", b"FOVb")
_SRGB_GAMMA = (2.4, 12.92)
_CLIPPED_SHARE = 0.001
"""Of the pixels, what brightening may clip: raw files are exposed for their highlights."""


def is_raw(data: bytes, path: Path) -> bool:
    """Whether a file is a camera's raw one, by its name or its first bytes."""
    return path.suffix.lower() in RAW_SUFFIXES or data.startswith(RAW_HEADS)


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
