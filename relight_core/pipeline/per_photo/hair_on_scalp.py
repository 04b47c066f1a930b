"""Hair that de-lighting takes for a bald head, by its colours.

Smooth dark hair on the side of a head is now and then parsed as scalp, gets the albedo of skin, and shines like it
under any light from there. Where the same head has hair that is known for such, and its colours are there and not
those of the face, it is hair. A bald head in shadow has the colours of neither. (White hair: see `white_hair`.)
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import torch

from relight_core.face.parsing import INDEX, with_neck_as
from relight_core.imaging.colour import srgb_encode
from relight_core.imaging.colour_counts import bins_of, log_odds, shares_of
from relight_core.imaging.ramp import ramp
from relight_core.pipeline.per_photo.white_hair import above_the_eyes
from relight_core.pipeline.stages import Surface

_SURE_FROM = 0.7
_FEWEST_PIXELS = 30
_AROUND_PX = 3
_PERHAPS_HAIR, _HAIR = 1.5, 3.0
"""Log odds of the colours about a pixel, hair to skin, from which on it is hair, in part and altogether."""


@torch.inference_mode()
def with_hair_on_scalp(surface: Surface) -> Surface:
    """The surface with hair where its parsing has bare scalp above the eyes, in the colours of hair."""
    above = above_the_eyes(surface.parsing)
    if above is None:
        return surface
    hair, skin = (_sure(surface.parsing[0, label]) for label in (INDEX["hair"], INDEX["skin"]))
    if min(hair.sum(), skin.sum()) < _FEWEST_PIXELS:
        return surface
    bins = bins_of(srgb_encode(surface.photo[0].movedim(0, -1).float().cpu().numpy()))
    told = log_odds(bins, shares_of(bins, hair), shares_of(bins, skin)).astype(np.float32)
    told = cv2.blur(told, (_AROUND_PX, _AROUND_PX))
    likely = torch.from_numpy(ramp(told, _PERHAPS_HAIR, _HAIR)).to(surface.parsing)
    share = surface.parsing[:, INDEX["neck"], None] * above * likely
    return replace(surface, parsing=with_neck_as(surface.parsing, "hair", share))


def _sure(probability: torch.Tensor) -> np.ndarray:
    return ramp(probability.float(), _SURE_FROM, 1).cpu().numpy()
