"""A shard's arrays as integers that compress well, and back: quantised, predicted from neighbours, reordered."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_DEEPEST = 7.9


@dataclass(frozen=True)
class Precision:
    """Quantisation: steps along a side of the octahedral map, along a side of the texture, per half-width of depth."""

    normal: int
    uv: int
    depth: int


VERSION_2 = Precision(4095, 8191, 4096)
VERSION_3 = Precision(2047, 4095, 2048)
"""Its normals are within 0.12 degrees."""


def code_normals(normal: np.ndarray, steps: int = VERSION_3.normal) -> np.ndarray:
    """Unit vectors (P, 3) to (P, 2) uint16 on the octahedral map."""
    flat = normal / np.maximum(np.abs(normal).sum(1, keepdims=True), 1e-12)
    folded = (1 - np.abs(flat[:, 1::-1])) * np.where(flat[:, :2] >= 0, 1, -1)
    sides = np.where(normal[:, 2:] < 0, folded, flat[:, :2])
    return np.round((sides + 1) / 2 * steps).astype(np.uint16)


def decode_normals(codes: np.ndarray, steps: int = VERSION_3.normal) -> np.ndarray:
    """Inverse of `code_normals`: (P, 3) float32."""
    sides = codes.astype(np.float32) / steps * 2 - 1
    height = 1 - np.abs(sides).sum(1, keepdims=True)
    unfolded = (1 - np.abs(sides[:, ::-1])) * np.where(sides >= 0, 1, -1)
    normal = np.concatenate([np.where(height < 0, unfolded, sides), height], 1).astype(np.float32)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def code_uv(uv: np.ndarray) -> np.ndarray:
    """Texture coordinates in [0, 1] to uint16."""
    return np.round(np.clip(uv, 0, 1) * VERSION_3.uv).astype(np.uint16)


def decode_uv(codes: np.ndarray, steps: int = VERSION_3.uv) -> np.ndarray:
    """Inverse of `code_uv`, float32."""
    return codes.astype(np.float32) / steps


def code_depth(depth: np.ndarray) -> np.ndarray:
    """Depth within 8 half-widths of 0 to uint16."""
    return np.round((np.clip(depth, -_DEEPEST, _DEEPEST) + 8) * VERSION_3.depth).astype(np.uint16)


def decode_depth(codes: np.ndarray, steps: int = VERSION_3.depth) -> np.ndarray:
    """Inverse of `code_depth`, float32."""
    return codes.astype(np.float32) / steps - 8


def prediction_residuals(codes: np.ndarray, covered: np.ndarray) -> np.ndarray:
    """Codes (P, C) uint16 of the covered pixels less their prediction: left + above - above left (Lorenzo's predictor).

    Where a surface is smooth, the residuals are near 0. They are zigzag-coded, so that small numbers of either sign
    have small codes.

    Returns:
        (2, C, S, S) uint8: the high bytes, then the low ones.
    """
    image = np.zeros((*covered.shape, codes.shape[1]), np.uint16)
    image[covered] = codes
    planes = np.moveaxis(image, -1, 0)
    for axis in (1, 2):
        planes = np.diff(planes, axis=axis, prepend=np.zeros_like(planes.take([0], axis)))
    residual = planes.astype(np.int16)
    return _in_bytes(((residual << 1) ^ (residual >> 15)).astype(np.uint16))


def from_residuals(planes: np.ndarray, covered: np.ndarray) -> np.ndarray:
    """Inverse of `prediction_residuals`: (P, C) uint16."""
    residual = _from_zigzag(planes)
    image = np.cumsum(np.cumsum(residual, axis=1, dtype=np.uint16), axis=2, dtype=np.uint16)
    return image[:, covered].T


def from_differences(planes: np.ndarray) -> np.ndarray:
    """Codes (P, ...) uint16 from zigzag-coded differences (2, P, ...) uint8 between consecutive pixels (version 2)."""
    return np.cumsum(_from_zigzag(planes), axis=0, dtype=np.uint16)


def _in_bytes(numbers: np.ndarray) -> np.ndarray:
    return np.stack([numbers >> 8, numbers & 255]).astype(np.uint8)


def _from_zigzag(planes: np.ndarray) -> np.ndarray:
    """Signed numbers, modulo 2**16 as uint16, from the bytes (2, ...) of their zigzag codes."""
    zigzag = planes[0].astype(np.uint16) << 8 | planes[1]
    return (zigzag >> 1) ^ (0 - (zigzag & 1)).astype(np.uint16)


def morton_order(covered: np.ndarray) -> np.ndarray:
    """The covered pixels in Morton order (Morton 1966), in which neighbours in both directions stay close.

    Returns:
        (P,) indices into the covered pixels in row order.
    """
    row, column = np.nonzero(covered)
    return np.argsort(_spread(column) | (_spread(row) << 1), kind="stable")


def _spread(numbers: np.ndarray) -> np.ndarray:
    """Numbers below 65,536 with a zero bit before each of their bits."""
    spread = numbers.astype(np.int64)
    for shift, mask in ((8, 0x00FF00FF), (4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555)):
        spread = (spread | (spread << shift)) & mask
    return spread


def reorder_bits(packed: np.ndarray, count: int, order: np.ndarray) -> np.ndarray:
    """Rows of packed bits (512, ceil(count / 8)) with their bits taken in another order."""
    return np.packbits(np.unpackbits(packed, axis=1, count=count)[:, order], axis=1)
