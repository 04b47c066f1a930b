"""Colours of what is blown out in the photo, where the networks only guess, with colour noise.

Blown-out skin gets the colour of the skin around it, and blown-out lips that of the rest of the lips. Anything else,
such as a cap, a collar or a wall, is white.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F

from relight_core.face.parsing import BROWS, INDEX, share_of, skin_share
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_colour import grey

_FROM, _TO = 0.9, 0.99
"""Ramp of a channel's linear value over which it becomes clipped."""
_LITTLE = 1e-4
"""Weight of pixels that only count if there are no better ones. Its powers are for those that only count if even these
are missing."""
_BRIGHTER = 1.4
"""Blown-out skin is at most so many times as bright as the skin around it."""
_ENOUGH = 0.02
"""From this mean weight on, an area is filled with its own mean instead of that of wider surroundings."""
_SKIN_FOR_LIPS = 0.02
"""Weight of skin's colour relative to that of lips, for lips that are blown out altogether."""


def clipped_share(photo: torch.Tensor) -> torch.Tensor:
    """The degree to which each channel of a photo (1, 3, S, S), linear, is clipped, [0, 1]."""
    return ramp(photo, _FROM, _TO)


def flesh_share(parsing: torch.Tensor) -> torch.Tensor:
    """The probability of what isn't white when it is blown out: skin, lips, and brows, between whose hairs is skin."""
    return (skin_share(parsing) + share_of(parsing, (*BROWS, "lips"))).clamp(0, 1)


def mend_blown(clipped: torch.Tensor, albedo: torch.Tensor, parsing: torch.Tensor) -> torch.Tensor:
    """The albedo with plausible colours where the photo is blown out.

    Two clipped channels count as blown out, one as half. A single clipped channel is raised until it has, with the
    other two, the colour of the skin around. That is mostly red, which is clipped first, so that skin turns yellow.

    Args:
        clipped: (1, 3, S, S) in [0, 1], see `clipped_share`.
        albedo: (1, 3, S, S) linear.
        parsing: (1, classes, S, S) probabilities.
    """
    blown = (1.5 * clipped.mean(1, keepdim=True)).clamp(0, 1)
    if not bool((blown > 0).any()):
        return albedo
    skin = flesh_share(parsing)
    known = (1 - clipped.amax(1, keepdim=True)).square() + _LITTLE * (1 - blown) + _LITTLE**2
    around = _colour_around(albedo, parsing, known)
    level = (albedo / around * (1 - clipped)).sum(1, keepdim=True) / (1 - clipped).sum(1, keepdim=True).clamp_min(1e-3)
    lifted = torch.maximum(albedo, (around * level).clamp_max(1))
    bare = albedo + clipped * (lifted - albedo)
    seen = fill_in(level.clamp_max(_BRIGHTER), skin * (1 - blown) + _LITTLE**2)
    bare = bare + blown * ((around * seen).clamp_max(1) - bare)
    white = albedo + blown * (grey(albedo) - albedo)
    return skin * bare + (1 - skin) * white


def _colour_around(albedo: torch.Tensor, parsing: torch.Tensor, known: torch.Tensor) -> torch.Tensor:
    """The albedo of known skin continued everywhere, and on lips that of known lips, (1, 3, S, S)."""
    skin, lips = skin_share(parsing).square() * known, parsing[:, INDEX["lips"], None]
    around = fill_in(albedo, skin + _LITTLE**3)
    if bool((lips > 0.5).any()):
        of_lips = fill_in(albedo, lips.square() * known + _SKIN_FOR_LIPS * skin + _LITTLE**3)
        around = around + lips * (of_lips - around)
    return around.clamp_min(1e-3)


def at_least(log_ratio: torch.Tensor, clipped: torch.Tensor, skin: torch.Tensor) -> torch.Tensor:
    """The log ratio of a photo over its model, raised where clipped channels were brighter than the photo shows.

    A clipped channel gets the ratio of the channels that are not clipped, if that is higher. Where all are clipped,
    skin gets the model's colour and anything else is white. A model that is brighter than the clipped photo may be
    right, so it is not darkened.

    Args:
        log_ratio: (1, 3, S, S).
        clipped: (1, 3, S, S) in [0, 1], see `clipped_share`.
        skin: (1, 1, S, S) in [0, 1], see `flesh_share`.
    """
    reliable = 1 - clipped
    known = reliable.sum(1, keepdim=True)
    others = torch.maximum(log_ratio, (log_ratio * reliable).sum(1, keepdim=True) / known.clamp_min(1e-3))
    white = log_ratio - log_ratio.mean(1, keepdim=True).clamp_max(0)
    blown = white + skin * (log_ratio.amax(1, keepdim=True).clamp_min(0) - white)
    brighter = blown + (others - blown) * known.clamp_max(1)
    return log_ratio + (brighter - log_ratio) * clipped


def fill_in(image: torch.Tensor, weight: torch.Tensor) -> torch.Tensor:
    """Fill in unknown pixels by means over surroundings as wide as necessary: push-pull (Gortler et al. 1996).

    Args:
        image: (1, C, S, S).
        weight: (1, 1, S, S) >= 0, how well each pixel is known; not 0 everywhere.
    """
    sums, weights = [image * weight], [weight]
    while weights[-1].shape[-1] > 1:
        sums.append(F.avg_pool2d(sums[-1], 2, ceil_mode=True))
        weights.append(F.avg_pool2d(weights[-1], 2, ceil_mode=True))
    result = sums[-1] / weights[-1].clamp_min(1e-12)
    for total, known in zip(reversed(sums[:-1]), reversed(weights[:-1]), strict=True):
        result = F.interpolate(result, size=total.shape[-2:], mode="bilinear", align_corners=False)
        result = result + (total / known.clamp_min(1e-12) - result) * (known / _ENOUGH).clamp(0, 1)
    return result
