"""The brims of hats, some of whose height gets lost in a relief.

A brim that is seen from the front is one pixel wide at the networks' size. Where it lies on one row of pixels it has
its full height; where it lies between two rows, they share it. So it looks like a row of teeth, and so would its shadow
on the forehead under any small lamp. Averaging pixels lowers it further, and rays slip between the pixels of a slanted
brim, so the shadow would be too short and have holes.
"""

from __future__ import annotations

import cv2
import numpy as np
import torch

from relight_core.face.parsing import INDEX
from relight_core.imaging.tensor_images import as_image, as_tensor
from relight_core.lighting.relief import NOTHING

_THIN = 0.04
"""Share of the view's side: a brim seen from the front is thinner than this, and is extended back over so many rows."""
_TOOTH = 0.26
"""Share of the view's side within which gaps along a brim are closed."""
_STANDS_OUT = 0.03
"""A brim stands out from the hat behind it by at least so many half-widths of the view."""
_MOST = 0.1
"""A brim may lack so many half-widths of the view; deeper gaps belong to the hat."""


def with_whole_brims(relief: torch.Tensor, parsing: torch.Tensor) -> torch.Tensor:
    """Heights (1, 1, S, S) in which brims have no gaps and reach back to their hats; nothing becomes lower.

    Between two points of a brim it is at least as high as the lower of them (a morphological closing), and the rows of
    the hat above it are raised to its height.

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
