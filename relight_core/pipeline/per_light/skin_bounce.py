"""Interreflection: light of small lamps that lit skin reflects into their shadows.

The SS network was trained on heads with interreflection, so its shadows are as light as that makes them. The relief's
shadows, which replace them, contain only direct light: beside a nose, where skin faces a lit cheek, they would be
black smears. The first bounce adds what is missing, in the colour of skin.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F

from relight_core.imaging.tensor_images import enlarge
from relight_core.imaging.tensor_normals import unit_normals
from relight_core.lighting.bounce import Bounce, gather_bounce
from relight_core.pipeline.stages import Surface

_RECEIVERS = 64
"""Pixels along a side of the maps in which it is gathered; interreflection has no sharp edges."""


@torch.inference_mode()
def skin_bounce(surface: Surface) -> Bounce:
    """The bounce from the whole surface to bare skin, but not to eye sockets, which `stages.reflector` has already."""
    receives = _shrunk(surface.bare_skin * (1 - surface.eye_sockets))
    relief, person = _shrunk(surface.relief), _shrunk(surface.person)
    normal = unit_normals(_shrunk(surface.normal))
    # An albedo of 1, since `interreflection` is given radiance, which contains the albedo.
    return gather_bounce(normal, relief, torch.ones_like(normal), person, receives[0, 0])


def interreflection(bounce: Bounce, radiance: torch.Tensor, albedo: torch.Tensor) -> torch.Tensor:
    """The radiance that a surface's skin reflects a second time, (1, 3, S, S), from the radiance that it sends out.

    Args:
        bounce: `skin_bounce` of the surface.
        radiance, albedo: (1, 3, S, S), linear.
    """
    return albedo * enlarge(bounce.of(_shrunk(radiance)), albedo.shape[-2:])


def _shrunk(image: torch.Tensor) -> torch.Tensor:
    """An image (1, C, S, S) averaged to at most `_RECEIVERS` pixels along a side."""
    return F.interpolate(image.float(), size=min(_RECEIVERS, image.shape[-1]), mode="area")
