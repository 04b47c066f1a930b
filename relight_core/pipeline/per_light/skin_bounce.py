"""Light of small lamps that lit skin throws into their shadows.

The SS network learnt its shadows from heads that light themselves, so they are as light as that makes them. Those
that the relief casts in their place know direct light alone: beside a nose, where skin looks straight at a lit cheek,
they would be black smears. The first bounce gives back what is missing, in the colour of skin.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F

from relight_core.imaging.tensor_images import enlarge
from relight_core.imaging.tensor_normals import unit_normals
from relight_core.lighting.bounce import Bounce, gather_bounce
from relight_core.pipeline.stages import Surface

_RECEIVERS = 64
"""Pixels of a side at which it is gathered: what is thrown from skin to skin has no edges."""


@torch.inference_mode()
def skin_bounce(surface: Surface) -> Bounce:
    """What bare skin gets of all that the surface sends out; eye sockets have their own (see `stages.reflector`)."""
    receives = _shrunk(surface.bare_skin * (1 - surface.eye_sockets))
    relief, person = _shrunk(surface.relief), _shrunk(surface.person)
    normal = unit_normals(_shrunk(surface.normal))
    # Radiance is asked for, which has the albedo in it.
    return gather_bounce(normal, relief, torch.ones_like(normal), person, receives[0, 0])


def thrown_back(bounce: Bounce, radiance: torch.Tensor, albedo: torch.Tensor) -> torch.Tensor:
    """What a surface that sends out a radiance sends out once more, (1, 3, S, S).

    Args:
        bounce: `skin_bounce` of the surface.
        radiance, albedo: (1, 3, S, S), linear.
    """
    return albedo * enlarge(bounce.thrown_back(_shrunk(radiance)), albedo.shape[-2:])


def _shrunk(image: torch.Tensor) -> torch.Tensor:
    return F.interpolate(image.float(), size=min(_RECEIVERS, image.shape[-1]), mode="area")
