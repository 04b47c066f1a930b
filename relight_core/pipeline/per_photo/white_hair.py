"""White hair that de-lighting takes for a bald head.

Closely cropped or combed back, it follows the skull as skin does, and its albedo comes out pink. But white hair has the
colour of the light all over, a bald head only in its highlights.
"""

from __future__ import annotations

from dataclasses import replace

import torch

from relight_core.face.parsing import BROWS, EYES, INDEX, middle_row, with_neck_as
from relight_core.imaging.ramp import ramp
from relight_core.pipeline.per_photo.saturation import (
    PALER_THAN_SKIN,
    log_colours,
    middle_colour,
    recoloured,
    saturation,
)
from relight_core.pipeline.stages import Surface

_FEWEST_EYE_PIXELS = 4
"""Pixels of eyes and brows that are needed to know their row."""
_PERHAPS_GREY, _MOSTLY_GREY = -0.4, -0.6
"""Ramp of the saturation of the scalp's median colour, relative to the face's, over which it becomes hair."""


def eyes_row(parsing: torch.Tensor) -> float | None:
    """The mean row of the eyes and brows in a parsing (1, classes, S, S); None if none are seen."""
    return middle_row(parsing[0], (*EYES, *BROWS), _FEWEST_EYE_PIXELS)


def above_the_eyes(parsing: torch.Tensor) -> torch.Tensor | None:
    """(1, 1, S, 1), 1 in the rows above the mean row of the eyes and brows, else 0; None if none are seen."""
    eyes = eyes_row(parsing)
    rows = torch.arange(parsing.shape[2], device=parsing.device)
    return None if eyes is None else (rows < eyes).float()[None, None, :, None]


@torch.inference_mode()
def with_white_hair(surface: Surface) -> Surface:
    """The surface with hair where the parsing has a bare scalp that is mostly colourless in the photo.

    What becomes hair keeps its albedo's brightness. Its colour differs from the skin's albedo as it differs from the
    skin in the photo.
    """
    above, face = above_the_eyes(surface.parsing), surface.parsing[:, INDEX["skin"], None]
    if above is None:
        return surface
    scalp = surface.parsing[:, INDEX["neck"], None] * above
    seen, own = (middle_colour(image, face) for image in (surface.photo, surface.albedo))
    on_scalp = middle_colour(surface.photo, scalp)
    if seen is None or on_scalp is None:
        return surface
    mostly = ramp(saturation(on_scalp - seen, seen), _PERHAPS_GREY, _MOSTLY_GREY)
    if mostly == 0:
        return surface
    off = log_colours(surface.photo) - seen
    share = mostly * scalp * ramp(saturation(off, seen), *PALER_THAN_SKIN)
    albedo = recoloured(surface.albedo, own + off, share)
    return replace(surface, parsing=with_neck_as(surface.parsing, "hair", share), albedo=albedo)
