"""What the person network learns from (see `dataset.cutouts.outlines`)."""

from __future__ import annotations

import torch
import torch.nn.functional as F

from relight_core.networks.person import PersonNetwork

_EDGE_WEIGHT = 4.0
_EDGE_REACH_PX = 5


def outline_losses(network: PersonNetwork, batch: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    """Cross entropy over the photo, edges counting more, and the share of the person that was missed or made up.

    The second term is that of Sudre et al. 2017 (one minus Dice's overlap): small people count as much as large.
    """
    inside, person = batch["inside"], batch["person"]
    logits = network(batch["photo_srgb"], inside, batch["face"])
    with torch.no_grad():
        window = 2 * _EDGE_REACH_PX + 1
        mean = F.avg_pool2d(person, window, 1, _EDGE_REACH_PX, count_include_pad=False)
        weight = inside * (1 + _EDGE_WEIGHT * 4 * mean * (1 - mean))
    entropy = F.binary_cross_entropy_with_logits(logits, person, reduction="none")
    likely = torch.sigmoid(logits) * inside
    both = (likely * person).sum((1, 2, 3))
    overlap = (2 * both + 1) / ((likely + person).sum((1, 2, 3)) + 1)
    return {"outline": (entropy * weight).sum() / weight.sum(), "overlap": 0.5 * (1 - overlap).mean()}
