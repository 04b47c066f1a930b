"""sRGB encoding and luminance of tensors, with finite gradients at 0."""

from __future__ import annotations

import torch

from relight_core.imaging.colour import REC709_LUMINANCE
from relight_core.imaging.tensor_constants import constant

_LUMINANCE = tuple(REC709_LUMINANCE.tolist())
_BLACKEST = 1e-6


def srgb_encode(linear: torch.Tensor) -> torch.Tensor:
    """Linear [0, inf) of any shape to sRGB; values above 1 continue on the curve."""
    low = linear * 12.92
    high = 1.055 * linear.clamp_min(0.0031308).pow(1 / 2.4) - 0.055
    return torch.where(linear <= 0.0031308, low, high)


def srgb_decode(encoded: torch.Tensor) -> torch.Tensor:
    """sRGB to linear; negative values are taken as 0."""
    encoded = encoded.clamp_min(0)
    low = encoded / 12.92
    high = ((encoded.clamp_min(0.04045) + 0.055) / 1.055).pow(2.4)
    return torch.where(encoded <= 0.04045, low, high)


def grey(image: torch.Tensor) -> torch.Tensor:
    """Rec.709 luminance (B, 1, H, W) of linear (B, 3, H, W)."""
    return (image * luminance_weights(image)[None, :, None, None]).sum(1, keepdim=True)


def as_bright_as(image: torch.Tensor, other: torch.Tensor) -> torch.Tensor:
    """A linear image (B, 3, H, W) with its own colours and the luminance of another."""
    return image * (grey(other) / grey(image).clamp_min(_BLACKEST))


def luminance_weights(like: torch.Tensor) -> torch.Tensor:
    """Rec.709's share of each colour in luminance, (3,), of a tensor's type and on its device."""
    return constant(_LUMINANCE, like.device, like.dtype)
