"""A U-Net over blocks of 2 x 2 pixels: what the networks beside the paper's three are."""

from __future__ import annotations

from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import nn

from relight_core.networks.blocks import Encoder, Head, decoder_levels, level_widths

_FOLD = 2


@dataclass(frozen=True)
class FoldedUNetConfig:
    """Size.

    Attributes:
        width: channels at half resolution, the finest that features have.
        levels: resolutions of the encoder-decoder.
        widest: channels that no level has more of.
    """

    width: int
    levels: int
    widest: int


class FoldedUNet(nn.Module):
    """An encoder-decoder (Ronneberger et al. 2015), at whose coarsest level a feature sees all."""

    def __init__(self, config: FoldedUNetConfig, planes: int, outputs: int):
        super().__init__()
        self.config = config
        widths = level_widths(config.width, config.levels, widest=config.widest)
        self.encoder = Encoder(planes * _FOLD**2, widths)
        self.decoder = decoder_levels(widths, least=config.width)
        self.overview = nn.Linear(widths[-1], widths[-1])
        self.head = Head(config.width, outputs * _FOLD**2)

    def seen_in(self, planes: torch.Tensor) -> torch.Tensor:
        """(B, outputs, H, W) fp32, of (B, planes, H, W); H and W multiples of 2 ** levels."""
        folded = F.pixel_unshuffle(planes, _FOLD).contiguous(memory_format=torch.channels_last)
        features = self.encoder(folded)
        x = features[-1]
        x = x + self.overview(x.mean((2, 3)).to(self.overview.weight.dtype))[:, :, None, None].to(x.dtype)
        for level, skip in zip(self.decoder, reversed(features[:-1]), strict=True):
            x = level(x, skip)
        return F.pixel_shuffle(self.head(x).float(), _FOLD)
