"""How a shard's arrays become integers that compress well, and back."""

from __future__ import annotations

import numpy as np

_OCTAHEDRAL_STEPS = 4095
_UV_STEPS = 8191
_DEPTH_STEPS = 4096  # per half-width of the crop


def code_normals(normal: np.ndarray) -> np.ndarray:
    """Unit vectors (P, 3) to (P, 2) uint16, off by less than 0.06 degrees (octahedral map, 12 bits a side)."""
    flat = normal / np.maximum(np.abs(normal).sum(1, keepdims=True), 1e-12)
    folded = (1 - np.abs(flat[:, 1::-1])) * np.where(flat[:, :2] >= 0, 1, -1)
    sides = np.where(normal[:, 2:] < 0, folded, flat[:, :2])
    return np.round((sides + 1) / 2 * _OCTAHEDRAL_STEPS).astype(np.uint16)


def decode_normals(codes: np.ndarray) -> np.ndarray:
    """Inverse of `code_normals`: (P, 3) float32."""
    sides = codes.astype(np.float32) / _OCTAHEDRAL_STEPS * 2 - 1
    height = 1 - np.abs(sides).sum(1, keepdims=True)
    unfolded = (1 - np.abs(sides[:, ::-1])) * np.where(sides >= 0, 1, -1)
    normal = np.concatenate([np.where(height < 0, unfolded, sides), height], 1).astype(np.float32)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def code_uv(uv: np.ndarray) -> np.ndarray:
    """Texture coordinates in [0, 1] to uint16: 1 / 8191 of the texture apart."""
    return np.round(np.clip(uv, 0, 1) * _UV_STEPS).astype(np.uint16)


def decode_uv(codes: np.ndarray) -> np.ndarray:
    """Inverse of `code_uv`, float32."""
    return codes.astype(np.float32) / _UV_STEPS


def code_depth(depth: np.ndarray) -> np.ndarray:
    """Depth within 8 half-widths of 0 to uint16: 1 / 4096 of a half-width apart."""
    return np.round((np.clip(depth, -7.9, 7.9) + 8) * _DEPTH_STEPS).astype(np.uint16)


def decode_depth(codes: np.ndarray) -> np.ndarray:
    """Inverse of `code_depth`, float32."""
    return codes.astype(np.float32) / _DEPTH_STEPS - 8


def differences(codes: np.ndarray) -> np.ndarray:
    """Each of (P, ...) uint16 less the one before, small numbers of either sign made small: (2, P, ...) uint8.

    High bytes come first, then low ones; neighbours on the surface are alike, so the former are mostly 0.
    """
    step = np.diff(codes, axis=0, prepend=np.zeros_like(codes[:1])).astype(np.int16)
    folded = ((step << 1) ^ (step >> 15)).astype(np.uint16)
    return np.stack([folded >> 8, folded & 255]).astype(np.uint8)


def summed(planes: np.ndarray) -> np.ndarray:
    """Inverse of `differences`."""
    folded = planes[0].astype(np.uint16) << 8 | planes[1]
    step = (folded >> 1) ^ (0 - (folded & 1)).astype(np.uint16)
    return np.cumsum(step, axis=0, dtype=np.uint16)


def blockwise(covered: np.ndarray) -> np.ndarray:
    """An order of the covered pixels in which neighbours in both directions stay close (Morton 1966).

    Returns:
        (P,) indices into the covered pixels in row order.
    """
    row, column = np.nonzero(covered)
    return np.argsort(_spread(column) | (_spread(row) << 1), kind="stable")


def _spread(numbers: np.ndarray) -> np.ndarray:
    """A zero before every bit of numbers below 65,536."""
    spread = numbers.astype(np.int64)
    for shift, mask in ((8, 0x00FF00FF), (4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555)):
        spread = (spread | (spread << shift)) & mask
    return spread


def reorder_bits(packed: np.ndarray, count: int, order: np.ndarray) -> np.ndarray:
    """Rows of packed bits (512, ceil(count / 8)) with their bits taken in another order."""
    return np.packbits(np.unpackbits(packed, axis=1, count=count)[:, order], axis=1)
