"""What SS and composition share: an encoder-decoder whose way back up a light acts on (paper, section 4.2)."""

from __future__ import annotations

from typing import Protocol

import torch
from torch import nn

from relight_core.networks.blocks import Encoder, Head, decoder_levels, level_widths
from relight_core.networks.lfm import BottleneckLight, LightModulation, decode_lit, encode_light


class LitConfig(Protocol):
    """What decides its size, and where the light enters; see the networks' own configurations."""

    @property
    def width(self) -> int:
        """Channels at the finest level."""

    @property
    def levels(self) -> int:
        """Resolutions."""

    @property
    def inputs(self) -> int:
        """Input channels."""

    @property
    def modulated(self) -> bool:
        """Whether the light acts through LFM at every level; when false it enters at the bottleneck alone."""


class LitNetwork(nn.Module):
    """Encoder on what the surface is, decoder told of the light after every upsampling."""

    def __init__(self, config: LitConfig, outputs: int):
        super().__init__()
        self.config = config
        widths = level_widths(config.width, config.levels, widest=128)
        self.encoder = Encoder(config.inputs, widths)
        self.decoder = decoder_levels(widths)
        lit = widths[-2::-1] if config.modulated else []
        self.modulations = nn.ModuleList(LightModulation(width) for width in lit)
        self.bottleneck = None if config.modulated else BottleneckLight(widths[-1])
        self.head = Head(widths[0], outputs)

    def lit(self, features: list[torch.Tensor], light: torch.Tensor) -> torch.Tensor:
        """Outputs (B, outputs, H, W) of the encoder's features, finest first, under a light (B, 16, 32, 3)."""
        encoded_light = encode_light(light)
        return self.head(decode_lit(self.decoder, features, encoded_light, self.modulations, self.bottleneck))
