"""The colour of shadows: a place that a red lamp can't reach is still lit by a blue one.

The paper's shadow is one grey map (section 3.2). Darkening all colours alike is right under a light of one colour. With
several colours, as between two neon tubes, the relief determines how the shadow is divided among colours; its overall
depth remains the network's. On held-out heads this makes next to no difference in figures (docs/speed.md), so it is
skipped for lights of nearly one colour. A sun under a blue sky, or a white key lamp with a weak gel opposite, is not
such a light: otherwise up to a third of the colour that still reaches their shadows would be missing.
"""

from __future__ import annotations

import torch

from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_colour import grey
from relight_core.lighting.relief import ReliefTransport
from relight_core.lighting.sphere import solid_angles

_PLAIN, _COLOURFUL = 0.05, 0.15
"""Ramp of a light's `colourfulness` over which shadows are divided by colour."""
_DOUBT = 0.02
"""Added to numerator and denominator of the odds, to keep them finite."""


def shadow_colour_odds(transport: ReliefTransport, light: torch.Tensor, reflected: torch.Tensor) -> torch.Tensor | None:
    """The odds that each colour is hidden, over those for all light together (see `hints.Effects.colour_odds`).

    Args:
        transport: of the relief.
        light: (1, 16, 32, 3).
        reflected: (1, 6, S, S) of that light, as of `hints.explicit_sum`.

    Returns:
        (1, 3, S, S) > 0, around 1; None if the light has one colour.
    """
    amount = ramp(colourfulness(light), _PLAIN, _COLOURFUL)
    if amount == 0:
        return None
    hidden = 1 - transport.visibility(light[0].permute(2, 0, 1).cpu(), reflected.shape[-1])[:, 0].to(reflected)[None]
    irradiance = reflected[:, :3]
    mean = grey(irradiance * hidden) / grey(irradiance).clamp_min(1e-6)
    return (_odds(hidden) / _odds(mean)).pow(amount)


def _odds(share: torch.Tensor) -> torch.Tensor:
    """The odds of a share in [0, 1], finite at both ends."""
    return (share + _DOUBT) / (1 - share + _DOUBT)


def colourfulness(light: torch.Tensor) -> float:
    """How much the colour of a light (1, H, 2H, 3) varies over the sphere: from 0 up to 4 / 3 for pure primaries."""
    areas = torch.from_numpy(solid_angles(*light.shape[1:3])).to(light)[None, ..., None]
    power = light.float() * areas
    mean = power.mean(-1, keepdim=True)
    total = float(mean.sum())
    if total <= 0:
        return 0.0
    colour = power.sum((1, 2), keepdim=True) / total
    return float((power - mean * colour).abs().sum()) / (3 * total)
