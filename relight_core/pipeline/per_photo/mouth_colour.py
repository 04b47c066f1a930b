"""Lips and teeth that would get a bluer albedo than they have.

A tan, a filter or make-up may make skin warmer than the rest of the photo. Then the light is estimated as too warm, and
what is less warm as too blue: in a white light teeth would be blue and lips purple. Lipstick may have any colour, but
then the photo shows it; so mouths get no bluer than in the photo.
"""

from __future__ import annotations

import torch

from relight_core.face.parsing import MOUTH, likely, share_of
from relight_core.imaging.tensor_logs import logs
from relight_core.pipeline.stages import Surface

_BLUEST = 0.1
"""Log ratio of blue to green that mouths may always have: in 144 portraits, under their estimated lights, five of six
pairs of lips have less."""


def too_blue(surface: Surface, tint: torch.Tensor) -> torch.Tensor:
    """The part of a tint that makes a mouth bluer than in the photo and than mouths are, (1, 3, S, S) of mean 0.

    Args:
        surface: of the photo.
        tint: (1, 3, S, S), log ratios that correct the colour of the surface's albedo.
    """
    mouth = likely(share_of(surface.parsing, MOUTH))
    shown, meant = _bluish(surface.photo), _bluish(surface.albedo) + tint[:, 2:] - tint[:, 1:2]
    excess = mouth * (meant - shown.clamp_min(_BLUEST)).clamp_min(0)
    excess = torch.minimum(excess, (tint[:, 2:] - tint[:, 1:2]).clamp_min(0))
    return torch.cat([-excess, -excess, 2 * excess], 1) / 3


def _bluish(image: torch.Tensor) -> torch.Tensor:
    """The log ratio of blue to green, (1, 1, S, S)."""
    return logs(image[:, 2:]) - logs(image[:, 1:2])
