"""Linear light to the 8-bit codes of a transfer curve, by tables over the leading bits of floats.

A float's exponent and its first 13 bits of fraction say to a 150th of a code where a value in [0, 1] lies: the code
is the nearest but where two are all but equally near, and a photo's own codes come back.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from relight_core.imaging.colour import srgb_encode
from relight_core.imaging.formats.icc import MatrixProfile

_BITS_LEFT_OUT = 10
_HALF_A_STEP = 1 << (_BITS_LEFT_OUT - 1)
_DARKEST, _WHITE = (int(np.float32(value).view(np.int32)) >> _BITS_LEFT_OUT for value in (2.0**-20, 1.0))
"""Of every curve that occurs, 2^-20 is code 0."""


def codes_8_bit(linear: np.ndarray, profile: MatrixProfile | None) -> np.ndarray:
    """Codes of linear light in a display's primaries.

    Args:
        linear: (h, w, 3) float32, [0, 1].
        profile: whose curves; None for sRGB.

    Returns:
        (h, w, 3) uint8.
    """
    places = np.ascontiguousarray(linear, np.float32).view(np.int32) + np.int32(_HALF_A_STEP)
    places >>= _BITS_LEFT_OUT
    places -= np.int32(_DARKEST)
    if profile is None:
        return _srgb_table().take(places, mode="clip")
    tables = _profile_tables(profile)
    return np.stack([tables[i].take(places[..., i], mode="clip") for i in range(3)], axis=-1)


@lru_cache(maxsize=4)
def _profile_tables(profile: MatrixProfile) -> np.ndarray:
    """(3, n) uint8, the codes of a profile's curves."""
    return np.ascontiguousarray(_rounded(profile.encode(np.repeat(_values()[:, None], 3, axis=1)).T))


@lru_cache(maxsize=1)
def _srgb_table() -> np.ndarray:
    return _rounded(srgb_encode(_values()))


def _values() -> np.ndarray:
    values = (np.arange(_DARKEST, _WHITE + 1, dtype=np.int32) << _BITS_LEFT_OUT).view(np.float32)
    values[0] = 0.0
    return values


def _rounded(encoded: np.ndarray) -> np.ndarray:
    return np.rint(np.clip(encoded, 0.0, 1.0) * 255.0).astype(np.uint8)
