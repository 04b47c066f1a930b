"""The paper's losses, Eqs. 1 to 8, over the pixels that are covered."""

from __future__ import annotations

from functools import lru_cache

import torch
import torch.nn.functional as F

from relight_core.dataset.samples import RELIEF_SIZE
from relight_core.lighting.reflection import ReflectionTable
from relight_core.lighting.relief import horizon_slopes
from relight_core.lighting.sphere import solid_angles
from relight_core.training.coarser import label_shares, shrunk, shrunk_within

_EDGE_WEIGHTS = (1.0, 0.7, 0.5)
"""Of steps 1, 2 and 4 pixels wide."""

_RELIEF_STEPS = ((1, 8.0), (4, 2.0), (16, 0.5))
"""Distances in pixels, and weights that make their errors count about alike."""


def masked_l1(estimate: torch.Tensor, truth: torch.Tensor, covered: torch.Tensor) -> torch.Tensor:
    """Mean absolute error over covered pixels (Eqs. 1, 2, 6, 8); 0, with gradients, when none is covered.

    Args:
        estimate, truth: (B, C, H, W).
        covered: (B, 1, H, W) weights in [0, 1].
    """
    return _mean_over((estimate - truth).abs(), covered)


def _mean_over(error: torch.Tensor, covered: torch.Tensor) -> torch.Tensor:
    return (error * covered).sum() / (covered.sum() * error.shape[1]).clamp_min(1.0)


def levelled_l1(estimate: torch.Tensor, truth: torch.Tensor, covered: torch.Tensor) -> torch.Tensor:
    """`masked_l1` after every channel of every estimate has been brought to the truth's level by one factor.

    The factor is that of least squares over the covered pixels. How light and of which colour all of a photo is, is
    as much the light's doing as the surface's, and that error drowns the one of shading left in part of it.
    """
    return masked_l1(estimate * _factor(estimate, truth, covered, (2, 3)), truth, covered)


def level_of(estimate: torch.Tensor, truth: torch.Tensor, covered: torch.Tensor) -> torch.Tensor:
    """The grey factor that brings an estimate to the truth's level, (B, 1, 1, 1), without a gradient."""
    return _factor(estimate.detach(), truth, covered, (1, 2, 3))


def _factor(estimate: torch.Tensor, truth: torch.Tensor, covered: torch.Tensor, over: tuple[int, ...]) -> torch.Tensor:
    """Of least squares over the covered pixels."""
    weighted = estimate * covered
    power = (weighted * estimate).sum(over, keepdim=True)
    return (weighted * truth).sum(over, keepdim=True) / power.clamp_min(1e-3)


def masked_l2(estimate: torch.Tensor, truth: torch.Tensor, covered: torch.Tensor) -> torch.Tensor:
    """Mean squared error over covered pixels; arguments, and what is true of none covered, as in `masked_l1`."""
    return _mean_over((estimate - truth).square(), covered)


def focal_parsing(logits: torch.Tensor, label: torch.Tensor, focus: float = 2.0) -> torch.Tensor:
    """Multi-class focal loss, mean over pixels (Eq. 4; Lin et al. 2017).

    Args:
        logits: (B, classes, H, W), which may be coarser: each then stands for all pixels of its square.
        label: (B, H, W) int64.
    """
    log_probability = F.log_softmax(logits.float(), 1)
    loss = -(1 - log_probability.exp()).clamp_min(0).pow(focus) * log_probability
    return (label_shares(label, logits.shape[1], logits.shape[2:]) * loss).sum(1).mean()


def wlog_l2(estimate: torch.Tensor, truth: torch.Tensor) -> torch.Tensor:
    """Weighted-log-L2 of lights (Eq. 3; Weber et al. 2018), mean over the batch.

    The squared norm is the mean over texels and colours of (w (log(1 + a) - log(1 + b)))^2, with w the
    solid angle over its mean, so that the value does not depend on the light's resolution.

    Args:
        estimate, truth: (B, H, 2H, 3) radiance >= 0.
    """
    weight = _relative_solid_angles(*truth.shape[1:3], truth.device)[None, :, :, None]
    difference = torch.log1p(estimate.float().clamp_min(0)) - torch.log1p(truth.float().clamp_min(0))
    return (weight * difference).square().mean()


@lru_cache
def _relative_solid_angles(height: int, width: int, device: torch.device) -> torch.Tensor:
    # Evaluation may ask first, in inference mode; no gradient could pass what is made there.
    with torch.inference_mode(False):
        weight = torch.from_numpy(solid_angles(height, width)).to(device)
        return weight / weight.mean()


def irradiance_l1(estimate: torch.Tensor, truth: torch.Tensor, table: ReflectionTable) -> torch.Tensor:
    """Mean absolute difference of log(1 + irradiance) over the table's normals; two in five of them face away.

    A texel of Eq. 3 says almost nothing about where a light comes from; what it does to a white ball does.

    Args:
        estimate, truth: (B, H, 2H, 3) radiance >= 0.
    """
    estimated, true = (torch.log1p(table.tabulate(light)[:, :3]) for light in (estimate, truth))
    return (estimated - true).abs().mean()


def slope_l1(estimate: torch.Tensor, truth: torch.Tensor, covered: torch.Tensor, step_px: int = 1) -> torch.Tensor:
    """L1 of the differences of pixels `step_px` apart, both covered: images matter by their edges."""
    total = estimate.new_zeros(())
    for axis in (2, 3):
        found, true, both = (_ends(image, axis, step_px) for image in (estimate, truth, covered))
        total = total + masked_l1(found[0] - found[1], true[0] - true[1], torch.minimum(both[0], both[1]))
    return total


def edges_l1(estimate: torch.Tensor, truth: torch.Tensor, covered: torch.Tensor) -> torch.Tensor:
    """`slope_l1` of the images and of their means over ever larger squares, wholly covered ones only.

    Pores and threads are noise that no photo tells; at full resolution alone their steps drown those of a nose.
    """
    total = estimate.new_zeros(())
    for weight in _EDGE_WEIGHTS:
        total = total + weight * slope_l1(estimate, truth, covered)
        estimate, truth = F.avg_pool2d(estimate, 2), F.avg_pool2d(truth, 2)
        covered = -F.max_pool2d(-covered, 2)
    return total


def _ends(image: torch.Tensor, axis: int, step_px: int) -> tuple[torch.Tensor, torch.Tensor]:
    count = image.shape[axis] - step_px
    return image.narrow(axis, step_px, count), image.narrow(axis, 0, count)


def relief_l1(estimate: torch.Tensor, truth: torch.Tensor, covered: torch.Tensor) -> torch.Tensor:
    """L1 of heights, and of height differences at several distances.

    What casts a shadow is a step of the surface, of a nose over its cheek or a jaw over the neck, and how far
    it reaches is the step's height. Absolute height says little of either, and is known least.
    """
    total = 0.3 * masked_l1(estimate, truth, covered)
    for step_px, weight in _RELIEF_STEPS:
        total = total + weight * slope_l1(estimate, truth, covered, step_px)
    return total


def horizon_l1(
    estimate: torch.Tensor, truth: torch.Tensor, covered: torch.Tensor, azimuth_rad: torch.Tensor
) -> torch.Tensor:
    """L1 of the sines of the horizons that reliefs raise: of the part of a level light's height that they hide.

    Heights that are right by the median come out flat, and flat noses cast no shadow; this asks for the shadow.

    Args:
        estimate, truth: (B, 1, H, W) heights, in half-widths of the image.
        covered: (B, 1, H, W) in [0, 1].
        azimuth_rad: (azimuths,) where light may come from.
    """
    reliefs = (shrunk_within(relief.float(), covered, RELIEF_SIZE)[:, 0] for relief in (estimate, truth))
    coarsely = shrunk(covered, RELIEF_SIZE)
    slopes = (horizon_slopes(relief, coarsely[:, 0], azimuth_rad) for relief in reliefs)
    found, true = (slope.atan().sin().transpose(0, 1) for slope in slopes)
    return masked_l1(found, true, (coarsely > 0.5).float())


def fraction_loss(logit: torch.Tensor, fraction: torch.Tensor, weight: torch.Tensor) -> torch.Tensor:
    """Cross-entropy of an occluded fraction, weighted by the light it takes; keeps sparse shadow alive.

    Args:
        logit, fraction, weight: (B, 1, H, W); weight is the unoccluded quantity, 0 outside the head.
    """
    entropy = F.binary_cross_entropy_with_logits(logit.float(), fraction, reduction="none")
    weight = weight.clamp_max(4.0)
    return (entropy * weight).sum() / weight.sum().clamp_min(1.0)
