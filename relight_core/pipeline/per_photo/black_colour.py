"""Nearly black hair and cloth, which keep the colour in which the photo shows them.

Glare in the lens lifts blacks, a camera's curve and JPEG lower them, and they take on little of the light's colour. If
the light that explains the skin were divided out of them, they would get the opposite colour: a black hat that was
photographed under a warm lamp would be navy blue in a white light.
"""

from __future__ import annotations

import torch

from relight_core.face.parsing import likely, share_of
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_logs import logs, without_mean
from relight_core.pipeline.per_photo.skin_colour import NO_COLOUR
from relight_core.pipeline.stages import Surface


def off_black(surface: Surface, tint: torch.Tensor) -> torch.Tensor:
    """The part of a tint by which black hair and cloth would differ in colour from what the photo shows.

    Args:
        surface: of the photo.
        tint: (1, 3, S, S), log ratios of mean 0 that correct the colour of the surface's albedo.

    Returns:
        Log ratios of mean 0, (1, 3, S, S).
    """
    # By the brightest channel: a blue may be bright enough to have a colour, but have next to no luminance.
    too_dark = ramp(surface.photo.amax(1, keepdim=True), *NO_COLOUR)
    black = likely(share_of(surface.parsing, ("hair", "hat", "cloth"))) * too_dark
    return black * (without_mean(logs(surface.albedo)) + tint - without_mean(logs(surface.photo)))
