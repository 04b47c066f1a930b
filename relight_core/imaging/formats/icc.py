"""Embedded ICC profiles of the matrix and grey kind, at full precision.

Such a profile is a curve per channel and a 3x3 matrix (ICC.1:2022, 8.3 and 8.5), which float arithmetic
carries out without the 8-bit rounding of an image library.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np

from relight_core.imaging.colour import REC709_LUMINANCE, srgb_decode

_REC709_TO_XYZ_D50 = np.array(
    [
        [0.4360747, 0.3850649, 0.1430804],
        [0.2225045, 0.7168786, 0.0606169],
        [0.0139322, 0.0971045, 0.7141733],
    ]
)
_CURVE_SAMPLES = 4096
_FLATTEST = 1e6
"""Condition of a matrix from which on no way leads back into the profile: its colours lie in a plane."""
_LEAST_CONTRAST = 0.01
"""Between the darkest and the brightest that a curve gives: with less nothing is left of a picture."""

_SAME = 0.003  # how far makers' rounded sRGB profiles lie from the standard


@dataclass(frozen=True, eq=False)
class MatrixProfile:
    """Encoded values to linear Rec.709.

    Attributes:
        curves: (1 or 3, 4096) linear value of evenly spaced encoded values in [0, 1].
        matrix: (3, 3) linear profile RGB to linear Rec.709, white to white; None for a grey profile.
    """

    curves: np.ndarray
    matrix: np.ndarray | None

    @property
    def is_srgb(self) -> bool:
        """Whether it is sRGB up to its maker's rounding."""
        standard = srgb_decode(np.linspace(0.0, 1.0, _CURVE_SAMPLES))
        same_curve = np.abs(self.curves - standard).max() < _SAME
        return bool(same_curve and (self.matrix is None or np.abs(self.matrix - np.eye(3)).max() < _SAME))

    @property
    def is_flat(self) -> bool:
        """Whether one of its curves gives the same whatever comes, as no real profile's does."""
        return bool(np.ptp(self.curves, axis=1).min() < _LEAST_CONTRAST)

    def decode(self, encoded: np.ndarray) -> np.ndarray:
        """(H, W, 1 or 3) integers or finite floats to (H, W, 3) float32 linear Rec.709.

        Colours that Rec.709 doesn't hold come out below 0 or above 1. Floats below 0 or above 1 are taken along the
        curves' tangents there, which is exact for the linear profiles that such files mostly have.
        """
        linear = np.stack([self._curve(encoded[..., i], i) for i in range(encoded.shape[-1])], axis=-1)
        if linear.shape[-1] == 1:
            linear = np.repeat(linear, 3, axis=-1)
        return linear if self.matrix is None else linear @ self.matrix.T.astype(np.float32)

    @property
    def luminance(self) -> np.ndarray:
        """(3,) what its linear red, green and blue add to luminance.

        Raises:
            ValueError: a grey profile.
        """
        return REC709_LUMINANCE @ self._colours()

    def mix(self, linear: np.ndarray) -> np.ndarray:
        """(..., 3) linear Rec.709, not clipped, in the profile's primaries.

        Raises:
            ValueError: a grey profile.
        """
        return linear @ np.linalg.inv(self._colours()).T.astype(np.float32)

    def encode(self, mixed: np.ndarray) -> np.ndarray:
        """(..., 3) linear in the profile's primaries, [0, 1], to its encoded values, float32 in [0, 1]."""
        positions = np.linspace(0.0, 1.0, _CURVE_SAMPLES)
        layers = [np.interp(mixed[..., i], self.curves[i], positions) for i in range(3)]
        return np.stack(layers, axis=-1).astype(np.float32)

    def _colours(self) -> np.ndarray:
        if self.matrix is None:
            raise ValueError("a grey profile holds no colour")
        return self.matrix

    def _curve(self, channel: np.ndarray, index: int) -> np.ndarray:
        positions = np.linspace(0.0, 1.0, _CURVE_SAMPLES)
        if channel.dtype.kind == "u":
            codes = np.linspace(0.0, 1.0, 256**channel.dtype.itemsize)
            return np.interp(codes, positions, self.curves[index]).astype(np.float32)[channel]
        curve = self.curves[index]
        below, above = np.minimum(channel, 0.0), np.maximum(channel - 1.0, 0.0)
        outside = (curve[1] - curve[0]) * below + (curve[-1] - curve[-2]) * above
        return (np.interp(channel, positions, curve) + (len(curve) - 1) * outside).astype(np.float32)


def matrix_profile(icc: bytes, channels: int) -> MatrixProfile | None:
    """The profile if it is a matrix or grey one that fits the image, else None.

    Args:
        icc: the profile's bytes.
        channels: colour channels of the image, 1 or 3.
    """
    try:
        # Damaged numbers may divide by zero; whoever reads a photo need not hear of it.
        with np.errstate(all="ignore"):
            return _profile_of_numbers(icc, channels)
    except (KeyError, struct.error, ValueError, IndexError, np.linalg.LinAlgError):
        return None


def _profile_of_numbers(icc: bytes, channels: int) -> MatrixProfile | None:
    space = icc[16:20]
    if icc[36:40] != b"acsp" or space != {1: b"GRAY", 3: b"RGB "}[channels]:
        return None
    tags = _tags(icc)
    if channels == 1:
        curve = _curve_samples(tags[b"kTRC"])
        return MatrixProfile((_of_lightness(curve) if icc[20:24] == b"Lab " else curve)[None], None)
    if b"A2B0" in tags and b"rXYZ" not in tags:
        return None
    columns = [_xyz(tags[name]) for name in (b"rXYZ", b"gXYZ", b"bXYZ")]
    matrix = np.linalg.solve(_REC709_TO_XYZ_D50, np.stack(columns, axis=1))
    matrix /= matrix.sum(axis=1, keepdims=True)
    if not np.isfinite(matrix).all() or np.linalg.cond(matrix) > _FLATTEST:
        return None
    curves = np.stack([_curve_samples(tags[name]) for name in (b"rTRC", b"gTRC", b"bTRC")])
    return MatrixProfile(curves, matrix)


def stated_transfer(icc: bytes) -> int | None:
    """The transfer function that a profile states by its number in ITU-T H.273 (ICC.1:2022, 9.2.17); mostly none."""
    try:
        tag = _tags(icc).get(b"cicp", b"") if icc[36:40] == b"acsp" else b""
    except struct.error:
        return None
    return tag[9] if len(tag) >= 12 and tag[:4] == b"cicp" else None


def _tags(icc: bytes) -> dict[bytes, bytes]:
    (count,) = struct.unpack_from(">I", icc, 128)
    tags = {}
    for index in range(min(count, 100)):
        name, offset, size = struct.unpack_from(">4sII", icc, 132 + 12 * index)
        tags[name] = icc[offset : offset + size]
    return tags


def _xyz(tag: bytes) -> np.ndarray:
    return np.array(struct.unpack_from(">3i", tag, 8)) / 65536.0


def _of_lightness(lightness: np.ndarray) -> np.ndarray:
    """Luminance from CIE's L* / 100, which the curve of a grey profile gives where that is connected through Lab."""
    return np.where(lightness > 0.08, ((lightness + 0.16) / 1.16) ** 3, lightness * (2700 / 24389))


def _curve_samples(tag: bytes) -> np.ndarray:
    """A 'curv' or 'para' tag sampled evenly over [0, 1] (ICC.1:2022, 10.6 and 10.18)."""
    positions = np.linspace(0.0, 1.0, _CURVE_SAMPLES)
    if tag[:4] == b"curv":
        (count,) = struct.unpack_from(">I", tag, 8)
        if count == 0:
            return positions
        values = np.array(struct.unpack_from(f">{count}H", tag, 12))
        if count == 1:
            return positions ** (values[0] / 256.0)
        return np.interp(positions, np.linspace(0.0, 1.0, count), values / 65535.0)
    if tag[:4] != b"para":
        raise ValueError("not a curve")
    (kind,) = struct.unpack_from(">H", tag, 8)
    numbers = np.array(struct.unpack_from(f">{(1, 3, 4, 5, 7)[kind]}i", tag, 12)) / 65536.0
    return _parametric(kind, numbers, positions)


def _parametric(kind: int, numbers: np.ndarray, x: np.ndarray) -> np.ndarray:
    g, a, b, c, d, e, f = np.concatenate([numbers, np.zeros(7 - len(numbers))])
    if kind == 0:
        a, b, c, d, e, f = 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
    elif kind == 1:
        c, d, e, f = 0.0, -b / a, 0.0, 0.0
    elif kind == 2:
        e, f, c, d = c, c, 0.0, -b / a
    curve = np.maximum(a * x + b, 0.0) ** g + e
    return np.clip(np.where(x >= d, curve, c * x + f), 0.0, 1.0)
