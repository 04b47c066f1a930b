"""Normals as tensors."""

from __future__ import annotations

import torch

_SHORTEST = 1e-4


def unit_normals(normal: torch.Tensor) -> torch.Tensor:
    """Normals (B, 3, ...) at length 1; shorter ones than 1e-4 stay as short as that makes them.

    As `F.normalize` does, which takes sixty times as long on images whose channels are planes.
    """
    # Limited before the root, whose slope at nothing is infinite.
    return normal / normal.square().sum(1, keepdim=True).clamp_min(_SHORTEST**2).sqrt()
