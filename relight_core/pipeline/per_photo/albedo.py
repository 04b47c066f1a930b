"""Shading that de-lighting left in the albedo, taken out by what is known of the light.

Whatever a person's skin looks like, its colour has no reason to follow the light: where it does, the
network has mistaken one for the other. Once the source light is explained, that is measured over the skin
and divided out.

Nor has skin the colours of other lamps (see `skin_colour`), and the rim that a light from behind draws along a jaw is
no part of it (see `glare`). All else has the colours that it is seen in (see `seen_colour`).
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
_FLOOR = 0.02
_CLIPPED = 0.95


@torch.inference_mode()
def flatten_albedo(surface: Surface, relief: ReliefTransport, light: torch.Tensor, reflected: torch.Tensor) -> Surface:
    """The surface without what is left of the light in its skin's albedo, and with the colours of all else.

    Args:
        relief: transport of the surface's own relief.
        light: (1, 16, 32, 3) the source light.
        reflected: (1, 6, S, S) irradiance over pi and gloss of that light, no shadows.
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

    The slope of log albedo over log shading (1, 1, S, S), by least squares over the skin, is the power of the shading
    that went into the albedo.
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
    """(1, 1, S, S) probability of bare skin, of (1, classes, S, S), without the scalp.

    A scalp is parsed as neck, bald or with hair that is cropped, and white hair on top of a head would pass for
    skin that the light's shading and colours are left in.
    """
    skin, above = skin_share(parsing), above_the_eyes(parsing)
    return skin if above is None else skin - parsing[:, INDEX["neck"], None] * above


def grey_irradiance(relief: ReliefTransport, light: torch.Tensor) -> torch.Tensor:
    """Rec.709 irradiance / pi behind the relief's own shadows, (1, 1, S, S), of one light (1, 16, 32, 3)."""
    image = (relief.shadowed @ light.cpu().flatten(1, 2)[0]).T.reshape(1, 3, relief.size, relief.size)
    return grey(image)
