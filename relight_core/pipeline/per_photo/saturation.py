"""How much more of its own colour a surface shows in a photo than it has.

Cameras balance the light's colour away, and their curves and their makers' taste make skin redder than its reflectance
is. To a portrait in another light that belongs as it does to the photo: without it skin is grey.
A change of colour along the surface's own is taken for the camera's; one that goes mostly across it is a coloured
light's.
"""

from __future__ import annotations

import torch

from relight_core.face.parsing import FEWEST_PIXELS, SURELY
from relight_core.imaging.tensor_colour import as_bright_as
from relight_core.imaging.tensor_logs import logs, without_mean

_GREY = 0.01
"""Squared length of a log colour that is too little of a colour to be followed."""
_ACROSS = 0.4
"""Of a change along a surface's own colour: curves compress red before green, and turn skin yellower on its way. Skin
that kept the change along its own colour alone would be redder than the photo has ever shown it."""
PALER_THAN_SKIN = (-0.25, -0.5)
"""Saturations beside a face's from which on a pixel's colour may be, and surely is, not that of skin."""


def log_colour(values: torch.Tensor) -> torch.Tensor:
    """Logarithms of linear colours (..., 3) without their mean: what is left when brightness is not asked for."""
    logarithm = values.clamp_min(1e-4).log()
    return logarithm - logarithm.mean(-1, keepdim=True)


def log_colours(image: torch.Tensor) -> torch.Tensor:
    """`log_colour` of an image (1, 3, S, S), linear, in which what is nearly black has next to none; (S, S, 3)."""
    return without_mean(logs(image))[0].movedim(0, -1)


def recoloured(albedo: torch.Tensor, colours: torch.Tensor, share: torch.Tensor) -> torch.Tensor:
    """An albedo (1, 3, S, S) that has a share (1, 1, S, S) of log colours (S, S, 3), as bright as it is."""
    bare = as_bright_as(torch.exp(colours).movedim(-1, 0)[None], albedo)
    return (albedo + share * (bare - albedo)).clamp(0, 1)


def saturation(change: torch.Tensor, own: torch.Tensor) -> torch.Tensor:
    """How far changes of log colour (..., 3) go along a surface's own (3,), (...): 0.2 is a fifth more of it."""
    return change @ own / (own @ own + _GREY)


def of_camera(change: torch.Tensor, own: torch.Tensor, saturated: torch.Tensor) -> torch.Tensor:
    """The part of changes of log colour (..., 3) that is a camera's doing and not a light's.

    Args:
        own: (3,) log colour of the surface.
        saturated: (...) by how much of its own colour a camera saturates it, >= 0; see `saturation`.
    """
    added = saturated[..., None] * own
    across = change - saturation(change, own)[..., None] * own
    length = across.norm(dim=-1, keepdim=True).clamp_min(1e-6)
    return added + across * (_ACROSS * added.norm(dim=-1, keepdim=True) / length).clamp_max(1)


def middle_colour(image: torch.Tensor, part: torch.Tensor, fewest: int = FEWEST_PIXELS) -> torch.Tensor | None:
    """The median log colour (3,) of a part of an image, or None where fewer than `fewest` pixels surely belong to it.

    Args:
        image: (1, 3, S, S) linear.
        part: (1, 1, S, S) probability.
    """
    sure = part[0, 0] > SURELY
    if int(sure.sum()) < fewest:
        return None
    middle = log_colours(image)[sure].median(0).values
    return middle - middle.mean()
