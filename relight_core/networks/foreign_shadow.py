"""The foreign-shadow network: what light things that are no part of a person keep from them.

Shadows of hands, hats out of the picture, leaves and blinds are the paper's stated failure (section 5.4): a relit
portrait keeps them. That they come from outside ("foreign", Zhang et al. 2020, Portrait Shadow Manipulation) is seen
in their edges, which follow nothing of a face.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch

from relight_core.networks.folded_unet import FoldedUNet, FoldedUNetConfig

_PLANES = 3 + 4
"""The photo and the kinds of the parsing: dark hair is none of skin's shadows."""


@dataclass(frozen=True)
class ForeignShadowConfig(FoldedUNetConfig):
    """Its size."""

    width: int = 16
    levels: int = 5
    widest: int = 48


class ForeignShadowNetwork(FoldedUNet):
    """Sees the photo and what the parsing makes of it."""

    def __init__(self, config: ForeignShadowConfig):
        super().__init__(config, _PLANES, 3)

    def forward(self, photo_srgb: torch.Tensor, kinds: torch.Tensor) -> torch.Tensor:
        """Logs of what the light that arrives is of what would arrive without foreign shadows.

        Args:
            photo_srgb: (B, 3, H, W) in [0, 1], of the view that de-lighting sees; H and W multiples of 2 ** levels.
            kinds: (B, 4, H, W) probabilities of skin, of features, of hair and of what is worn.

        Returns:
            (B, 3, H, W) fp32, 0 where there is no such shadow and below it in one.
        """
        return self.seen_in(torch.cat([photo_srgb - 0.5, kinds], 1))
