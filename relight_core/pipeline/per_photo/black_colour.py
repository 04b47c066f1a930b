"""Hair and cloth that a photo shows nearly black, and as good as without colour.

Blacks are lifted by glare in the lens and drawn in by a camera's curve and by JPEG, and take on little of the light's
colour. By the light that explains the skin they would have the opposite one: in a white light a black hat that was
photographed under a warm lamp would be navy blue.
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
        tint: (1, 3, S, S), log ratios of mean 0 by which the colour of the surface's albedo is off.

    Returns:
        Log ratios of mean 0, (1, 3, S, S).
    """
    # There is blue that is bright enough to tell and of next to no luminance.
    too_dark = ramp(surface.photo.amax(1, keepdim=True), *NO_COLOUR)
    black = likely(share_of(surface.parsing, ("hair", "hat", "cloth"))) * too_dark
    return black * (without_mean(logs(surface.albedo)) + tint - without_mean(logs(surface.photo)))
