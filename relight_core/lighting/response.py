"""Products of lights with light transport, fast for lights with few lit texels."""

from __future__ import annotations

import torch

_FEW = 8
"""Fewer lit texels than one in so many are few."""


def response_to(light: torch.Tensor, response: torch.Tensor) -> torch.Tensor:
    """The matrix product (C, N) of a light (C, texels) with the response to each texel (texels, N).

    Lamps cover a few of hundreds of texels. If a light has nothing else, only the rows of those are read.
    """
    lit = light.any(dim=0).nonzero()[:, 0]
    if len(lit) < len(response) // _FEW:
        return light[:, lit] @ response[lit]
    return light @ response
