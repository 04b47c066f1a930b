"""Saturation that a camera adds to a surface's own colour.

Cameras balance the light's colour, and their tone curves and colour rendering make skin redder than its reflectance.
A portrait needs this in any other light too, or skin looks grey. A change of colour in the direction of the surface's
own colour is attributed to the camera; one that is mostly perpendicular to it, to a coloured light.

A *log colour* is the logarithm of a linear colour minus its mean over the channels; its direction is the hue, and its
length the saturation.
"""

from __future__ import annotations

import torch

from relight_core.face.parsing import FEWEST_PIXELS, SURELY
from relight_core.imaging.tensor_colour import as_bright_as
from relight_core.imaging.tensor_logs import logs, without_mean

_GREY = 0.01
"""Added to the squared length of a log colour: near grey there is no direction to follow."""
_ACROSS = 0.4
"""Largest perpendicular change that is attributed to the camera, as a share of the change along the surface's own
colour. Tone curves compress red before green, so that skin also becomes yellower. Without that part it would be redder
than the photo ever showed it."""
PALER_THAN_SKIN = (-0.25, -0.5)
"""Ramp of saturation relative to a face's over which a pixel's colour ceases to be that of skin."""


def log_colour(values: torch.Tensor) -> torch.Tensor:
    """Log colours of linear colours (..., 3)."""
    logarithm = values.clamp_min(1e-4).log()
    return logarithm - logarithm.mean(-1, keepdim=True)


def log_colours(image: torch.Tensor) -> torch.Tensor:
    """Log colours (S, S, 3) of a linear image (1, 3, S, S), in which what is nearly black is nearly grey."""
    return without_mean(logs(image))[0].movedim(0, -1)


def recoloured(albedo: torch.Tensor, colours: torch.Tensor, share: torch.Tensor) -> torch.Tensor:
    """An albedo (1, 3, S, S) mixed by a share (1, 1, S, S) with log colours (S, S, 3) of the same brightness."""
    bare = as_bright_as(torch.exp(colours).movedim(-1, 0)[None], albedo)
    return (albedo + share * (bare - albedo)).clamp(0, 1)


def saturation(change: torch.Tensor, own: torch.Tensor) -> torch.Tensor:
    """The component of changes of log colour (..., 3) along a surface's own (3,), (...): 0.2 is a fifth more of it."""
    return change @ own / (own @ own + _GREY)


def of_camera(change: torch.Tensor, own: torch.Tensor, saturated: torch.Tensor) -> torch.Tensor:
    """The part of changes of log colour (..., 3) that is attributed to a camera and not to a light.

    Args:
        change: the changes.
        own: (3,) log colour of the surface.
        saturated: (...) >= 0, the saturation that is attributed to the camera, see `saturation`.
    """
    added = saturated[..., None] * own
    across = change - saturation(change, own)[..., None] * own
    length = across.norm(dim=-1, keepdim=True).clamp_min(1e-6)
    return added + across * (_ACROSS * added.norm(dim=-1, keepdim=True) / length).clamp_max(1)


def middle_colour(image: torch.Tensor, part: torch.Tensor, fewest: int = FEWEST_PIXELS) -> torch.Tensor | None:
    """The median log colour (3,) of a part of an image; None if fewer than `fewest` pixels surely belong to it.

    Args:
        image: (1, 3, S, S) linear.
        part: (1, 1, S, S) probability.
    """
    sure = part[0, 0] > SURELY
    if int(sure.sum()) < fewest:
        return None
    middle = log_colours(image)[sure].median(0).values
    return middle - middle.mean()
