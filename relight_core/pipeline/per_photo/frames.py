"""The frames of glasses, which would occlude like walls in a relief.

A frame is a wire or a bar around which light passes. But a relief has no back: whatever stands out of it hides
everything behind. So rims would shade their whole glass, and eyes would stay dark under any lamp beside the face. The
thin shadows that frames really cast are left to the SS network.
"""

from __future__ import annotations

import cv2
import numpy as np
import torch

from relight_core.face.parsing import INDEX
from relight_core.imaging.tensor_images import as_image, as_tensor

_THIN = 0.04
"""As a share of the view's side: frames are narrower, and dark glasses, which do hide what is behind them, wider."""


def without_frames(relief: torch.Tensor, parsing: torch.Tensor) -> torch.Tensor:
    """Heights (1, 1, S, S) in which the frames of glasses are level with their surroundings.

    Args:
        parsing: (1, classes, S, S) probabilities.
    """
    side_px = max(round(_THIN * relief.shape[-1]), 1) | 1
    window = np.ones((side_px, side_px), np.uint8)
    height, glasses = as_image(relief), as_image(parsing[:, INDEX["glasses"], None])
    around, wide = (cv2.morphologyEx(plane, cv2.MORPH_OPEN, window) for plane in (height, glasses))
    height = height + cv2.dilate(glasses - wide, window) * (around - height)
    return as_tensor(height, relief.device)
