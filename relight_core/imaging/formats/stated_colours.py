"""Colours that a file states in another way than by a profile it embeds."""

from __future__ import annotations

import struct

from relight_core.imaging.formats.exif_block import EXIF_IFD, INTEROPERABILITY_IFD, Directory, read_directory
from relight_core.imaging.formats.icc_making import ADOBE_RGB, grey_profile, primaries_profile

_COLOUR_SPACE, _INTEROPERABILITY_INDEX = 40961, 1
_SAYS_SRGB, _SAYS_ADOBE_RGB = 1, 2
_OPTION_FILE = b"R03"
"""What a camera's file in Adobe RGB calls itself (CIPA DC-009, DCF 2.0)."""


def exif_profile(block: bytes | None, channels: int) -> bytes | None:
    """The profile of Adobe RGB (1998) where EXIF says that colours are in it, as cameras do that embed none.

    Args:
        block: EXIF, or a TIFF, whose directories are EXIF's.
        channels: colour channels of the picture, 1 or 3.

    Returns:
        None where it says nothing, sRGB or what has no name.
    """
    found = read_directory(block) if isinstance(block, bytes) else None
    settings = found.inner.get(EXIF_IFD) if found is not None else None
    if settings is None or not _says_adobe_rgb(settings):
        return None
    return grey_profile(ADOBE_RGB.gamma) if channels == 1 else primaries_profile(ADOBE_RGB)


def _says_adobe_rgb(settings: Directory) -> bool:
    entry = settings.entries.get(_COLOUR_SPACE)
    space = struct.unpack_from(settings.order + "H", entry.data)[0] if entry is not None and entry.kind == 3 else None
    marks = settings.inner.get(INTEROPERABILITY_IFD)
    index = marks.entries.get(_INTEROPERABILITY_INDEX) if marks is not None else None
    is_option_file = index is not None and bytes(index.data[:3]) == _OPTION_FILE
    return space == _SAYS_ADOBE_RGB or (is_option_file and space != _SAYS_SRGB)
