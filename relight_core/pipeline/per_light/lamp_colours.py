"""Colours on a face that lamps have given it which the model of its photo doesn't know.

Between two neon lamps a face is pink on one side and teal on the other, and the estimated light explains a part of
that. What is left would stay on the skin in any light, as paint does. So where the photo's light, as far as it is
known, has several colours already, a colour that more than a mole shares on skin and that flush and tan don't explain
is a lamp's. In a light of one colour it may be paint or rouge.

A hat, a wall or leaves throw shadows that the model doesn't know either, and what lights skin in those is the sky. So
where much of the skin lies in such shadows, the colour that they have beside the rest of it is theirs.
"""

from __future__ import annotations

import torch

from relight_core.face.parsing import BROWS, EYES, FEWEST_PIXELS, MOUTH, SURELY, share_of
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_logs import log_ratios, without_mean
from relight_core.imaging.tensor_means import local_means, local_medians, middle_values
from relight_core.pipeline.stages import Surface

MOLE = 0.02
"""Of the view's side: what is off no farther on skin is likely its own, and what is off farther a shadow or gloss."""
_FLUSH = (0.1, 0.2)
"""Logs of a colour, by how much flush and tan move it, and what is surely more."""
_SEVERAL_COLOURS = (0.4, 0.8)
"""How far apart the logs of a light's colour are over most of the skin, where it may have several and surely has."""
_AMID_SKIN = (*BROWS, *EYES, *MOUTH)
"""What such lamps light as they do the skin around."""


def colours_of_lamps(
    surface: Surface, plain: torch.Tensor, colour: torch.Tensor, skin: torch.Tensor, known: torch.Tensor
) -> torch.Tensor:
    """(1, 3, S, S) the part of a colour that lamps have given a face, of mean 0 over the channels.

    Args:
        plain: (1, 3, S, S) the model's explicit sum under the photo's own light.
        colour: (1, 3, S, S) logs of photo over model, of mean 0.
        skin: (1, 1, S, S) probability of bare skin.
        known: (1, 1, S, S) the same where the photo shows it.
    """
    sure = (known > SURELY)[0, 0]
    several = _several_colours(surface, plain, sure) if int(sure.sum()) >= FEWEST_PIXELS else 0.0
    if several == 0:
        return torch.zeros_like(colour)
    off = without_mean(local_medians(colour - middle_values(colour, sure), skin, MOLE))
    off = several * off * ramp(off.abs().amax(1, keepdim=True), *_FLUSH)
    return _on_face(surface, off, skin)


def colours_of_shade(
    surface: Surface, missed: torch.Tensor, colour: torch.Tensor, skin: torch.Tensor, known: torch.Tensor
) -> torch.Tensor:
    """(1, 3, S, S) log colours, of mean 0, that a face has in shadows which the model missed, in much of its skin.

    They are in proportion to how deep a shadow is, and 0 where skin is as bright as the brighter part of it is.

    Args:
        missed: (1, 1, S, S) logs of brightness that the model missed, of which not all known skin has the same.
        colour, skin, known: as of `colours_of_lamps`; some skin is known.
    """
    sure = (known > SURELY)[0, 0]
    depths, colours = missed[0, 0][sure], colour[0][:, sure]
    lit = depths > depths.mean()
    brightest = depths[lit].mean()
    darkest = depths[~lit].mean()
    bluer = colours[:, ~lit].median(1).values - colours[:, lit].median(1).values
    share = ((brightest - missed) / (brightest - darkest)).clamp_min(0)
    return _on_face(surface, without_mean(bluer[None, :, None, None]) * share, skin)


def _on_face(surface: Surface, off: torch.Tensor, skin: torch.Tensor) -> torch.Tensor:
    """What is off in colour on skin, and as much of it amid skin as around."""
    return skin * off + share_of(surface.parsing, _AMID_SKIN) * local_means(off, skin)


def _several_colours(surface: Surface, plain: torch.Tensor, sure: torch.Tensor) -> float:
    """How surely the light on the skin (S, S) is of several colours, [0, 1]."""
    light = without_mean(log_ratios(plain.float(), surface.albedo))[0][:, sure]
    least, most = torch.quantile(light, light.new_tensor([0.1, 0.9]), dim=1)
    return ramp(float((most - least).max()), *_SEVERAL_COLOURS)
