"""White collars that de-lighting takes for a neck.

A collar that lies close to the neck is parsed as neck, and its albedo comes out pink; if it is blown out, it would get
the colour of the skin around. But no neck is brighter than the lit side of its face and also colourless, except for the
rim of a light from behind. Such a rim may run along the jaw, while a collar extends away from the face.
"""

from __future__ import annotations

import cv2
import numpy as np
import torch

from relight_core.face.parsing import INDEX, MOUTH, SURELY, middle_row, with_neck_as
from relight_core.imaging.masks import distance_to
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_colour import grey
from relight_core.pipeline.per_photo.saturation import (
    PALER_THAN_SKIN,
    log_colours,
    middle_colour,
    recoloured,
    saturation,
)

_FEWEST_MOUTH_PIXELS = 4
"""Pixels of the mouth that are needed to know its row."""
_BRIGHTEST_SKIN = 0.95
"""Quantile of a face's brightness that stands for its lit side."""
_BRIGHTER = 1.3
"""From so many times that brightness on, a pixel surely is a collar."""
_SMALLEST_COLLAR, _SURE_COLLAR = 4, 12
"""Ramp of the number of bright pixels in a neck over which they become enough for a collar."""
_BRIGHT, _NECK = 0.05, (0.2, 0.4)
"""A pixel counts in full if it exceeds the brightness of the face's lit side by this share; and the ramp of its
probability of neck over which it counts."""
_COLOURED, _GREY = -0.6, -0.8
"""Ramp of saturation relative to a face's (see `saturation`) over which a pixel becomes colourless."""
_PERHAPS_MOST, _MOST = 0.45, 0.6
"""Ramp of the colourless share of bright pixels over which they become a collar."""
_LIKELY = 0.3
"""A pixel with a larger share belongs to a patch that may be a rim."""
_ALONG_THE_JAW = 3.6 / 128
"""As a share of the view's side: at least half of a rim lies within this distance of the face."""


@torch.inference_mode()
def with_white_collar(
    photo: torch.Tensor, albedo: torch.Tensor, parsing: torch.Tensor
) -> tuple[torch.Tensor, torch.Tensor]:
    """Albedo and parsing with cloth where the neck below the mouth is brighter than the face and colourless.

    What becomes cloth keeps its albedo's brightness. Its colour differs from the skin's albedo as it differs from the
    skin in the photo. Skin that is blown out turns yellow before white, so nothing is changed if most of what is bright
    has a colour.

    Args:
        photo: (1, 3, S, S) linear, [0, 1].
        albedo: (1, 3, S, S) linear.
        parsing: (1, classes, S, S) probabilities.
    """
    mouth, face = middle_row(parsing[0], MOUTH, _FEWEST_MOUTH_PIXELS), parsing[:, INDEX["skin"], None]
    seen, own = (middle_colour(image, face) for image in (photo, albedo))
    if mouth is None or seen is None or own is None:
        return albedo, parsing
    below = torch.arange(photo.shape[2], device=photo.device)[:, None] > mouth
    neck, brightness = parsing[:, INDEX["neck"], None] * below, grey(photo)
    brighter = brightness / brightness[face > SURELY].quantile(_BRIGHTEST_SKIN).clamp_min(1e-3) - 1
    off = log_colours(photo) - seen
    colour = saturation(off, seen)[None, None]
    surely = _mostly_grey(colour, ramp(neck, *_NECK) * ramp(brighter, 0, _BRIGHT))
    if surely == 0:
        return albedo, parsing
    share = surely * neck * ramp(brighter, 0, _BRIGHTER - 1) * ramp(colour, *PALER_THAN_SKIN)
    share = share * ~_rims(share, face)
    return recoloured(albedo, own + off, share), with_neck_as(parsing, "cloth", share)


def _mostly_grey(colour: torch.Tensor, bright: torch.Tensor) -> float:
    """Certainty that most of what is bright, (1, 1, S, S) in [0, 1], is colourless relative to skin, [0, 1].

    It uses soft counts, since a median would jump from the collar to the skin beside it with a slight change of tint.

    Args:
        colour: (1, 1, S, S) saturation relative to the face's.
        bright: the degree to which each pixel is bright and neck.
    """
    pixels = bright.sum()
    grey_share = (bright * ramp(colour, _COLOURED, _GREY)).sum() / pixels.clamp_min(1e-6)
    return float(ramp(grey_share, _PERHAPS_MOST, _MOST) * ramp(pixels, _SMALLEST_COLLAR, _SURE_COLLAR))


def _rims(share: torch.Tensor, face: torch.Tensor) -> torch.Tensor:
    """Those patches of a possible collar (1, 1, S, S) that follow the face's edge, (1, 1, S, S) bool."""
    likely = (share[0, 0] > _LIKELY).cpu().numpy().astype(np.uint8)
    distance = distance_to((face[0, 0] > 0.5).cpu().numpy())
    count, patches = cv2.connectedComponents(likely, connectivity=4)
    near = [np.median(distance[patches == number]) < _ALONG_THE_JAW * len(likely) for number in range(1, count)]
    rims = np.array([False, *near])[patches].astype(np.uint8)
    rims = cv2.dilate(rims, np.ones((3, 3), np.uint8)) > np.where(rims, 0, likely)
    return torch.from_numpy(rims)[None, None].to(share.device)
