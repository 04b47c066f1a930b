"""Dark hair, cropped so close that de-lighting takes it for a bald head.

Such hair lies on the skull as skin does, and what is dark about it passes for shade: in a light from above or behind it
turned into pale skin that shines. But shade is as colourful as skin is, or more, and hair is not; and hair is darker
than skin would be in the light that the networks saw the photo in. A scalp that is both, on the whole, has hair on it
wherever it is both. (Where a head has other hair: see `hair_on_scalp`; white hair: see `white_hair`.)
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import torch

from relight_core.face.parsing import FEWEST_OF_SKIN, INDEX, SURELY, with_neck_as
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_colour import grey
from relight_core.imaging.tensor_logs import logs
from relight_core.lighting.reflection import network_texels
from relight_core.pipeline.per_photo.saturation import log_colours, middle_colour, saturation
from relight_core.pipeline.per_photo.white_hair import eyes_row
from relight_core.pipeline.stages import Surface

_PERHAPS_CROPPED, _CROPPED = 0.35, 0.6
"""By how much of a natural logarithm the middle of a scalp is darker than the face, and by how much of the face's own
colour it is greyer, both together, from which on it has hair, in part and altogether."""
_NO_GREYER, _GREYER = 0.08, 0.16
"""The latter alone: what is dark and no greyer is skin in a shadow that nothing has told of."""
_BARE, _HAIR = -0.05, 0.25
"""The same about a pixel of such a scalp. Where the guess lacks light, hair is less dark than it would be."""
_SOFT_PX = 1.5
_SIDEBURNS = 0.06
"""How far below the eyes hair fades out, as a share of the view."""
_LEAST_SHADING = 0.02


@torch.inference_mode()
def with_cropped_hair(surface: Surface) -> Surface:
    """The surface with hair where the scalp is bare, by its parsing, and dark and of little colour in the photo."""
    scalp, face = _scalp(surface.parsing), surface.parsing[0, INDEX["skin"]]
    own = middle_colour(surface.photo, face[None, None], FEWEST_OF_SKIN)
    if scalp is None or own is None or int((scalp > SURELY).sum()) < FEWEST_OF_SKIN:
        return surface
    greyer = -saturation(log_colours(surface.photo) - own, own)
    grey_enough = ramp(float(greyer[scalp > SURELY].median()), _NO_GREYER, _GREYER)
    if grey_enough == 0:
        return surface
    darkness = shading(surface).clamp_min(_LEAST_SHADING).log() - logs(grey(surface.photo)[0, 0])
    evidence = greyer + darkness - darkness[face > SURELY].median()
    cropped = grey_enough * ramp(float(evidence[scalp > SURELY].median()), _PERHAPS_CROPPED, _CROPPED)
    if cropped == 0:
        return surface
    share = _softened(cropped * scalp * ramp(_softened(evidence), _BARE, _HAIR))
    share = torch.minimum(share, surface.parsing[0, INDEX["neck"]])
    return replace(surface, parsing=with_neck_as(surface.parsing, "hair", share[None, None]))


def shading(surface: Surface) -> torch.Tensor:
    """(S, S) grey irradiance over pi of the light that de-lighting guessed, on a surface that nothing hides from it."""
    toward, area = (texels.to(surface.normal) for texels in network_texels())
    radiance = grey(surface.source_light.movedim(-1, 1)).flatten() * area
    normal = surface.normal[0].flatten(1).T
    return ((normal @ toward.T).clamp_min(0) @ radiance / torch.pi).reshape(surface.normal.shape[-2:])


def _scalp(parsing: torch.Tensor) -> torch.Tensor | None:
    """(S, S) probability of bare skin outside the face that lies above the eyes, or beside them; None without eyes."""
    eyes = eyes_row(parsing)
    if eyes is None:
        return None
    size = parsing.shape[2]
    rows = torch.arange(size, device=parsing.device)
    return parsing[0, INDEX["neck"]] * ramp(rows, eyes + _SIDEBURNS * size, eyes)[:, None]


def _softened(image: torch.Tensor) -> torch.Tensor:
    return torch.from_numpy(cv2.GaussianBlur(image.cpu().numpy(), (0, 0), _SOFT_PX)).to(image)
