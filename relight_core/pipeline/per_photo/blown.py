"""Where a photo is blown out it says nothing of a surface's colour, and the networks' guess there is noise in colours.

Blown skin has the colour of the skin around it, and blown lips that of what is left of them. Other things that are
blown are white: a cap, a collar, a wall.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F

from relight_core.face.parsing import BROWS, INDEX, share_of, skin_share
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_colour import grey

_FROM, _TO = 0.9, 0.99
"""Values of a channel, linear, from which on it counts as clipped, in part and altogether."""
_LITTLE = 1e-4
"""The weight of pixels that count only where there are no others; its powers, where there are not even those."""
_BRIGHTER = 1.4
"""How much brighter than the skin around blown skin may be taken for, at the most."""
_ENOUGH = 0.02
"""Mean weight of an area from which on its own mean is taken, and not that of wider surroundings."""
_SKIN_FOR_LIPS = 0.02
"""The weight of skin's colour beside that of lips, for lips of which nothing is left."""


def clipped_share(photo: torch.Tensor) -> torch.Tensor:
    """How far each channel of a photo (1, 3, S, S), linear, counts as clipped, [0, 1]."""
    return ramp(photo, _FROM, _TO)


def flesh_share(parsing: torch.Tensor) -> torch.Tensor:
    """(1, 1, S, S) probability of what isn't white where it is blown out: skin, with lips, and seen between brows."""
    return (skin_share(parsing) + share_of(parsing, (*BROWS, "lips"))).clamp(0, 1)


def mend_blown(clipped: torch.Tensor, albedo: torch.Tensor, parsing: torch.Tensor) -> torch.Tensor:
    """The albedo with colours that don't come from noise where the photo is blown out.

    Two clipped channels count as blown, one as half so. A single one is lifted to where the others leave it in the
    colour of the skin around: red is clipped first, and what is left of skin without it is yellow.

    Args:
        clipped: (1, 3, S, S) how far each channel of the photo is clipped there, see `clipped_share`.
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
    """(1, 3, S, S) the albedo of skin all over, and of lips where there are lips."""
    skin, lips = skin_share(parsing).square() * known, parsing[:, INDEX["lips"], None]
    around = fill_in(albedo, skin + _LITTLE**3)
    if bool((lips > 0.5).any()):
        of_lips = fill_in(albedo, lips.square() * known + _SKIN_FOR_LIPS * skin + _LITTLE**3)
        around = around + lips * (of_lips - around)
    return around.clamp_min(1e-3)


def at_least(log_ratio: torch.Tensor, clipped: torch.Tensor, skin: torch.Tensor) -> torch.Tensor:
    """The log ratio of a photo over its model where clipped channels may have been brighter than they look.

    A clipped channel was off by as much as those that are not clipped, if that makes it brighter. Where all are
    clipped, skin has the model's colour and anything else is white; a model that is brighter still is not wrong.

    Args:
        log_ratio: (1, 3, S, S).
        clipped: (1, 3, S, S) how far each channel of the photo is clipped there, see `clipped_share`.
        skin: (1, 1, S, S) how much it is skin, [0, 1].
    """
    reliable = 1 - clipped
    known = reliable.sum(1, keepdim=True)
    others = torch.maximum(log_ratio, (log_ratio * reliable).sum(1, keepdim=True) / known.clamp_min(1e-3))
    white = log_ratio - log_ratio.mean(1, keepdim=True).clamp_max(0)
    blown = white + skin * (log_ratio.amax(1, keepdim=True).clamp_min(0) - white)
    brighter = blown + (others - blown) * known.clamp_max(1)
    return log_ratio + (brighter - log_ratio) * clipped


def fill_in(image: torch.Tensor, weight: torch.Tensor) -> torch.Tensor:
    """Means over as wide surroundings as it takes to know something: push and pull (Gortler et al. 1996).

    Args:
        image: (1, C, S, S).
        weight: (1, 1, S, S) >= 0, how much each pixel is known; not 0 everywhere.
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
