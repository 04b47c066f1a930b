"""A surface under a light in one go, where nobody asks for the steps."""

from __future__ import annotations

from collections.abc import Sequence

import torch

from relight_core.lighting.lamps import Lamp
from relight_core.lighting.relief import ReliefTransport
from relight_core.networks.pair import BothNetworks
from relight_core.pipeline import stages
from relight_core.pipeline.per_light.hard_shadow import LampsView, harden_shadow
from relight_core.pipeline.per_light.hints import Effects


def light_surface(
    networks: BothNetworks,
    reflector: stages.Reflector,
    surface: stages.Surface,
    relief: ReliefTransport | None,
    light: torch.Tensor,
    *,
    by_network: bool,
    corrected: bool,
    lamps_view: LampsView | None = None,
    lamps: Sequence[Lamp] = (),
) -> tuple[torch.Tensor, Effects, stages.Composed]:
    """Irradiance and gloss, effects and image at the networks' size of a normalised light (1, 16, 32, 3).

    Args:
        reflector: of the surface.
        by_network, corrected: whether the networks have a say in the effects, and in the image.
        lamps_view: of the surface and the relief, and
        lamps: the light's small ones, whose shadows get edges; both or neither.
    """
    reflected = stages.reflect(reflector, light)
    effects = stages.estimate_effects(networks if by_network else None, surface, reflected, relief, light)
    if lamps_view is not None:
        effects = harden_shadow(effects, surface, reflected, light, lamps_view, lamps)
    return reflected, effects, stages.compose(networks if corrected else None, surface, reflected, effects, light)
