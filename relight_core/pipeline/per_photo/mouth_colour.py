"""Lips and teeth that look bluer than they are and than the photo shows them.

A photo's skin may have been made warmer than the rest of it, by a tan, a filter or make-up. Its light then passes
for a warm one, and what is not as warm for something blue: in a white light teeth would be blue and lips purple.
Lipstick may be of any colour, but a photo shows it.
"""

from __future__ import annotations

import torch

from relight_core.face.parsing import MOUTH, likely, share_of
from relight_core.imaging.tensor_logs import logs
from relight_core.pipeline.stages import Surface

_BLUEST = 0.1
"""Log ratio of blue to green: of 144 portraits, by their estimated lights, five pairs of lips of six have less."""


def too_blue(surface: Surface, tint: torch.Tensor) -> torch.Tensor:
    """The part of a tint that makes a mouth bluer than the photo shows it and than mouths are, (1, 3, S, S), mean 0.

    Args:
        tint: (1, 3, S, S), log ratios by which the colour of the surface's albedo is off.
    """
    mouth = likely(share_of(surface.parsing, MOUTH))
    shown, meant = _bluish(surface.photo), _bluish(surface.albedo) + tint[:, 2:] - tint[:, 1:2]
    excess = mouth * (meant - shown.clamp_min(_BLUEST)).clamp_min(0)
    excess = torch.minimum(excess, (tint[:, 2:] - tint[:, 1:2]).clamp_min(0))
    return torch.cat([-excess, -excess, 2 * excess], 1) / 3


def _bluish(image: torch.Tensor) -> torch.Tensor:
    """(1, 1, S, S) the log ratio of blue to green."""
    return logs(image[:, 2:]) - logs(image[:, 1:2])
