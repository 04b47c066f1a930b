"""The brims of hats, of which a relief loses some of the height.

A brim that is looked at from the front is a pixel wide at the networks' size. Where it lies between two rows, its
height is shared between them; where it lies on one, it is not. So it comes out as a row of teeth, and so would its
shadow on the forehead under any small lamp. Whoever averages pixels, or passes between them as rays do where a brim
slants, finds it lower still, and its shadow would be short and have holes.
"""

from __future__ import annotations

import cv2
import numpy as np
import torch

from relight_core.face.parsing import INDEX
from relight_core.imaging.tensor_images import as_image, as_tensor
from relight_core.lighting.relief import NOTHING

_THIN = 0.04
"""Share of the view's side: a brim that is looked at from the front lies in fewer rows, and reaches back over them."""
_TOOTH = 0.26
"""Share of the view's side that is looked along a brim for what is higher."""
_STANDS_OUT = 0.03
"""Half-widths of the view by which a brim at least stands out of the hat behind it."""
_MOST = 0.1
"""Half-widths of the view that a brim may be missing; deeper gaps are a hat's own."""


def with_whole_brims(relief: torch.Tensor, parsing: torch.Tensor) -> torch.Tensor:
    """Heights (1, 1, S, S) with brims without teeth that reach back to their hats; nothing becomes lower.

    Between two places of a brim it is as high as at the lower one, and the rows of the hat above it are as high as it.

    Args:
        relief: in half-widths of the view, of a head that stands upright in it.
        parsing: (1, classes, S, S) probabilities.
    """
    height, hat = as_image(relief), as_image(parsing[:, INDEX["hat"], None]) > 0.5
    thin_px, tooth_px = (max(round(share * len(height)), 1) | 1 for share in (_THIN, _TOOTH))
    rows, along = np.ones((thin_px, 1), np.uint8), np.ones((1, tooth_px), np.uint8)
    lowest = cv2.erode(np.where(hat, height, np.float32(-NOTHING)), rows)
    behind, highest = (cv2.dilate(np.where(hat, plane, np.float32(NOTHING)), rows) for plane in (lowest, height))
    missing = np.clip(cv2.morphologyEx(highest, cv2.MORPH_CLOSE, along) - highest, 0, _MOST)
    brim = np.where(hat & (height - behind > _STANDS_OUT), height + missing, np.float32(NOTHING))
    back = cv2.dilate(brim, np.ones((thin_px, 3), np.uint8), anchor=(1, 0))
    return as_tensor(np.where(hat, np.maximum(height, back), height), relief.device)
