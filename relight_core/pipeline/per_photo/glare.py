"""Light from behind that grazes skin: a bright rim along jaw, ear or nape, which is not the skin's own colour.

At grazing angles skin reflects many times what it does elsewhere, from a direction of which nothing else in the photo
tells. Neither the estimated light nor the albedo can be expected to explain it.
"""

from __future__ import annotations

from dataclasses import replace

import torch

from relight_core.face.parsing import FEWEST_OF_SKIN, SURELY, likely
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_colour import grey
from relight_core.imaging.tensor_logs import DARKEST, exact_logs
from relight_core.pipeline.per_photo.blown import fill_in
from relight_core.pipeline.stages import Surface

_FROM, _TO = 0.25, 0.6
_LITTLE = 1e-4


def without_glare(surface: Surface, shading: torch.Tensor, skin: torch.Tensor) -> Surface:
    """The surface with the albedo of the skin around it where glare made its skin's brighter.

    Glare is what is brighter than its albedo in the known light, beyond what the log of their ratio is for most of the
    skin, and brighter in the photo than most of the skin too: where only the shading is too dark, a shadow was
    mistaken.

    Args:
        shading: (1, 1, S, S) grey irradiance / pi of the photo's light.
        skin: (1, 1, S, S) probability of skin.
    """
    known = skin > SURELY
    if int(known.sum()) < FEWEST_OF_SKIN:
        return surface
    albedo = grey(surface.albedo).clamp_min(DARKEST)
    seen = exact_logs(grey(surface.photo))
    beyond_model = _beyond_most(seen - exact_logs(albedo * shading), known)
    glare = likely(skin) * torch.minimum(beyond_model, _beyond_most(seen, known))
    around = fill_in(surface.albedo, skin.square() * (1 - glare).square() + _LITTLE**2)
    instead = torch.lerp(surface.albedo, around, glare)
    return replace(surface, albedo=torch.where(grey(around) < albedo, instead, surface.albedo))


def _beyond_most(logarithm: torch.Tensor, skin: torch.Tensor) -> torch.Tensor:
    """How surely a logarithm (1, 1, S, S) lies beyond its median over the skin, [0, 1]."""
    return ramp(logarithm - logarithm[skin].median(), _FROM, _TO)
