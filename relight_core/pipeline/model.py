"""A surface under a light in one go, where nobody asks for the steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch

from relight_core.lighting.lamps import Lamp
from relight_core.lighting.relief import ReliefTransport
from relight_core.networks.pair import BothNetworks
from relight_core.pipeline import stages
from relight_core.pipeline.per_light.hard_shadow import LampsView, harden_shadow
from relight_core.pipeline.prepared import Lit


@dataclass(frozen=True, eq=False)
class ReadySurface:
    """A surface with what is found of it once, for any light.

    Attributes:
        reflector: of the surface.
        relief: transport of its relief; None leaves out the shadow that the relief casts.
        lamps_view: of the surface and the relief; None leaves the shadows of small lamps without edges.
    """

    surface: stages.Surface
    reflector: stages.Reflector
    relief: ReliefTransport | None
    lamps_view: LampsView | None = None


def light_surface(
    ready: ReadySurface,
    light: torch.Tensor,
    occluding: BothNetworks | None,
    composing: BothNetworks | None,
    lamps: Sequence[Lamp] = (),
) -> Lit:
    """Irradiance and gloss, effects and image at the networks' size, of a normalised light (1, 16, 32, 3).

    Args:
        occluding: of which SS says what is hidden from the light; None lets the relief alone say it.
        composing: of which composition corrects the explicit sum; None leaves that.
        lamps: the light's small ones, whose shadows get edges; only read where there is a `lamps_view`.
    """
    surface = ready.surface
    reflected = stages.reflect(ready.reflector, light)
    effects = stages.estimate_effects(occluding, surface, reflected, ready.relief, light)
    if ready.lamps_view is not None:
        effects = harden_shadow(effects, surface, reflected, light, ready.lamps_view, lamps)
    return Lit(light, reflected, effects, stages.compose(composing, surface, reflected, effects, light))
