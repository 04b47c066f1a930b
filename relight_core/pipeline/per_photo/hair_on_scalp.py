"""Smooth dark hair that de-lighting takes for scalp, recognised by its colours.

Smooth dark hair on the side of a head is sometimes parsed as scalp. It then gets the albedo of skin, and shines like
skin under a light from that side. If the head has other hair that is parsed as hair, then scalp with the colours of
that hair and not of the face is hair too. A bald head in shadow has the colours of neither. (For white hair see
`white_hair`.)
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
"""Probability from which on pixels of hair and skin are used to learn their colours."""
_FEWEST_PIXELS = 30
"""Least sum of their weights, for each."""
_AROUND_PX = 3
"""Side of the window over which log odds are averaged."""
_PERHAPS_HAIR, _HAIR = 1.5, 3.0
"""Ramp of the log odds of hair over skin, by colour, over which a pixel becomes hair."""


@torch.inference_mode()
def with_hair_on_scalp(surface: Surface) -> Surface:
    """The surface with hair where the parsing has bare scalp above the eyes in the colours of the head's hair."""
    above = above_the_eyes(surface.parsing)
    if above is None:
        return surface
    hair, skin = (_sure(surface.parsing[0, label]) for label in (INDEX["hair"], INDEX["skin"]))
    if min(hair.sum(), skin.sum()) < _FEWEST_PIXELS:
        return surface
    bins = bins_of(srgb_encode(surface.photo[0].movedim(0, -1).float().cpu().numpy()))
    hair_odds = log_odds(bins, shares_of(bins, hair), shares_of(bins, skin)).astype(np.float32)
    hair_odds = cv2.blur(hair_odds, (_AROUND_PX, _AROUND_PX))
    likely = torch.from_numpy(ramp(hair_odds, _PERHAPS_HAIR, _HAIR)).to(surface.parsing)
    share = surface.parsing[:, INDEX["neck"], None] * above * likely
    return replace(surface, parsing=with_neck_as(surface.parsing, "hair", share))


def _sure(probability: torch.Tensor) -> np.ndarray:
    """The weight of pixels for learning a colour, by their probability (S, S)."""
    return ramp(probability.float(), _SURE_FROM, 1).cpu().numpy()
