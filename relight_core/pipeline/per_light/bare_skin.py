"""Where the relief is accurate enough for sharp shadow edges: on bare skin, away from its borders."""

from __future__ import annotations

import torch
import torch.nn.functional as F

from relight_core.face.parsing import FACE_LABELS, INDEX, MOUTH
from relight_core.imaging.tensor_constants import constant

_MARGIN_PX = 5
"""Side of the window whose mean share of skin tells how far within the skin a pixel lies."""
_MOUTH = {INDEX[name] for name in MOUTH}
_SKIN = tuple(sorted({*FACE_LABELS, INDEX["neck"]} - _MOUTH))


def bare_skin(parsing: torch.Tensor) -> torch.Tensor:
    """(B, 1, H, W) in [0, 1]: 1 well within the face and the neck, without the mouth.

    Elsewhere the relief only guesses, pixel by pixel, how far a strand of hair, a collar or a tooth stands out. Sharp
    shadow edges there would be jagged.

    Args:
        parsing: (B, classes, H, W) probabilities.
    """
    share = parsing[:, constant(_SKIN, parsing.device, torch.int64)].sum(1, keepdim=True)
    near = F.avg_pool2d(share, _MARGIN_PX, stride=1, padding=_MARGIN_PX // 2, count_include_pad=False)
    return (2 * near - 1).clamp(0, 1)
