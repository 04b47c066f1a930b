"""Glare: the bright rim along jaw, ear or nape where a light from behind grazes skin.

At grazing angles skin reflects many times as much as elsewhere, from a direction about which nothing else in the photo
says anything. So the estimated light can't explain it, and it must not end up in the albedo.
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
"""Ramp, in logs above the median of the skin, over which a pixel becomes glare."""
_LITTLE = 1e-4
"""Weight of pixels that are only used to fill in if there are no others."""


def without_glare(surface: Surface, shading: torch.Tensor, skin: torch.Tensor) -> Surface:
    """The surface with glare in its skin's albedo replaced by the albedo of the skin around.

    A pixel is glare if two things exceed their medians over the skin: the ratio of the photo to albedo times shading,
    and the photo's own brightness. If only the ratio does, the shading is too dark because of a wrong shadow.

    Args:
        surface: of the photo.
        shading: (1, 1, S, S) luminance of the irradiance over pi under the photo's light.
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
    """The degree to which a logarithm (1, 1, S, S) exceeds its median over the skin, [0, 1]."""
    return ramp(logarithm - logarithm[skin].median(), _FROM, _TO)
