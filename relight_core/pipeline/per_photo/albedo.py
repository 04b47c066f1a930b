"""Removal of light that de-lighting left in the albedo, once the photo's light is known.

The albedo of skin has no reason to correlate with shading. If it does, the network has mistaken shading for albedo; the
correlation is measured over the skin and divided out. Colours of other lamps are removed from skin too (see
`skin_colour`), and so is the rim that a light from behind draws along a jaw (see `glare`). Everything else gets the
colours that photo and light give it (see `seen_colour`).
"""

from __future__ import annotations

from dataclasses import replace

import torch

from relight_core.face.parsing import FEWEST_OF_SKIN, INDEX, SURELY, skin_share
from relight_core.imaging.tensor_colour import grey
from relight_core.imaging.tensor_logs import exact_logs
from relight_core.lighting.relief import ReliefTransport
from relight_core.pipeline.per_photo.glare import without_glare
from relight_core.pipeline.per_photo.seen_colour import with_seen_colours
from relight_core.pipeline.per_photo.skin_colour import in_one_colour
from relight_core.pipeline.per_photo.white_hair import above_the_eyes
from relight_core.pipeline.stages import Surface, at_surface_size

_STRONGEST = 1.0
"""Largest power of the shading that is divided out."""
_FLOOR = 0.02
"""Added to irradiance, so that deep shadows don't divide by 0."""
_CLIPPED = 0.95
"""Value of a channel from which on a pixel is too near to clipping to be measured."""


@torch.inference_mode()
def flatten_albedo(surface: Surface, relief: ReliefTransport, light: torch.Tensor, reflected: torch.Tensor) -> Surface:
    """The surface with the light removed from its skin's albedo, and with everything else in the colours it is seen in.

    Args:
        surface: of the photo.
        relief: transport of the surface's own relief.
        light: (1, 16, 32, 3) the photo's light.
        reflected: (1, 6, S, S) unoccluded irradiance over pi and gloss of that light.
    """
    shading = at_surface_size(grey_irradiance(relief, light), surface) + _FLOOR
    skin = _skin_below_hair(surface.parsing)
    even = _without_shading(surface, shading.log(), skin)
    bare = in_one_colour(without_glare(even, shading, skin), skin)
    lit = 1 - at_surface_size(relief.shadow_fraction(light.cpu()), surface)
    irradiance, gloss = (lit * reflected).split(3, dim=1)
    return with_seen_colours(bare, irradiance + _FLOOR, gloss)


def _without_shading(surface: Surface, log_shading: torch.Tensor, skin: torch.Tensor) -> Surface:
    """The surface with its skin's albedo divided by the shading that is left in it.

    The albedo contains a power of the shading. That power is the slope of log albedo over log shading (1, 1, S, S), by
    least squares over the skin.
    """
    albedo = exact_logs(grey(surface.albedo))
    known = (skin > SURELY) & (surface.photo.amax(1, keepdim=True) < _CLIPPED)
    if int(known.sum()) < FEWEST_OF_SKIN:
        return surface
    centred = log_shading - log_shading[known].mean()
    variance = centred[known].square().mean()
    if float(variance) < 1e-4:
        return surface
    slope = float((centred[known] * (albedo[known] - albedo[known].mean())).mean() / variance)
    power = min(max(slope, 0.0), _STRONGEST)
    divided = surface.albedo * torch.exp(-power * centred * skin)
    return replace(surface, albedo=divided.clamp(0, 1))


def _skin_below_hair(parsing: torch.Tensor) -> torch.Tensor:
    """The probability of bare skin without the scalp, (1, 1, S, S), from (1, classes, S, S).

    Both bald scalps and cropped hair are parsed as neck. White hair on top of a head would then count as skin in whose
    albedo shading and colours of the light are left.
    """
    skin, above = skin_share(parsing), above_the_eyes(parsing)
    return skin if above is None else skin - parsing[:, INDEX["neck"], None] * above


def grey_irradiance(relief: ReliefTransport, light: torch.Tensor) -> torch.Tensor:
    """Luminance of the irradiance over pi under a light (1, 16, 32, 3), with the relief's shadows, (1, 1, S, S)."""
    image = (relief.shadowed @ light.cpu().flatten(1, 2)[0]).T.reshape(1, 3, relief.size, relief.size)
    return grey(image)
