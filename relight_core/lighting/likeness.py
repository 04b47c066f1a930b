"""Similarity of two lights: whether what one does to a face can be expected of the other."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import torch

from relight_core.lighting.sphere import directions, solid_angles

_LOBE = 4
"""Exponent of the cosine lobe that smooths both lights."""


def likeness(first: torch.Tensor, second: torch.Tensor) -> float:
    """The intersection of two lights over their union, [0, 1].

    Both are first brought to one level and smoothed by the lobe cos^4, half of which lies within 33 degrees, so that
    a small lamp that has been rotated a little is still similar to itself.

    Args:
        first, second: (1, H, 2H, 3), H even, linear radiance >= 0.

    Returns:
        1 for one light at two levels; 0 for lights that share neither direction nor colour, and for no light.
    """
    lobes, areas = _lobes(first.shape[1])
    one, other = (_spread(light, lobes, areas) for light in (first, second))
    either = float((torch.maximum(one, other) * areas).sum())
    return float((torch.minimum(one, other) * areas).sum()) / either if either > 0 else 0.0


def _spread(light: torch.Tensor, lobes: torch.Tensor, areas: torch.Tensor) -> torch.Tensor:
    """A light (1, H, 2H, 3), smoothed at some directions, (places, 3), over its mean on the sphere; 0 without light."""
    spread = lobes @ light[0].flatten(0, 1).cpu().float()
    mean = (spread * areas).sum() / (3 * areas.sum())
    return spread / mean.clamp_min(1e-12)


@lru_cache(maxsize=2)
def _lobes(height: int) -> tuple[torch.Tensor, torch.Tensor]:
    """Weights of the smoothing (places, texels), whose rows sum to 1, and the places' solid angles (places, 1).

    The places are a map of half the size, since the smoothed light has no finer detail.
    """
    toward, places = (directions(rows, 2 * rows).reshape(-1, 3) for rows in (height, height // 2))
    lobes = np.maximum(places @ toward.T, 0) ** _LOBE * solid_angles(height, 2 * height).ravel()
    areas = solid_angles(height // 2, height).reshape(-1, 1).copy()
    return torch.from_numpy(lobes / lobes.sum(1, keepdims=True)), torch.from_numpy(areas)
