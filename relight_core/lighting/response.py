"""What a light makes of a response to its texels."""

from __future__ import annotations

import torch

_FEW = 8
"""Up to one in so many texels is few."""


def response_to(light: torch.Tensor, response: torch.Tensor) -> torch.Tensor:
    """The sum over all texels, (C, N), of light (C, texels) times response (texels, N).

    Lamps lie in a few texels of hundreds; of a light that has no other, only their rows are read.
    """
    lit = light.any(dim=0).nonzero()[:, 0]
    if len(lit) < len(response) // _FEW:
        return light[:, lit] @ response[lit]
    return light @ response
