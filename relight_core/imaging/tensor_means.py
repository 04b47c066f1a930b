"""Local means and medians of image tensors."""

from __future__ import annotations

import torch
import torch.nn.functional as F

_CHEEK = 0.06


def local_means(image: torch.Tensor, weight: torch.Tensor, reach: float = _CHEEK) -> torch.Tensor:
    """Means over (about) a tent.

    Args:
        image: (B, C, S, S).
        weight: (B, 1, S, S) >= 0, how much each pixel counts; where nothing nearby does, the mean goes to 0.
        reach: of the tent to each side, as a share of the image's; as far as a cheek unless told.
    """
    reach_px = max(round(reach / 2 * image.shape[-1]), 1)

    def blur(values: torch.Tensor) -> torch.Tensor:
        for _ in range(2):
            values = F.avg_pool2d(values, 2 * reach_px + 1, 1, reach_px, count_include_pad=False)
        return values

    return blur(image * weight) / blur(weight).clamp_min(1e-3)


def local_medians(image: torch.Tensor, weight: torch.Tensor, reach: float) -> torch.Tensor:
    """Medians over squares. Where means are off along both sides of a step, these follow it.

    Args:
        image: (1, C, S, S).
        weight: (1, 1, S, S) in [0, 1]; what has none counts as the mean of what has, nearby.
        reach: of a square to each side, as a share of the image's.
    """
    filled = weight * image + (1 - weight) * local_means(image, weight, reach)
    reach_px = _square_px(image, reach)
    around = F.unfold(F.pad(filled, (reach_px,) * 4, mode="replicate").movedim(1, 0), 2 * reach_px + 1)
    return around.median(1).values.reshape(image.shape)


def local_range(image: torch.Tensor, reach: float) -> tuple[torch.Tensor, torch.Tensor]:
    """The least and the most of an image (1, C, S, S) over the squares of `local_medians`, of its shape each."""
    reach_px = _square_px(image, reach)
    length_px = 2 * reach_px + 1

    def highest(values: torch.Tensor) -> torch.Tensor:
        rows = F.max_pool2d(values, (1, length_px), 1, (0, reach_px))
        return F.max_pool2d(rows, (length_px, 1), 1, (reach_px, 0))

    return -highest(-image), highest(image)


def _square_px(image: torch.Tensor, reach: float) -> int:
    return max(round(reach * image.shape[-1]), 1)


def middle_values(image: torch.Tensor, where: torch.Tensor) -> torch.Tensor:
    """(1, C, 1, 1) the median of each channel of an image (1, C, S, S) over a part (S, S), bool, which isn't empty."""
    return image[0][:, where].median(1).values[None, :, None, None]


def with_neighbours(image: torch.Tensor, share: float) -> torch.Tensor:
    """An image (B, C, H, W) of whose pixels each gives a share to both its neighbours, along either axis.

    Beyond the border its edge goes on: what is even stays so, up to the rim.
    """
    padded = F.pad(image, (1, 1, 1, 1), mode="replicate").contiguous()
    own = 1 - 2 * share
    rows = own * padded[..., 1:-1, :] + share * (padded[..., :-2, :] + padded[..., 2:, :])
    return own * rows[..., 1:-1] + share * (rows[..., :-2] + rows[..., 2:])
