"""Closely cropped dark hair that de-lighting takes for a bald head in shade.

Such hair follows the skull as skin does, and its darkness is taken for shade: in a light from above or behind it would
become pale, shiny skin. But shaded skin has at least as much colour as lit skin, while hair has less; and hair is
darker than skin would be in the estimated light. If a scalp is greyer and darker on the whole, its pixels that are both
become hair. (For heads with other hair see `hair_on_scalp`, for white hair `white_hair`.)
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
"""Ramp of the evidence over which a scalp counts as cropped. The evidence is the median over the scalp of how much
darker it is than the face, in natural logs, plus how much greyer, as a share of the face's colour."""
_NO_GREYER, _GREYER = 0.08, 0.16
"""Ramp of greyness alone: what is dark but no greyer is skin in a shadow that the model doesn't know."""
_BARE, _HAIR = -0.05, 0.25
"""Ramp of the evidence at a pixel of such a scalp. It is lower, since hair seems less dark where the estimated light
lacks some."""
_SOFT_PX = 1.5
"""Standard deviation of the blur of evidence and result."""
_SIDEBURNS = 0.06
"""Share of the view's side, below the eyes, over which hair fades out."""
_LEAST_SHADING = 0.02
"""Smallest argument of the shading's logarithm."""


@torch.inference_mode()
def with_cropped_hair(surface: Surface) -> Surface:
    """The surface with hair where the parsing has bare scalp that is dark and has little colour in the photo."""
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
    """Luminance of the unoccluded irradiance over pi under the light that de-lighting predicts, (S, S)."""
    toward, area = (texels.to(surface.normal) for texels in network_texels())
    radiance = grey(surface.source_light.movedim(-1, 1)).flatten() * area
    normal = surface.normal[0].flatten(1).T
    return ((normal @ toward.T).clamp_min(0) @ radiance / torch.pi).reshape(surface.normal.shape[-2:])


def _scalp(parsing: torch.Tensor) -> torch.Tensor | None:
    """The probability of bare skin outside the face, above or beside the eyes, (S, S); None without eyes."""
    eyes = eyes_row(parsing)
    if eyes is None:
        return None
    size = parsing.shape[2]
    rows = torch.arange(size, device=parsing.device)
    return parsing[0, INDEX["neck"]] * ramp(rows, eyes + _SIDEBURNS * size, eyes)[:, None]


def _softened(image: torch.Tensor) -> torch.Tensor:
    return torch.from_numpy(cv2.GaussianBlur(image.cpu().numpy(), (0, 0), _SOFT_PX)).to(image)
