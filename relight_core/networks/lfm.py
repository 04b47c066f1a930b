"""How a light enters a decoder: Lighting guided Feature Modulation (paper, section 4.2.2, Eq. 7, Figure 6),
or beside the features of the bottleneck, as the paper's baselines have it (sections 4.2.2 and 5.1.1)."""

from __future__ import annotations

import torch
from torch import nn

from relight_core.networks.blocks import ConvBlock

LIGHT_SHAPE = (16, 32, 3)
_LIGHT_FEATURES = 128


def encode_light(light: torch.Tensor) -> torch.Tensor:
    """Light (B, 16, 32, 3), normalised radiance, as a vector (B, 1536) of log(1 + radiance), in fp32."""
    return torch.log1p(light.float().clamp_min(0)).flatten(1)


class LightModulation(nn.Module):
    """F_out = gamma * F_in + beta, with gamma and beta from the light.

    FC1 turns the light into 128 features, followed by the only ReLU; FC2 and FC3 make gamma and beta of
    as many channels as the features have. It starts near the identity.
    """

    def __init__(self, channels: int):
        super().__init__()
        inputs = LIGHT_SHAPE[0] * LIGHT_SHAPE[1] * LIGHT_SHAPE[2]
        self.fc1 = nn.Linear(inputs, _LIGHT_FEATURES)
        self.fc2 = nn.Linear(_LIGHT_FEATURES, channels)
        self.fc3 = nn.Linear(_LIGHT_FEATURES, channels)
        for layer in (self.fc2, self.fc3):
            nn.init.normal_(layer.weight, std=0.02)
            nn.init.zeros_(layer.bias)
        nn.init.ones_(self.fc2.bias)

    def forward(self, features: torch.Tensor, encoded_light: torch.Tensor) -> torch.Tensor:
        """Modulate (B, C, H, W) by an encoded light (B, 1536)."""
        with torch.autocast(features.device.type, enabled=False):
            hidden = torch.relu(self.fc1(encoded_light.float()))
            gamma, beta = self.fc2(hidden), self.fc3(hidden)
        return _modulated(features, gamma.to(features.dtype), beta.to(features.dtype))


def _modulated(features: torch.Tensor, gamma: torch.Tensor, beta: torch.Tensor) -> torch.Tensor:
    """features * gamma + beta, gamma and beta (B, C)."""
    if not features.is_contiguous(memory_format=torch.channels_last):
        return features * gamma[..., None, None] + beta[..., None, None]
    # Pixel by pixel there would be only C numbers to a loop; whole rows of pixels take a quarter of the time.
    batch, channels, height, width = features.shape
    rows = features.permute(0, 2, 3, 1).reshape(batch, height, width * channels)
    rows = rows * gamma.repeat(1, width)[:, None] + beta.repeat(1, width)[:, None]
    return rows.view(batch, height, width, channels).permute(0, 3, 1, 2)


class BottleneckLight(nn.Module):
    """The light's 128 features at every place of the bottleneck, beside the image's own.

    What LFM replaces: Sun et al. 2019 and Zhou et al. 2019 tell a decoder of the light in this one place.
    """

    def __init__(self, channels: int):
        super().__init__()
        self.fc1 = nn.Linear(LIGHT_SHAPE[0] * LIGHT_SHAPE[1] * LIGHT_SHAPE[2], _LIGHT_FEATURES)
        self.blend = ConvBlock(channels + _LIGHT_FEATURES, channels)

    def forward(self, features: torch.Tensor, encoded_light: torch.Tensor) -> torch.Tensor:
        """Features (B, C, h, w) that know of an encoded light (B, 1536)."""
        with torch.autocast(features.device.type, enabled=False):
            hidden = torch.relu(self.fc1(encoded_light.float()))
        tiled = hidden.to(features.dtype)[..., None, None].expand(-1, -1, *features.shape[-2:])
        return self.blend(torch.cat([features, tiled], 1))


def decode_lit(
    decoder: nn.ModuleList,
    features: list[torch.Tensor],
    encoded_light: torch.Tensor,
    modulations: nn.ModuleList,
    bottleneck: BottleneckLight | None,
) -> torch.Tensor:
    """Go back up through a decoder that the light acts on.

    Args:
        decoder: of `blocks.UpLevel`, coarsest first.
        features: of `blocks.Encoder`, finest first.
        encoded_light: (B, 1536).
        modulations: one `LightModulation` for each level, or none.
        bottleneck: where the light enters without them.
    """
    x = features[-1] if bottleneck is None else bottleneck(features[-1], encoded_light)
    for index, (level, skip) in enumerate(zip(decoder, features[-2::-1], strict=True)):
        x = level.join(x, skip)
        x = level.refine(modulations[index](x, encoded_light) if modulations else x)
    return x
