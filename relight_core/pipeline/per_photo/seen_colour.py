"""Albedo colours of everything but skin, from the photo divided by the irradiance.

Skin has few colours, and de-lighting knows them. Cloth, hats, hair and lips may have any, so de-lighting can only
guess. Once the light is known, photo over irradiance is better: on held-out heads it explains a half to two thirds of
the error of the albedo's colours. It is worse for brightness, since it contains shadows that the relief doesn't know.
Only hats, whose shape is a guess too, and brows, of which the networks see only a few pixels, gain by it.
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
"""Share of the log ratio of brightness that belongs to the albedo, for brows relative to the skin around; the rest is
shading."""


def with_seen_colours(surface: Surface, irradiance: torch.Tensor, gloss: torch.Tensor) -> Surface:
    """The surface with the albedo of everything but skin changed to the colours that explain the photo.

    Args:
        surface: of the photo.
        irradiance, gloss: (1, 3, S, S) each, the former over pi, from the photo's light at any level, with shadows.
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
    """The part of a tint (1, 3, S, S), of mean 0, that black hair and cloth, lips and teeth don't have in the photo.

    It comes from an error of the light, so it is kept only under the photo's own light.
    """
    of_light = off_black(surface, tint)
    return of_light + too_blue(surface, tint - of_light)


def _tinted(albedo: torch.Tensor, tint: torch.Tensor) -> torch.Tensor:
    """An albedo (1, 3, S, S) changed by log ratios of mean 0, at its former brightness.

    Log ratios of mean 0 alone would only keep the product of the channels, and turn a dull red into a bright one.
    """
    return as_bright_as(albedo * torch.exp(tint), albedo)
