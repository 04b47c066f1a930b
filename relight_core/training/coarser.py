"""Channels and labels at a coarser size."""

from __future__ import annotations

import torch
import torch.nn.functional as F

from relight_core.dataset.samples import ON_THE_HEAD
from relight_core.networks.lfm import LIGHT_SHAPE


def shrunk(value: torch.Tensor, size: int | None) -> torch.Tensor:
    """Images (B, C, S, S) by area to a side; a light (B, 16, 32, 3), or anything for None, stays as it is."""
    if size is None or value.shape[1:] == LIGHT_SHAPE or value.shape[-1] == size:
        return value
    return F.interpolate(value, size=size, mode="area")


def shrunk_within(value: torch.Tensor, covered: torch.Tensor, size: int | None) -> torch.Tensor:
    """Images (B, C, S, S) by area to a side, each pixel the mean of what is covered in it; 0 where nothing is.

    Args:
        covered: (B, 1, S, S) weights in [0, 1].
    """
    if size is None or value.shape[-1] == size:
        return value
    return shrunk(value * covered, size) / shrunk(covered, size).clamp_min(1e-6)


def shrunk_heads(images: dict[str, torch.Tensor], size: int | None) -> dict[str, torch.Tensor]:
    """A batch's images by area to a side: those of the head as `shrunk_within` its own "covered"; lights stay."""
    covered = images["covered"]
    return {
        name: shrunk_within(value, covered, size) if name in ON_THE_HEAD else shrunk(value, size)
        for name, value in images.items()
    }


def label_shares(label: torch.Tensor, classes: int, size: tuple[int, int]) -> torch.Tensor:
    """How much of every square belongs to every class, (B, classes, height, width), summing to 1 over the classes.

    Args:
        label: (B, H, W) int64 in [0, classes), H and W multiples of the size.
        size: height and width of the result.
    """
    height, width = size
    rows, columns = label.shape[1] // height, label.shape[2] // width
    squares = label.unflatten(2, (width, columns)).unflatten(1, (height, rows)).permute(0, 2, 4, 1, 3).flatten(1, 2)
    share = torch.full((), 1 / (rows * columns), device=label.device).expand(squares.shape)
    shares = torch.zeros(len(label), classes, height, width, device=label.device)
    return shares.scatter_add_(1, squares, share)
