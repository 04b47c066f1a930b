"""The composition network (paper, section 4.2.3): the channels and the light in, the relit image out."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import nn

from relight_core.networks.lit import LitNetwork

_KNEE = 20.0


@dataclass(frozen=True)
class CompositionConfig:
    """Size and variant.

    Attributes:
        width, levels: as in DelightConfig.
        explicit_sum: correct albedo * irradiance - shadow + specular; when false, as in the paper, the
            image comes from the four channels and the light alone.
        effects: specular and shadow are inputs; without, it is the relighting half of the paper's baseline
            (Table 2, "DL-RL").
        modulated: the light acts through LFM; when false it enters at the bottleneck alone.
    """

    width: int = 12
    levels: int = 4
    explicit_sum: bool = True
    effects: bool = True
    modulated: bool = True

    @property
    def inputs(self) -> int:
        """Input channels: albedo, normal, specular, shadow, and the explicit sum."""
        return 3 + 3 + 2 * self.effects + 3 * self.explicit_sum


def encode_radiance(radiance: torch.Tensor) -> torch.Tensor:
    """An invertible curve from [0, inf) with 1 at 1 and no end: shadows keep precision, highlights exist."""
    return torch.log1p(_KNEE * radiance.clamp_min(0)) / math.log1p(_KNEE)


def decode_radiance(encoded: torch.Tensor) -> torch.Tensor:
    """Inverse of `encode_radiance`; the largest value it returns is about 60,000."""
    return torch.expm1((encoded * math.log1p(_KNEE)).clamp(0, 14.0)) / _KNEE


class CompositionNetwork(LitNetwork):
    """Encoder-decoder with LFM after every upsampling layer."""

    def __init__(self, config: CompositionConfig | None = None):
        super().__init__(config or CompositionConfig(), outputs=3)
        if self.config.explicit_sum:
            nn.init.zeros_(self.head.weight)
            nn.init.zeros_(self.head.bias)

    def forward(
        self,
        albedo: torch.Tensor,
        normal: torch.Tensor,
        specular: torch.Tensor,
        shadow: torch.Tensor,
        explicit: torch.Tensor,
        light: torch.Tensor,
    ) -> torch.Tensor:
        """Compose.

        Args:
            albedo: (B, 3, H, W) linear.
            normal: (B, 3, H, W) unit vectors.
            specular, shadow: (B, 1, H, W) >= 0, linear, in units of the normalised light; only read when
                configured.
            explicit: (B, 3, H, W) albedo * irradiance - shadow + specular; only read when configured.
            light: (B, 16, 32, 3) normalised radiance.

        Returns:
            (B, 3, H, W) linear radiance >= 0, fp32.
        """
        channels = [encode_radiance(albedo), normal]
        if self.config.effects:
            channels += [encode_radiance(specular), encode_radiance(shadow)]
        encoded_sum = encode_radiance(explicit.float())
        if self.config.explicit_sum:
            channels.append(encoded_sum)
        change = self.lit(self.encoder(torch.cat(channels, 1)), light)
        return decode_radiance(encoded_sum + change if self.config.explicit_sum else torch.relu(change))
