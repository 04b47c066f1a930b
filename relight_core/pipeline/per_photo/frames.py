"""The frames of glasses, which a relief takes for walls.

A frame is a wire or a bar that light passes on both sides; a relief has no back, and so what stands out of it
hides all that lies beside it. Rims would shade the whole of their glass, and eyes stay dark in the light of any lamp
beside the face. The thin shadows that frames do cast are the SS network's to draw.
"""

from __future__ import annotations

import cv2
import numpy as np
import torch

from relight_core.face.parsing import INDEX
from relight_core.imaging.tensor_images import as_image, as_tensor

_THIN = 0.04
"""Of the view's side: frames are narrower, and dark glasses, which do hide what is behind them, are wider."""


def without_frames(relief: torch.Tensor, parsing: torch.Tensor) -> torch.Tensor:
    """Heights (1, 1, S, S) with the frames of glasses level with what is around them.

    Args:
        parsing: (1, classes, S, S) probabilities.
    """
    side_px = max(round(_THIN * relief.shape[-1]), 1) | 1
    window = np.ones((side_px, side_px), np.uint8)
    height, glasses = as_image(relief), as_image(parsing[:, INDEX["glasses"], None])
    around, wide = (cv2.morphologyEx(plane, cv2.MORPH_OPEN, window) for plane in (height, glasses))
    height = height + cv2.dilate(glasses - wide, window) * (around - height)
    return as_tensor(height, relief.device)
