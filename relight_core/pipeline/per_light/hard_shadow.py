"""Sharp shadows of small lamps.

The SS network sees a light in texels of 11 degrees, and the shadow of a relief that was marched as coarsely. It has
learnt to hedge: a sun's shadow comes out in the right place, but pale and with a soft edge. So the network decides
whether there is a shadow, and geometry where it ends. If a light has small lamps and the network sees their shadow, the
same relief is marched again, at a higher resolution and for exactly their direction and size. The result replaces the
network's, and light that lit skin reflects into the shadow is added (`skin_bounce`).

For this the light is split into its lamps and the rest. How much of the rest arrives in a lamp's shadow is a small
difference of two large numbers, all light and the hidden part of it. The smaller the rest, the more the relief decides
about that too.

Terms: a lamp's *part* is its share of all unoccluded light, once for the diffuse light and once for the gloss. *Lost*
is the share of a lamp that is hidden, the same for both.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import torch

from relight_core.imaging.tensor_colour import grey
from relight_core.imaging.tensor_images import as_image, as_tensor
from relight_core.lighting.bounce import Bounce
from relight_core.lighting.horizon import Horizon
from relight_core.lighting.lamps import Lamp, footprint
from relight_core.lighting.reflection import specular_lobe
from relight_core.lighting.relief import ReliefTransport
from relight_core.lighting.sphere import solid_angles
from relight_core.pipeline.per_light.fine_edges import LampEdge, ShadowEdges
from relight_core.pipeline.per_light.hints import (
    Effects,
    hidden_gloss,
    hidden_share,
    smooth_gloss,
    with_hidden_share,
)
from relight_core.pipeline.per_light.skin_bounce import interreflection, skin_bounce
from relight_core.pipeline.stages import Surface

_SURE = 0.5
"""If the network takes at least this share of a lamp's light to be hidden, geometry alone decides."""
_DOUBT = 0.05
"""Added to numerator and denominator when the network's hidden light is divided among lamps: if the relief hides next
to nothing of any lamp, each gets its part."""
_SMALL_REST = 0.2
"""Rest of the light, as a share of all light, at which network and relief have equal weight about that rest."""
_NO_GLOSS, _NO_LIGHT = 1e-6, 1e-12
"""Smallest divisors."""
_GRAZING = 0.01
"""Added to the cosine at a lamp, since texels of 11 degrees also light what just faces away from it."""


@dataclass(frozen=True, eq=False)
class LampsView:
    """What small lamps need of a surface, computed once for all lights.

    Attributes:
        horizon: of its relief.
        bounce: interreflection from the surface to its bare skin.
        transport: of the same relief, as coarse as in the network's input.
        reflect: what the surface reflects of a light, as `stages.reflect`. A lamp's irradiance comes from its texels of
            11 degrees, like that of all light, and not from its cosine: at grazing angles the two differ.
        roll_deg: of the view in the photo, as `Crop.roll_deg`; the surface is in the view's camera space.
    """

    horizon: Horizon
    bounce: Bounce
    transport: ReliefTransport
    reflect: Callable[[torch.Tensor], torch.Tensor]
    roll_deg: float


def ready_for_lamps(
    surface: Surface,
    transport: ReliefTransport,
    reflect: Callable[[torch.Tensor], torch.Tensor],
    roll_deg: float = 0.0,
) -> LampsView:
    """Prepare a surface for the shadows of small lamps; independent of its albedo."""
    horizon = Horizon(as_image(surface.relief), as_image(surface.person) > 0.5)
    return LampsView(horizon, skin_bounce(surface), transport, reflect, roll_deg)


@torch.inference_mode()
def harden_shadow(
    effects: Effects,
    surface: Surface,
    reflected: torch.Tensor,
    light: torch.Tensor,
    view: LampsView,
    lamps: Sequence[Lamp],
) -> Effects:
    """The effects with sharp edges in the shadow of every lamp, in the diffuse light and in the gloss.

    Args:
        effects, reflected: as of `hints.explicit_sum`.
        light: (1, 16, 32, 3) the light of these effects, in the view's camera space.
        view: the surface, prepared by `ready_for_lamps`.
        lamps: of the light, in the camera space of the photo.
    """
    if not lamps:
        return effects
    power = [torch.from_numpy(footprint(lamp, view.roll_deg)) for lamp in lamps]
    lamps = [lamp.rolled(view.roll_deg) for lamp in lamps]
    rest = _without(light, lamps, power)
    occlusion = _occlusion(surface, rest, view, lamps, power)
    of_lamps = view.reflect(light - rest)
    diffuse, gloss = grey(surface.albedo * reflected[:, :3]), grey(reflected[:, 3:])
    parts = _parts(_irradiance(lamps, surface), grey(reflected[:, :3]), grey(of_lamps[:, :3]))
    matt = _with_edges(hidden_share(effects, diffuse, gloss), parts, occlusion)
    dull = (hidden_gloss(effects, gloss) / gloss.clamp_min(_NO_GLOSS)).clamp(0, 1)
    shiny = _with_edges(dull, _parts(_gloss(lamps, surface), gloss, grey(of_lamps[:, 3:])), occlusion)
    radiance = surface.albedo * of_lamps[:, :3] * _share_seen(lamps, parts, occlusion, matt.hidden)
    ends = zip(lamps, map(as_image, matt.counts), map(as_image, occlusion.lost_finely), strict=True)
    edges = [LampEdge(*of_lamp) for of_lamp in ends]
    hardened = replace(
        effects,
        specular=(effects.specular - gloss * (shiny.hidden - dull)).clamp_min(0),
        by_relief=matt.by_relief,
        gloss_by_relief=shiny.by_relief,
        interreflection=interreflection(view.bounce, radiance, surface.albedo),
        edges=ShadowEdges(view.horizon, edges, as_image(matt.hidden), as_image(diffuse)),
    )
    return with_hidden_share(hardened, matt.hidden, diffuse, gloss)


@dataclass(frozen=True)
class _Occlusion:
    """What the relief hides of each lamp, and of the rest of the light; maps (1, 1, S, S) in [0, 1].

    Attributes:
        lost: for each lamp the share that is hidden, as coarsely as in the network's input.
        lost_finely: the same with sharp edges, from the finely marched horizon.
        lost_rest: the share of the rest of the light that is hidden.
        decides: for each lamp the weight of geometry: the lamp's hardness times how certainly a pixel is bare skin.
    """

    lost: Sequence[torch.Tensor]
    lost_finely: Sequence[torch.Tensor]
    lost_rest: torch.Tensor
    decides: Sequence[torch.Tensor]

    @cached_property
    def lost_as_decided(self) -> Sequence[torch.Tensor]:
        """For each lamp the share that is hidden, with edges as sharp as the weight of geometry makes them."""
        of_each = zip(self.lost, self.lost_finely, self.decides, strict=True)
        return [torch.lerp(soft, sharp, decides) for soft, sharp, decides in of_each]


@dataclass(frozen=True)
class _Edged:
    """What is hidden of the diffuse light or of the gloss, with sharp edges; maps (1, 1, S, S).

    Attributes:
        hidden: the share of it that is hidden, in [0, 1].
        by_relief: the share that the relief alone would hide.
        counts: for each lamp, as of `LampEdge.counts`.
    """

    hidden: torch.Tensor
    by_relief: torch.Tensor
    counts: Sequence[torch.Tensor]


def _without(light: torch.Tensor, lamps: Sequence[Lamp], power: Sequence[torch.Tensor]) -> torch.Tensor:
    """The light (1, 16, 32, 3) without its lamps; all channels of a texel are dimmed by the same factor.

    Args:
        power: for each lamp the distribution of its power over texels, (16, 32), see `footprint`.
    """
    radiance = grey(light.float().permute(0, 3, 1, 2))[0, 0]
    of_lamps = sum(share * (torch.pi * lamp.irradiance) for share, lamp in zip(power, lamps, strict=True))
    of_lamps = (of_lamps / torch.from_numpy(solid_angles(*radiance.shape))).to(radiance)
    left = (1 - of_lamps / radiance.clamp_min(_NO_LIGHT)).clamp(0, 1)
    return light * left[None, :, :, None]


def _occlusion(
    surface: Surface,
    rest: torch.Tensor,
    view: LampsView,
    lamps: Sequence[Lamp],
    power: Sequence[torch.Tensor],
) -> _Occlusion:
    """What the relief hides of the lamps and of the `rest` of the light, (1, 16, 32, 3); `power` as of `_without`."""
    like = surface.relief
    rest = grey(rest.float().cpu().permute(0, 3, 1, 2))[0, 0]
    lost_rest, *lost = 1 - view.transport.visibility(torch.stack([rest, *power]), like.shape[-1]).to(like)
    seen = (as_tensor(view.horizon.visibility(lamp.toward, lamp.radius_deg), like.device) for lamp in lamps)
    decides = [lamp.hardness * surface.bare_skin for lamp in lamps]
    return _Occlusion(lost, [1 - share for share in seen], lost_rest, decides)


def _lost(parts: Sequence[torch.Tensor], lost: Sequence[torch.Tensor], occlusion: _Occlusion) -> torch.Tensor:
    """Share of all light that the relief hides, (1, 1, S, S), from each lamp's part and the share `lost` of it."""
    return sum(part * share for part, share in zip(parts, lost, strict=True)) + _rest(parts) * occlusion.lost_rest


def _share_seen(
    lamps: Sequence[Lamp], parts: Sequence[torch.Tensor], occlusion: _Occlusion, hidden: torch.Tensor
) -> torch.Tensor:
    """Share of the lamps' light that arrives, weighted by the lamps' hardness, (1, 1, S, S) in [0, 1].

    Args:
        hidden: the share of all light that is hidden, which may be more than the relief hides.
    """
    by_relief = sum(
        lamp.hardness * part * (1 - lost) for lamp, part, lost in zip(lamps, parts, occlusion.lost_finely, strict=True)
    )
    return torch.minimum(by_relief, 1 - hidden) / sum(parts).clamp_min(_NO_GLOSS)


def _rest(parts: Sequence[torch.Tensor]) -> torch.Tensor:
    """The share of all unoccluded light that is not the lamps', (1, 1, S, S)."""
    return (1 - sum(parts)).clamp_min(0)


def _with_edges(hidden: torch.Tensor, parts: Sequence[torch.Tensor], occlusion: _Occlusion) -> _Edged:
    """Sharpen the shadows of lamps, in the diffuse light or in the gloss.

    Args:
        hidden: (1, 1, S, S) the share that the network takes to be hidden, in [0, 1].
        parts: for each lamp, see `_parts`.
        occlusion: what the relief hides.
    """
    edged, of_lamps, unlit, counts = hidden, torch.zeros_like(hidden), torch.zeros_like(hidden), []
    of_each = zip(_by_lamp(hidden, parts, occlusion), parts, occlusion.lost, occlusion.lost_finely, strict=True)
    for (of_lamp, sure), part, soft, sharp in of_each:
        change = part * sharp - of_lamp
        # The relief may deepen any shadow, but lighten only one that it casts itself, not that of a brim or a lock.
        known = (soft / _SURE).clamp_max(1)
        edged = edged + sure * torch.where(change > 0, change, change * known)
        counts.append(sure * (part - (1 - known) * of_lamp))
        of_lamps, unlit = of_lamps + of_lamp, unlit + sure * part * sharp
    rest, of_rest = _rest(parts), (hidden - of_lamps).clamp_min(0)
    doubt = unlit.clamp(0, 1) / (1 + (rest / _SMALL_REST).square())
    edged = (edged + doubt * (rest * occlusion.lost_rest - of_rest)).clamp(0, 1)
    return _Edged(edged, _lost(parts, occlusion.lost_as_decided, occlusion), counts)


def _by_lamp(
    hidden: torch.Tensor, parts: Sequence[torch.Tensor], occlusion: _Occlusion
) -> list[tuple[torch.Tensor, torch.Tensor]]:
    """For each lamp, how much of the light that the network hides is the lamp's, and the weight of geometry.

    Both are (1, 1, S, S), the former a share of all light and at most the lamp's part. The network only predicts how
    much is hidden in total. That is divided among the lamps and the rest in proportion to what the relief hides of
    each.
    """
    lost, result = _lost(parts, occlusion.lost, occlusion), []
    for part, soft, decides in zip(parts, occlusion.lost, occlusion.decides, strict=True):
        of_lamp = torch.minimum(hidden * (part * (soft + _DOUBT) / (lost + _DOUBT)).clamp(0, 1), part)
        result.append((of_lamp, decides * (of_lamp / (_SURE * part).clamp_min(1e-4)).clamp(0, 1)))
    return result


def _parts(given: Sequence[torch.Tensor], all_light: torch.Tensor, of_lamps: torch.Tensor) -> list[torch.Tensor]:
    """Each lamp's share of all unoccluded irradiance, or gloss, (1, 1, S, S) in [0, 1].

    Args:
        given: what each lamp gives, > 0; only the proportions between lamps count.
        all_light, of_lamps: luminance of the irradiance or gloss of the whole light, and of its lamps together.
    """
    share = (of_lamps / all_light.clamp_min(_NO_GLOSS)).clamp(0, 1)
    together = sum(given)
    return [share * (of_lamp / together) for of_lamp in given]


def _irradiance(lamps: Sequence[Lamp], surface: Surface) -> list[torch.Tensor]:
    """Unoccluded irradiance over pi from each lamp, (1, 1, S, S) > 0."""
    toward = [torch.tensor(lamp.toward, device=surface.normal.device)[:, None, None] for lamp in lamps]
    facing = [(surface.normal * direction).sum(1, keepdim=True).clamp_min(0) + _GRAZING for direction in toward]
    return [of_lamp * lamp.irradiance for of_lamp, lamp in zip(facing, lamps, strict=True)]


def _gloss(lamps: Sequence[Lamp], surface: Surface) -> list[torch.Tensor]:
    """Luminance of each lamp's unoccluded highlight, (1, 1, S, S) > 0."""
    normal = surface.normal[0].float().flatten(1).T
    toward = normal.new_tensor([lamp.toward for lamp in lamps])
    power = normal.new_tensor([torch.pi * lamp.irradiance for lamp in lamps])
    of_lamps = ((specular_lobe(toward, normal) + _NO_GLOSS) * power[:, None]).unflatten(1, surface.normal.shape[-2:])
    return list(smooth_gloss(of_lamps[None]).split(1, dim=1))
