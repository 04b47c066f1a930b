"""The person network: which pixels of a photo belong to the person whose face is marked.

The paper stops at the face's parsing; hair, hats, shoulders and everything beyond the crop are ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import nn

from relight_core.networks.blocks import Encoder, Head, decoder_levels, level_widths

_FOLD = 2
_PLANES = 3 + 1 + 1
"""Photo, where there is a photo, and the face."""


@dataclass(frozen=True)
class PersonConfig:
    """Size.

    Attributes:
        width: channels at half resolution, the finest that features have.
        levels: resolutions of the encoder-decoder.
        widest: channels that no level has more of.
    """

    width: int = 24
    levels: int = 6
    widest: int = 128


class PersonNetwork(nn.Module):
    """A U-Net (Ronneberger et al. 2015) over blocks of 2 x 2 pixels, at whose coarsest level a feature sees all."""

    def __init__(self, config: PersonConfig):
        super().__init__()
        self.config = config
        widths = level_widths(config.width, config.levels, widest=config.widest)
        self.encoder = Encoder(_PLANES * _FOLD**2, widths)
        self.decoder = decoder_levels(widths, least=config.width)
        self.overview = nn.Linear(widths[-1], widths[-1])
        self.head = Head(config.width, _FOLD**2)

    def forward(self, photo_srgb: torch.Tensor, inside: torch.Tensor, face: torch.Tensor) -> torch.Tensor:
        """Log odds of person.

        Args:
            photo_srgb: (B, 3, H, W) in [0, 1], of a `face.person_view`, 0 beyond the photo's borders; H and W
                multiples of 2 ** levels.
            inside: (B, 1, H, W) 1 where there is a photo.
            face: (B, 1, H, W) 1 in the square of the face that is meant.

        Returns:
            (B, 1, H, W) fp32.
        """
        planes = torch.cat([photo_srgb - 0.5 * inside, inside, face], 1)
        folded = F.pixel_unshuffle(planes, _FOLD).contiguous(memory_format=torch.channels_last)
        features = self.encoder(folded)
        x = features[-1]
        x = x + self.overview(x.mean((2, 3)).to(self.overview.weight.dtype))[:, :, None, None].to(x.dtype)
        for level, skip in zip(self.decoder, reversed(features[:-1]), strict=True):
            x = level(x, skip)
        return F.pixel_shuffle(self.head(x).float(), _FOLD)
