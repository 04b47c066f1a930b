"""Colours that a file states in another way than by a profile it embeds."""

from __future__ import annotations

import struct
from dataclasses import replace
from pathlib import Path

from relight_core.errors import InputError
from relight_core.imaging.formats.exif_block import EXIF_IFD, INTEROPERABILITY_IFD, Directory, read_directory
from relight_core.imaging.formats.icc_making import (
    ADOBE_RGB,
    DISPLAY_P3,
    REC709,
    REC2020,
    grey_profile,
    primaries_profile,
)

KNOWN_PRIMARIES = {1: REC709, 9: REC2020, 12: DISPLAY_P3}
"""By their number in ITU-T H.273, table 2."""

_LUMINOUS_TRANSFERS: dict[int | None, str] = {16: "PQ", 18: "HLG"}
"""Transfer functions of high dynamic range (ITU-T H.273, table 3)."""

_GAMMAS = {4: 2.2, 5: 2.8, 8: 1.0}
"""Transfer functions that are powers, in the same table. Others are near the curve of sRGB."""

_COLOUR_SPACE, _INTEROPERABILITY_INDEX = 40961, 1
_SAYS_SRGB, _SAYS_ADOBE_RGB = 1, 2
_OPTION_FILE = b"R03"
"""What a camera's file in Adobe RGB calls itself (CIPA DC-009, DCF 2.0)."""


def numbered_profile(primaries: int, transfer: int, channels: int, path: Path) -> bytes | None:
    """The profile for what a file says of its colours by the numbers of ITU-T H.273; None for sRGB.

    Args:
        primaries: those that have no name here count as Rec.709's.
        channels: colour channels of the picture, 1 or 3.

    Raises:
        InputError: it is of high dynamic range.
    """
    refuse_luminous(transfer, path)
    space, gamma = KNOWN_PRIMARIES.get(primaries, REC709), _GAMMAS.get(transfer)
    if gamma is None and (space is REC709 or channels == 1):
        return None
    return grey_profile(gamma) if channels == 1 else primaries_profile(replace(space, gamma=gamma))


def refuse_luminous(transfer: int | None, path: Path) -> None:
    """Refuse a file of high dynamic range, by the number of its transfer function in ITU-T H.273.

    Raises:
        InputError: it is of high dynamic range.
    """
    luminous = _LUMINOUS_TRANSFERS.get(transfer)
    if luminous is not None:
        raise InputError(f"{path}: an HDR picture ({luminous}), which isn't read here; export it as SDR or as EXR")


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
