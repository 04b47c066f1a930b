"""ICC profiles of spaces that files name without embedding one (ICC.1:2022): a matrix and a curve, or a curve."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from relight_core.imaging.formats.chromaticities import adaptation, rgb_to_xyz

_D50 = (0.9642, 1.0, 0.8249)
_SRGB_CURVE = (2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)
_D65_TO_D50 = (1.047882, 0.022919, -0.050217, 0.029587, 0.990479, -0.017059, -0.009232, 0.015076, 0.751678)
"""Bradford's adaptation, as the sRGB profiles of the ICC have it."""

_MOST_FIXED = 32768
"""What a number of a profile stays below."""


@dataclass(frozen=True)
class Primaries:
    """An RGB space.

    Attributes:
        name: for people.
        columns: X, Y, Z of red, green and blue, adapted to D50.
        gamma: the exponent of its curve; None for the curve of sRGB.
        adaptation: (9,) row by row, from its white to D50.
    """

    name: str
    columns: tuple[tuple[float, float, float], ...]
    gamma: float | None = None
    adaptation: tuple[float, ...] = _D65_TO_D50


REC709 = Primaries(
    "Rec. 709 primaries",
    ((0.436075, 0.222505, 0.013932), (0.385065, 0.716879, 0.097105), (0.143080, 0.060617, 0.714173)),
)
DISPLAY_P3 = Primaries(
    "Display P3", ((0.51512, 0.24120, -0.00105), (0.29198, 0.69225, 0.04189), (0.15710, 0.06657, 0.78407))
)
REC2020 = Primaries(
    "Rec. 2020 primaries", ((0.67345, 0.27903, -0.00193), (0.16565, 0.67535, 0.02998), (0.12510, 0.04562, 0.79685))
)
ADOBE_RGB = Primaries(
    "Adobe RGB (1998)",
    ((0.60974, 0.31111, 0.01947), (0.20528, 0.62567, 0.06087), (0.14919, 0.06322, 0.74457)),
    gamma=563 / 256,
)


def measured_primaries(chromaticities: np.ndarray, gamma: float | None) -> Primaries | None:
    """The space of (8,) x and y of red, green, blue and white; None where they are no colours."""
    try:
        with np.errstate(all="ignore"):
            own = rgb_to_xyz(chromaticities)
            to_d50 = adaptation(own.sum(axis=1), np.array(_D50))
            columns = (to_d50 @ own).T
    except np.linalg.LinAlgError:
        return None
    # What is not a number isn't less either.
    if not (np.abs([columns, to_d50]) < _MOST_FIXED).all():
        return None
    return Primaries("Measured primaries", tuple(map(tuple, columns)), gamma, tuple(to_d50.ravel()))


@lru_cache(maxsize=4)
def primaries_profile(primaries: Primaries) -> bytes:
    """A display profile of version 4."""
    curve, tags = _curve(primaries.gamma), {}
    for letter, column in zip("rgb", primaries.columns, strict=True):
        tags[f"{letter}XYZ".encode()] = _xyz(column)
        tags[f"{letter}TRC".encode()] = curve
    return _profile(b"RGB ", primaries.name, tags, primaries.adaptation)


def grey_profile(gamma: float) -> bytes:
    """A grey display profile of version 4 whose curve has that exponent."""
    return _profile(b"GRAY", "Grey", {b"kTRC": _curve(gamma)})


def _profile(space: bytes, name: str, colours: dict[bytes, bytes], adapted: tuple = _D65_TO_D50) -> bytes:
    tags = {
        b"desc": _text(name),
        b"cprt": _text("No copyright"),
        b"wtpt": _xyz(_D50),
        b"chad": b"sf32" + bytes(4) + _fixed(*adapted),
        **colours,
    }
    table, body = struct.pack(">I", len(tags)), b""
    start = 132 + 12 * len(tags)
    for name, content in tags.items():
        table += struct.pack(">4sII", name, start + len(body), len(content))
        body += content.ljust(-(-len(content) // 4) * 4, b"\0")
    return _header(space, start + len(body)) + table + body


def _header(space: bytes, size: int) -> bytes:
    head = struct.pack(">I4xI4s4s4s", size, 0x04300000, b"mntr", space, b"XYZ ")
    head += struct.pack(">6H", 2026, 1, 1, 0, 0, 0) + b"acsp"
    return head.ljust(68, b"\0") + _fixed(*_D50) + bytes(48)


def _curve(gamma: float | None) -> bytes:
    kind, numbers = (3, _SRGB_CURVE) if gamma is None else (0, (gamma,))
    return b"para" + bytes(4) + struct.pack(">HH", kind, 0) + _fixed(*numbers)


def _fixed(*numbers: float) -> bytes:
    return struct.pack(f">{len(numbers)}i", *(round(number * 65536) for number in numbers))


def _xyz(values: tuple[float, float, float]) -> bytes:
    return b"XYZ " + bytes(4) + _fixed(*values)


def _text(text: str) -> bytes:
    coded = text.encode("utf-16-be")
    return b"mluc" + bytes(4) + struct.pack(">II2s2sII", 1, 12, b"en", b"US", len(coded), 28) + coded
