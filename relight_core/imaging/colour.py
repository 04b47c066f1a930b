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
    curve = _raised(np.maximum(linear, np.float32(0.0031308)), 1 / 2.4)
    curve *= np.float32(1.055)
    curve -= np.float32(0.055)
    # The foot lies below the curve up to where they meet, and above it from there on.
    return np.minimum(curve, linear * np.float32(12.92))


def _raised(values: np.ndarray, power: float) -> np.ndarray:
    """Positive numbers to a power, float32; OpenCV's is several times as quick as numpy's."""
    if not (values.ndim and values.size):
        return np.power(values, np.float32(power))
    import cv2  # commands that touch no picture know luminance and colours too, and start without it

    return cv2.pow(np.ascontiguousarray(values).reshape(1, -1), power).reshape(values.shape)


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
    return np.where(srgb <= 0.04045, srgb / np.float32(12.92), _raised(curve, 2.4))


def srgb_decode_integers(codes: np.ndarray) -> np.ndarray:
    """sRGB code values of 8 or 16 bits to linear light, by table.

    Args:
        codes: uint8 or uint16, any shape.

    Returns:
        float32 of the same shape, [0, 1].
    """
    table = _decode_table(codes.dtype.itemsize)
    if codes.dtype != np.uint8 or not (codes.ndim and codes.size):
        return table[codes]
    import cv2

    return cv2.LUT(np.ascontiguousarray(codes).reshape(len(codes), -1), table).reshape(codes.shape)


def luminance(rgb: np.ndarray) -> np.ndarray:
    """Rec.709 luminance of linear colours.

    Args:
        rgb: (..., 3) linear.

    Returns:
        (...) float32.
    """
    return np.asarray(rgb, np.float32) @ _LUMINANCE


def without_colour(rgb: np.ndarray) -> np.ndarray:
    """Linear colours (..., 3) as greys of their luminance, of the same shape."""
    return np.repeat(luminance(rgb)[..., None], 3, axis=-1)


@lru_cache(maxsize=2)
def _decode_table(bytes_per_code: int) -> np.ndarray:
    count = 256**bytes_per_code
    codes = np.arange(count) / (count - 1)
    table = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    table = table.astype(np.float32)
    table.setflags(write=False)
    return table
