"""Shadows with the edges that small lamps give them.

The SS network sees a light in texels of 11 degrees and a relief marched as coarsely, and has learnt to hedge:
what it says of a sun's shadow is right in the large, pale and soft at the edge. It knows whether there is a
shadow, geometry knows where a shadow ends. So where a light has small lamps and the network sees their shadow, the
same relief is asked again, finely and for exactly their direction and size, and its answer takes the place of the
network's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import torch
import torch.nn.functional as F

from relight_core.face.parsing import FACE_LABELS, INDEX
from relight_core.imaging.tensor_colour import grey
from relight_core.lighting.horizon import Horizon
from relight_core.lighting.lamps import Lamp, footprint
from relight_core.lighting.relief import ReliefTransport
from relight_core.pipeline.per_light.hints import Effects, hidden_share, with_hidden_share
from relight_core.pipeline.stages import Surface

_LEAST_OPEN = 0.05
_SURE = 0.5
"""Share of a lamp's light that the network takes for hidden from which on geometry alone decides."""
_DOUBT = 0.05
_MARGIN_PX = 5
_MOUTH = {INDEX["inner_mouth"], INDEX["lips"]}
_SKIN = sorted({*FACE_LABELS, INDEX["neck"]} - _MOUTH)


def horizon_of(surface: Surface) -> Horizon:
    """A surface's relief, ready to be asked for the shadows of small lamps."""
    return Horizon(surface.relief[0, 0].cpu().numpy(), surface.person[0, 0].cpu().numpy() > 0.5)


@torch.inference_mode()
def harden_shadow(
    effects: Effects,
    surface: Surface,
    reflected: torch.Tensor,
    light: torch.Tensor,
    transport: ReliefTransport,
    horizon: Horizon,
    lamps: Sequence[Lamp],
) -> Effects:
    """The effects with edges in the shadow of every lamp.

    Gloss is hidden with the light that causes it: it changes as what is left of the diffuse light does.

    Args:
        effects, reflected: as of `hints.explicit_sum`.
        light: (1, 16, 32, 3) that they are the effects of.
        transport: the relief as they were made with.
        lamps: of the light, in the view's camera space.
    """
    if not lamps:
        return effects
    diffuse, gloss = grey(surface.albedo * reflected[:, :3]), grey(reflected[:, 3:])
    hidden = hidden_share(effects, diffuse, gloss)
    radiance = grey(light.float().cpu().permute(0, 3, 1, 2))[0, 0]
    all_and_each = torch.stack([radiance, *(torch.from_numpy(footprint(lamp)) for lamp in lamps)])
    lost, *lost_of_each = 1 - transport.visibility(all_and_each, reflected.shape[-1]).to(hidden)
    hardened, skin, irradiance = hidden, _bare_skin(surface), grey(reflected[:, :3]).clamp_min(1e-3)
    for lamp, soft in zip(lamps, lost_of_each, strict=True):
        part = _part(lamp, surface, irradiance)
        of_lamp = torch.minimum(hidden * (part * (soft + _DOUBT) / (lost + _DOUBT)).clamp(0, 1), part)
        sure = lamp.hardness * skin * (of_lamp / (_SURE * part).clamp_min(1e-4)).clamp(0, 1)
        seen = torch.from_numpy(horizon.visibility(lamp.toward, lamp.radius_deg))[None, None].to(hidden)
        change = part * (1 - seen) - of_lamp
        # A shadow that the relief knows nothing of, of a brim or a lock of hair, is not its to take away.
        hardened = hardened + sure * torch.where(change > 0, change, change * (soft / _SURE).clamp_max(1))
    hardened = hardened.clamp(0, 1)
    left = (1 - hardened) / (1 - hidden).clamp_min(_LEAST_OPEN)
    specular = torch.minimum(effects.specular * left, torch.maximum(gloss, effects.specular))
    return with_hidden_share(replace(effects, specular=specular), hardened, diffuse, gloss)


def _bare_skin(surface: Surface) -> torch.Tensor:
    """(1, 1, S, S) in [0, 1]: well within the face and the neck, the mouth left out.

    Where a strand of hair, a collar or a tooth stands out, and by how much, the relief only guesses, pixel by pixel;
    its edges there would be notches.
    """
    share = surface.parsing[:, _SKIN].sum(1, keepdim=True)
    near = F.avg_pool2d(share, _MARGIN_PX, stride=1, padding=_MARGIN_PX // 2, count_include_pad=False)
    return (2 * near - 1).clamp(0, 1)


def _part(lamp: Lamp, surface: Surface, irradiance: torch.Tensor) -> torch.Tensor:
    """(1, 1, S, S) in [0, 1]: the lamp's share of all grey irradiance where nothing is hidden."""
    toward = torch.tensor(lamp.toward, device=irradiance.device)[:, None, None]
    facing = (surface.normal * toward).sum(1, keepdim=True).clamp_min(0)
    return (facing * lamp.irradiance / irradiance).clamp(0, 1)
