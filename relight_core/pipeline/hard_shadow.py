"""Shadows with the edges that small lamps give them.

The SS network sees a light in texels of 11 degrees and a relief marched as coarsely; what it says of a sun's
shadow is right in the large and soft at the edge. Where a light has small lamps, the same relief is asked
again, finely and for exactly their direction and size, and the difference between both answers is added.
"""

from __future__ import annotations

from collections.abc import Sequence

import torch

from relight_core.imaging.tensor_colour import grey
from relight_core.lighting.horizon import Horizon
from relight_core.lighting.lamps import Lamp, footprint
from relight_core.lighting.relief import ReliefTransport
from relight_core.pipeline.hints import Effects, hidden_share
from relight_core.pipeline.stages import Surface

_LEAST_OPEN = 0.05


def horizon_of(surface: Surface) -> Horizon:
    """A surface's relief, ready to be asked for the shadows of small lamps."""
    return Horizon(surface.relief[0, 0].cpu().numpy(), surface.person[0, 0].cpu().numpy() > 0.5)


@torch.inference_mode()
def harden_shadow(
    effects: Effects,
    surface: Surface,
    reflected: torch.Tensor,
    transport: ReliefTransport,
    horizon: Horizon,
    lamps: Sequence[Lamp],
) -> Effects:
    """The effects with edges in the shadow of every lamp.

    Gloss is hidden with the light that causes it: it changes as what is left of the diffuse light does.

    Args:
        effects, reflected: as of `hints.explicit_sum`.
        transport: the relief as the effects were made with.
        lamps: of the same light, in the view's camera space.
    """
    diffuse, gloss = grey(surface.albedo * reflected[:, :3]), grey(reflected[:, 3:])
    hidden = hidden_share(effects, diffuse, gloss)
    change = sum(_newly_hidden(surface, reflected, transport, horizon, lamp) for lamp in lamps)
    hardened = (hidden + change).clamp(0, 1)
    left = (1 - hardened) / (1 - hidden).clamp_min(_LEAST_OPEN)
    specular = torch.minimum(effects.specular * left, torch.maximum(gloss, effects.specular))
    return Effects(specular, diffuse * hardened + (gloss - specular).clamp_min(0))


def _newly_hidden(
    surface: Surface, reflected: torch.Tensor, transport: ReliefTransport, horizon: Horizon, lamp: Lamp
) -> torch.Tensor:
    """(1, 1, S, S) share of the irradiance that the lamp's hard shadow takes and its soft one did not."""
    device = reflected.device
    soft = transport.visibility(torch.from_numpy(footprint(lamp)), reflected.shape[-1]).to(device)
    hard = torch.from_numpy(horizon.visibility(lamp.toward, lamp.radius_deg))[None, None].to(device)
    facing = (surface.normal * torch.tensor(lamp.toward, device=device)[:, None, None]).sum(1, keepdim=True)
    part = facing.clamp_min(0) * lamp.irradiance / grey(reflected[:, :3]).clamp_min(1e-3)
    return lamp.hardness * part.clamp(0, 1) * (soft - hard)
