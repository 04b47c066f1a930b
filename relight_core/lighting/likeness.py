"""How alike two lights are: whether what one does to a face can be expected of the other."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import torch

from relight_core.lighting.sphere import directions, solid_angles

_LOBE = 4


def likeness(first: torch.Tensor, second: torch.Tensor) -> float:
    """What two lights share of all that either of them sends, [0, 1].

    Both are smoothed by the lobe cos^4 first, half of which lies within 33 degrees, so that a small lamp that has been
    turned a little is still much like itself.

    Args:
        first, second: (1, H, 2H, 3), linear radiance >= 0; their level doesn't count.

    Returns:
        1 for one light at two levels; 0 for lights that share neither direction nor colour, and for no light.
    """
    lobes, areas = _lobes(first.shape[1])
    one, other = (_spread(light, lobes, areas) for light in (first, second))
    either = float((torch.maximum(one, other) * areas).sum())
    return float((torch.minimum(one, other) * areas).sum()) / either if either > 0 else 0.0


def _spread(light: torch.Tensor, lobes: torch.Tensor, areas: torch.Tensor) -> torch.Tensor:
    """(texels, 3) of mean 1, or of 0 without light."""
    texels = light[0].flatten(0, 1).cpu().float()
    total = float((texels * areas).sum()) / (3 * float(areas.sum()))
    return lobes @ (texels / total) if total > 0 else torch.zeros_like(texels)


@lru_cache(maxsize=2)
def _lobes(height: int) -> tuple[torch.Tensor, torch.Tensor]:
    """Smoothing (texels, texels), whose rows sum to 1, and the texels' solid angles (texels, 1)."""
    toward = directions(height, 2 * height).reshape(-1, 3)
    areas = solid_angles(height, 2 * height).reshape(-1, 1)
    lobes = np.maximum(toward @ toward.T, 0) ** _LOBE * areas.T
    return torch.from_numpy(lobes / lobes.sum(1, keepdims=True)), torch.from_numpy(areas.copy())
