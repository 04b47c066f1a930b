"""What is not skin has the colours that photo and light together give it.

Skin is of few colours, and de-lighting knows them. Cloth, hats, hair and lips may be of any, and what it says of them
is a guess; but once the light is explained, photo over irradiance says more: on held-out heads it explains a half to
two thirds of what the albedo's colours are off by. It says less about how bright they are, since shadows that the
relief doesn't know are part of it; only hats, whose shape is as much of a guess, and brows, of which the networks
see a few pixels, gain by it.
"""

from __future__ import annotations

from dataclasses import replace

import torch

from relight_core.face.parsing import BROWS, INDEX, share_of, skin_share
from relight_core.imaging.tensor_colour import as_bright_as
from relight_core.imaging.tensor_logs import LARGEST_LOG, log_ratios
from relight_core.imaging.tensor_means import local_means
from relight_core.pipeline.per_photo.black_colour import off_black
from relight_core.pipeline.per_photo.blown import at_least, clipped_share, flesh_share
from relight_core.pipeline.per_photo.mouth_colour import too_blue
from relight_core.pipeline.per_photo.source_light import level_over_person
from relight_core.pipeline.stages import Surface

_OF_ANY_COLOUR = ("hair", "hat", "cloth", "lips")
_HATS, _BROWS = 0.5, 0.8
"""How much of a log ratio of brightness is the surface's own, of brows beside the skin around; the rest is shading."""


def with_seen_colours(surface: Surface, irradiance: torch.Tensor, gloss: torch.Tensor) -> Surface:
    """The surface with the albedo of all that is not skin brought to the colours in which it is seen.

    Args:
        irradiance, gloss: (1, 3, S, S) each, the former over pi, what of the photo's light gets there, at any level.
    """
    model = surface.albedo * irradiance + gloss
    level = level_over_person(surface, model)
    if level is None:
        return surface
    log_ratio = log_ratios(surface.photo, level * model).clamp(-LARGEST_LOG, LARGEST_LOG)
    log_ratio = at_least(log_ratio, clipped_share(surface.photo), flesh_share(surface.parsing))
    brighter = log_ratio.mean(1, keepdim=True)
    colour = log_ratio - brighter
    colour = colour - not_as_seen(surface, colour)
    beside_skin = brighter - local_means(brighter, skin_share(surface.parsing))
    tinted = _tinted(surface.albedo, share_of(surface.parsing, _OF_ANY_COLOUR) * colour)
    brows, hat = share_of(surface.parsing, BROWS), surface.parsing[:, INDEX["hat"], None]
    change = _BROWS * brows * beside_skin + _HATS * hat * brighter
    return replace(surface, albedo=(tinted * torch.exp(change)).clamp(0, 1))


def not_as_seen(surface: Surface, tint: torch.Tensor) -> torch.Tensor:
    """The part of a tint (1, 3, S, S), of mean 0, that black hair and cloth, lips and teeth have not in the photo.

    It is the light's, and stays with the photo's own.
    """
    of_light = off_black(surface, tint)
    return of_light + too_blue(surface, tint - of_light)


def _tinted(albedo: torch.Tensor, tint: torch.Tensor) -> torch.Tensor:
    """An albedo (1, 3, S, S) of other colours, as bright as it was.

    A tint of mean 0 alone would leave the product of the channels, and make of a dull red a bright one.
    """
    return as_bright_as(albedo * torch.exp(tint), albedo)
