"""What the foreign-shadow network learns from (see `dataset.gobo_photos`)."""

from __future__ import annotations

import torch
import torch.nn.functional as F

from relight_core.imaging.tensor_logs import without_mean
from relight_core.networks.foreign_shadow import ForeignShadowNetwork

_SCALES = 4


def foreign_shadow_losses(network: ForeignShadowNetwork, batch: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    """L1 of the logs' mean over the channels, of their colour, and of differences between neighbours at four scales.

    The last is that of Li and Snavely 2018 (MegaDepth): edges in their places, and evenness on both sides of them.
    """
    person, true = batch["person"], batch["foreign_shadow"]
    off = network(batch["photo_srgb"], batch["kinds"]) - true
    level = off.mean(1, keepdim=True)
    count = person.sum().clamp_min(1)
    slopes = torch.zeros_like(count)
    for _ in range(_SCALES):
        for axis in (-1, -2):
            both = torch.minimum(
                person.narrow(axis, 1, person.shape[axis] - 1), person.narrow(axis, 0, person.shape[axis] - 1)
            )
            slopes = slopes + (level.diff(dim=axis).abs() * both).sum() / both.sum().clamp_min(1)
        level, person = F.avg_pool2d(level, 2), F.avg_pool2d(person, 2).floor()
    person = batch["person"]
    mean = (off.mean(1, keepdim=True).abs() * person).sum() / count
    colour = (without_mean(off).abs() * person).sum() / (3 * count)
    return {"level": mean, "colour": colour, "slopes": 0.5 * slopes}
