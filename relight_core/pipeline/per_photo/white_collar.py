"""White collars that de-lighting takes for a neck.

Where a collar lies close, the parsing says neck and the albedo comes out pink, and blown out it would get the colour
of the skin around it. But no neck is both brighter than the lit side of its face and of no colour, except where a
light from behind draws a rim on it. Along the jaw that could pass for a collar, but a collar leaves the face.
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
_BRIGHTEST_SKIN = 0.95
"""Quantile of a face's brightness that stands for its lit side."""
_BRIGHTER = 1.3
"""How many times as bright as that a collar surely is."""
_SMALLEST_COLLAR, _SURE_COLLAR = 4, 12
"""Bright pixels of a neck from which on they may be a collar, and are enough for one."""
_BRIGHT, _NECK = 0.05, (0.2, 0.4)
"""By how much pixels must be brighter than the face's lit side, and how likely they must be neck, to count in full."""
_COLOURED, _GREY = -0.6, -0.8
"""Saturations beside a face's (see `saturation`): up from the first a pixel has a colour, down from the second none."""
_PERHAPS_MOST, _MOST = 0.45, 0.6
"""Shares of what is bright that are of no colour, from which on it is a collar, in part and altogether."""
_LIKELY = 0.3
"""The share from which on a pixel belongs to a patch that may be a rim."""
_ALONG_THE_JAW = 3.6 / 128
"""Of the view: a rim lies within this of the face for the most part."""


@torch.inference_mode()
def with_white_collar(
    photo: torch.Tensor, albedo: torch.Tensor, parsing: torch.Tensor
) -> tuple[torch.Tensor, torch.Tensor]:
    """Albedo and parsing with cloth where the neck below the mouth is brighter than the face and of no colour.

    What becomes cloth keeps its brightness and gets the colour it has beside the skin's, as skin has its albedo's.
    Skin that is blown out passes through yellow before it is white: where most of what is bright has a colour, all
    is left as it is.

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
    """How surely most of what is bright, (1, 1, S, S) in [0, 1], is of no colour beside the skin's, [0, 1].

    Counted little by little: a median would leap from the collar to the skin beside it with a hint of another tint.
    """
    pixels = bright.sum()
    grey_share = (bright * ramp(colour, _COLOURED, _GREY)).sum() / pixels.clamp_min(1e-6)
    return float(ramp(grey_share, _PERHAPS_MOST, _MOST) * ramp(pixels, _SMALLEST_COLLAR, _SURE_COLLAR))


def _rims(share: torch.Tensor, face: torch.Tensor) -> torch.Tensor:
    """(1, 1, S, S) bool, the patches of what could be a collar (1, 1, S, S) that keep to the face's edge."""
    likely = (share[0, 0] > _LIKELY).cpu().numpy().astype(np.uint8)
    distance = distance_to((face[0, 0] > 0.5).cpu().numpy())
    count, patches = cv2.connectedComponents(likely, connectivity=4)
    near = [np.median(distance[patches == number]) < _ALONG_THE_JAW * len(likely) for number in range(1, count)]
    rims = np.array([False, *near])[patches].astype(np.uint8)
    rims = cv2.dilate(rims, np.ones((3, 3), np.uint8)) > np.where(rims, 0, likely)
    return torch.from_numpy(rims)[None, None].to(share.device)
