"""The person network: which pixels of a photo belong to the person whose face is marked.

The paper stops at the face's parsing; hair, hats, shoulders and everything beyond the crop are ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch

from relight_core.networks.folded_unet import FoldedUNet, FoldedUNetConfig

_PLANES = 3 + 1 + 1
"""Photo, where there is a photo, and the face."""


@dataclass(frozen=True)
class PersonConfig(FoldedUNetConfig):
    """Its size."""

    width: int = 24
    levels: int = 6
    widest: int = 128


class PersonNetwork(FoldedUNet):
    """Sees who is meant by the square of the face."""

    def __init__(self, config: PersonConfig):
        super().__init__(config, _PLANES, 1)

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
        return self.seen_in(torch.cat([photo_srgb - 0.5 * inside, inside, face], 1))
