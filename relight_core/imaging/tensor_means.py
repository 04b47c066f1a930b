"""Local means of image tensors."""

from __future__ import annotations

import torch
import torch.nn.functional as F

_REACH_SHARE = 0.03


def local_means(image: torch.Tensor, weight: torch.Tensor) -> torch.Tensor:
    """Means over (about) a tent that reaches 6 % of the image to each side: as far as a cheek.

    Args:
        image: (1, C, S, S).
        weight: (1, 1, S, S) >= 0, how much each pixel counts; where nothing nearby does, the mean goes to 0.
    """
    reach_px = max(round(_REACH_SHARE * image.shape[-1]), 1)

    def blur(values: torch.Tensor) -> torch.Tensor:
        for _ in range(2):
            values = F.avg_pool2d(values, 2 * reach_px + 1, 1, reach_px, count_include_pad=False)
        return values

    return blur(image * weight) / blur(weight).clamp_min(1e-3)


def with_neighbours(image: torch.Tensor, share: float) -> torch.Tensor:
    """An image (B, C, H, W) of whose pixels each gives a share to both its neighbours, along either axis.

    Beyond the border its edge goes on: what is even stays so, up to the rim.
    """
    padded = F.pad(image, (1, 1, 1, 1), mode="replicate").contiguous()
    own = 1 - 2 * share
    rows = own * padded[..., 1:-1, :] + share * (padded[..., :-2, :] + padded[..., 2:, :])
    return own * rows[..., 1:-1] + share * (rows[..., :-2] + rows[..., 2:])
