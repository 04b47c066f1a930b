"""What decoders hand over: pixel values as a file has them, with what is needed to make light of them, or an error."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from relight_core.errors import InputError
from relight_core.imaging.formats.icc import MatrixProfile, matrix_profile

RAW_SUFFIXES = (
    *(".cr2", ".cr3", ".crw", ".nef", ".nrw", ".arw", ".sr2", ".srf", ".dng", ".raf", ".orf", ".rw2", ".rwl"),
    *(".pef", ".srw", ".x3f", ".3fr", ".fff", ".iiq", ".mos", ".mef", ".erf", ".mrw", ".dcr", ".kdc", ".k25"),
)
"""Of cameras' raw files."""


@dataclass(frozen=True, eq=False)
class Raster:
    """A decoded file.

    Attributes:
        values: (H, W, 1 or 3) uint8 or uint16 encoded values, or float32 linear ones.
        alpha: (H, W) float32 in [0, 1], or None.
        icc: the embedded profile that `values` still are in, or None.
        orientation: EXIF orientation still to be applied, 1 to 8.
        premultiplied: whether `values` have alpha multiplied in.
        exif: see `Photo.exif`.
    """

    values: np.ndarray
    alpha: np.ndarray | None = None
    icc: bytes | None = None
    orientation: int = 1
    premultiplied: bool = False
    exif: bytes | None = None

    @cached_property
    def profile(self) -> MatrixProfile | None:
        """`icc`, if it is a matrix or grey profile that fits the values."""
        return None if self.icc is None else matrix_profile(self.icc, self.values.shape[2])

    @property
    def straight(self) -> np.ndarray:
        """`values` without alpha in them, of the same shape and type."""
        values = self.values
        if self.alpha is None or not self.premultiplied:
            return values
        divided = values / np.where(self.alpha > 0.0, self.alpha, 1.0)[..., None]
        if values.dtype.kind == "u":
            return np.clip(np.rint(divided), 0, np.iinfo(values.dtype).max).astype(values.dtype)
        return divided.astype(np.float32)


def at_full_scale(codes: np.ndarray, bits: int) -> np.ndarray:
    """Codes of 10, 12 or 14 bits as such of 16, white staying white; those of 8 as they are."""
    if codes.dtype == np.uint8:
        return codes
    most = min(2**bits, 65536) - 1
    table = np.rint(np.minimum(np.arange(65536) / most, 1.0) * 65535).astype(np.uint16)
    return table[codes]


def damaged(path: Path, what: str = "image") -> InputError:
    """The error that a decoder raises where a file is not whole."""
    return InputError(f"{path}: a truncated or damaged {what}; fetch or export it again")
