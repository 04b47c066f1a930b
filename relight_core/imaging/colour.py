"""The sRGB transfer curve, its inverse and luminance, on float32 arrays."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

REC709_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""What linear red, green and blue of Rec.709 add to luminance (ITU-R BT.709). float64."""

_LUMINANCE = REC709_LUMINANCE.astype(np.float32)


def srgb_encode(linear: np.ndarray) -> np.ndarray:
    """Linear light to sRGB (IEC 61966-2-1). Not clipped; negatives follow the curve's straight foot.

    Args:
        linear: any shape, any real type.

    Returns:
        float32 of the same shape.
    """
    linear = np.asarray(linear, np.float32)
    curve = np.maximum(linear, np.float32(0.0031308))
    np.power(curve, np.float32(1 / 2.4), out=curve)
    curve *= np.float32(1.055)
    curve -= np.float32(0.055)
    return np.where(linear <= 0.0031308, linear * np.float32(12.92), curve)


def srgb_decode(srgb: np.ndarray) -> np.ndarray:
    """sRGB to linear light, the inverse of `srgb_encode`.

    Args:
        srgb: any shape, any real type, [0, 1] for displayable colours.

    Returns:
        float32 of the same shape.
    """
    srgb = np.asarray(srgb, np.float32)
    curve = np.maximum(srgb, np.float32(0.04045))
    curve += np.float32(0.055)
    curve /= np.float32(1.055)
    np.power(curve, np.float32(2.4), out=curve)
    return np.where(srgb <= 0.04045, srgb / np.float32(12.92), curve)


def srgb_decode_integers(codes: np.ndarray) -> np.ndarray:
    """sRGB code values of 8 or 16 bits to linear light, by table.

    Args:
        codes: uint8 or uint16, any shape.

    Returns:
        float32 of the same shape, [0, 1].
    """
    return _decode_table(codes.dtype.itemsize)[codes]


def luminance(rgb: np.ndarray) -> np.ndarray:
    """Rec.709 luminance of linear colours.

    Args:
        rgb: (..., 3) linear.

    Returns:
        (...) float32.
    """
    return np.asarray(rgb, np.float32) @ _LUMINANCE


@lru_cache(maxsize=2)
def _decode_table(bytes_per_code: int) -> np.ndarray:
    count = 256**bytes_per_code
    codes = np.arange(count) / (count - 1)
    table = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    table = table.astype(np.float32)
    table.setflags(write=False)
    return table
