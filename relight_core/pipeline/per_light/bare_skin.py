"""Where the relief can be trusted with the details of a shadow."""

from __future__ import annotations

import torch
import torch.nn.functional as F

from relight_core.face.parsing import FACE_LABELS, INDEX, MOUTH
from relight_core.imaging.tensor_constants import constant

_MARGIN_PX = 5
_MOUTH = {INDEX[name] for name in MOUTH}
_SKIN = tuple(sorted({*FACE_LABELS, INDEX["neck"]} - _MOUTH))


def bare_skin(parsing: torch.Tensor) -> torch.Tensor:
    """(B, 1, H, W) in [0, 1]: well within the face and the neck, the mouth left out.

    Where a strand of hair, a collar or a tooth stands out, and by how much, the relief only guesses, pixel by pixel;
    its edges there would be notches.

    Args:
        parsing: (B, classes, H, W) probabilities.
    """
    share = parsing[:, constant(_SKIN, parsing.device, torch.int64)].sum(1, keepdim=True)
    near = F.avg_pool2d(share, _MARGIN_PX, stride=1, padding=_MARGIN_PX // 2, count_include_pad=False)
    return (2 * near - 1).clamp(0, 1)
