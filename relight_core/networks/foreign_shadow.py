"""The foreign-shadow network: what light things that are no part of a person keep from them.

Shadows of hands, hats out of the picture, leaves and blinds are the paper's stated failure (section 5.4): a relit
portrait keeps them. That they come from outside ("foreign", Zhang et al. 2020, Portrait Shadow Manipulation) is seen
in their edges, which follow nothing of a face.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import nn

from relight_core.networks.blocks import Encoder, Head, decoder_levels, level_widths

_FOLD = 2
_PLANES = 3 + 4
"""The photo and the kinds of the parsing: dark hair is none of skin's shadows."""


@dataclass(frozen=True)
class ForeignShadowConfig:
    """Size; attributes as of `networks.person.PersonConfig`."""

    width: int = 16
    levels: int = 5
    widest: int = 48


class ForeignShadowNetwork(nn.Module):
    """A U-Net (Ronneberger et al. 2015) over blocks of 2 x 2 pixels."""

    def __init__(self, config: ForeignShadowConfig):
        super().__init__()
        self.config = config
        widths = level_widths(config.width, config.levels, widest=config.widest)
        self.encoder = Encoder(_PLANES * _FOLD**2, widths)
        self.decoder = decoder_levels(widths, least=config.width)
        self.overview = nn.Linear(widths[-1], widths[-1])
        self.head = Head(config.width, 3 * _FOLD**2)

    def forward(self, photo_srgb: torch.Tensor, kinds: torch.Tensor) -> torch.Tensor:
        """Logs of what the light that arrives is of what would arrive without foreign shadows.

        Args:
            photo_srgb: (B, 3, H, W) in [0, 1], of the view that de-lighting sees; H and W multiples of 2 ** levels.
            kinds: (B, 4, H, W) probabilities of skin, of features, of hair and of what is worn.

        Returns:
            (B, 3, H, W) fp32, 0 where there is no such shadow and below it in one.
        """
        planes = torch.cat([photo_srgb - 0.5, kinds], 1)
        folded = F.pixel_unshuffle(planes, _FOLD).contiguous(memory_format=torch.channels_last)
        features = self.encoder(folded)
        x = features[-1]
        x = x + self.overview(x.mean((2, 3)).to(self.overview.weight.dtype))[:, :, None, None].to(x.dtype)
        for level, skip in zip(self.decoder, reversed(features[:-1]), strict=True):
            x = level(x, skip)
        return F.pixel_shuffle(self.head(x).float(), _FOLD)
