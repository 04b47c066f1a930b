"""Logarithms of linear images, in which what is nearly black has next to no colour and no depth without end."""

from __future__ import annotations

import torch

BLACK = 0.005
"""Linear: 8-bit code 16. Far below it noise, lifted blacks and JPEG's chroma say more than the surface does."""

DARKEST = 0.001
"""Linear: what is darker counts as this where a logarithm is to be exact, as of skin, which is far brighter."""

LARGEST_LOG = 3.0
"""Of a photo over its model: where they differ by more, twenty times, the model knows nothing of what is there."""


def logs(image: torch.Tensor) -> torch.Tensor:
    """Natural logarithms of linear values >= 0, of any shape."""
    return (image + BLACK).log()


def exact_logs(image: torch.Tensor) -> torch.Tensor:
    """Natural logarithms of linear values >= 0, of any shape, from DARKEST on."""
    return image.clamp_min(DARKEST).log()


def log_ratios(image: torch.Tensor, other: torch.Tensor) -> torch.Tensor:
    """Natural logarithms of the ratios of linear values >= 0 to others of that shape; around 0 where both are black."""
    return ((image + BLACK) / (other + BLACK)).log()


def without_mean(logarithms: torch.Tensor) -> torch.Tensor:
    """Logarithms (B, C, H, W) less their mean over the channels: what is left when brightness is not asked for."""
    return logarithms - logarithms.mean(1, keepdim=True)
