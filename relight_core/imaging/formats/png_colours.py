"""What a PNG says of its colours (PNG specification, third edition, 4.3 and 11.3.2)."""

from __future__ import annotations

import struct
from dataclasses import replace
from pathlib import Path

import numpy as np

from relight_core.imaging.formats.chromaticities import is_rec709
from relight_core.imaging.formats.icc import matrix_profile
from relight_core.imaging.formats.icc_making import REC709, grey_profile, measured_primaries, primaries_profile
from relight_core.imaging.formats.stated_colours import KNOWN_PRIMARIES, numbered_profile

_COLOUR_TYPE, _GREYS = 25, (0, 4)
_NUMBERS, _EMBEDDED, _SRGB, _GAMMA, _CHROMATICITIES = _CHUNKS = (b"cICP", b"iCCP", b"sRGB", b"gAMA", b"cHRM")
_UNIT = 100_000
_SRGB_GAMMA, _SAME_GAMMA = 45_455, 500
_GAMMAS = range(10_000, 1_000_001)
"""Exponents from 10 to 0.1; others are mistakes."""


def png_profile(data: bytes, embedded: bytes | None, path: Path) -> bytes | None:
    """The profile that a PNG's values are in: of several statements the one that counts before the others.

    Args:
        data: the file.
        embedded: the profile in it, unpacked.

    Returns:
        None for sRGB, or where it says nothing.

    Raises:
        InputError: it is of high dynamic range.
    """
    chunks, channels = _colour_chunks(data), 1 if data[_COLOUR_TYPE] in _GREYS else 3
    numbers = chunks.get(_NUMBERS, b"")
    if len(numbers) == 4:
        profile = numbered_profile(numbers[0], numbers[1], channels, path)
        if numbers[0] in KNOWN_PRIMARIES:
            return profile
    if embedded is not None or _EMBEDDED in chunks or _SRGB in chunks:
        return embedded
    return _measured_profile(chunks, channels)


def _colour_chunks(data: bytes) -> dict[bytes, bytes]:
    """What stands before the pixels, by the names of chunks."""
    found, at = {}, 8
    while at + 12 <= len(data):
        length, name = struct.unpack_from(">I4s", data, at)
        if name == b"IDAT":
            break
        if name in _CHUNKS:
            found.setdefault(name, data[at + 8 : at + 8 + length])
        at += 12 + length
    return found


def _measured_profile(chunks: dict[bytes, bytes], channels: int) -> bytes | None:
    gamma, chromaticities = _gamma(chunks.get(_GAMMA, b"")), _chromaticities(chunks.get(_CHROMATICITIES, b""))
    is_srgb_gamma = gamma is None or abs(gamma - _SRGB_GAMMA) <= _SAME_GAMMA
    exponent = None if gamma is None else _UNIT / gamma
    if channels == 1:
        return None if is_srgb_gamma else grey_profile(exponent)
    space = None if chromaticities is None else measured_primaries(chromaticities, exponent)
    profile = None if space is None else primaries_profile(space)
    if profile is not None and matrix_profile(profile, 3) is not None:
        return profile
    return None if is_srgb_gamma else primaries_profile(replace(REC709, gamma=exponent))


def _gamma(content: bytes) -> int | None:
    """The exponent of encoding, in units of 1 / 100,000."""
    value = struct.unpack(">I", content)[0] if len(content) == 4 else None
    return value if value in _GAMMAS else None


def _chromaticities(content: bytes) -> np.ndarray | None:
    """(8,) x and y of red, green, blue and white, where they are not those of sRGB."""
    if len(content) != 32:
        return None
    white_first = np.array(struct.unpack(">8I", content)) / _UNIT
    chromaticities = np.roll(white_first, -2)
    return None if is_rec709(chromaticities) else chromaticities
