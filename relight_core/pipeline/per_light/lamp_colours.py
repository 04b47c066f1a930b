"""Colours on a face that come from the photo's light, although the model of the photo doesn't explain them.

Lamps: between two neon lamps a face is pink on one side and teal on the other, and the estimated light explains only
a part of that. The rest would stay on the skin under any light, as paint does. So if the estimated light already has
several colours, a remaining colour belongs to a lamp if it covers more than a mole and is stronger than flush and tan.
In a light of one colour it may be paint or rouge.

Shade: a hat, a wall or leaves cast shadows that the model doesn't know either, and skin in these is lit by the sky. So
if much of the skin lies in such shadows, the difference of colour between them and the rest of the skin is theirs.
"""

from __future__ import annotations

import torch

from relight_core.face.parsing import BROWS, EYES, FEWEST_PIXELS, MOUTH, SURELY, share_of
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_logs import log_ratios, without_mean
from relight_core.imaging.tensor_means import local_means, local_medians, middle_values
from relight_core.pipeline.stages import Surface

MOLE = 0.02
"""As a share of the view's side: a deviation on skin that extends no farther is likely the skin's own, a larger one a
shadow or gloss."""
_FLUSH = (0.1, 0.2)
"""Ramp of a colour's deviation in logs: up to the first flush or tan explain it, from the second on they don't."""
_SEVERAL_COLOURS = (0.4, 0.8)
"""Ramp of the range of a light's colour over most of the skin, in logs, over which the light counts as of several
colours."""
_AMID_SKIN = (*BROWS, *EYES, *MOUTH)
"""Parts that such lamps light like the skin around them."""


def colours_of_lamps(
    surface: Surface, plain: torch.Tensor, colour: torch.Tensor, skin: torch.Tensor, known: torch.Tensor
) -> torch.Tensor:
    """The part of a face's colour that comes from lamps, (1, 3, S, S) logs of mean 0 over the channels.

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
    """The part of a face's colour that comes from shade that the model missed, (1, 3, S, S) logs of mean 0.

    It is proportional to the depth of the shade, and 0 where skin is as bright as the brighter part of the skin.

    Args:
        missed: (1, 1, S, S) logs of brightness that the model missed; must vary over the known skin.
        colour, skin, known: as of `colours_of_lamps`; some skin must be known.
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
    """A deviation of colour (1, 3, S, S) on skin, and on eyes, brows and mouth the mean of that around them."""
    return skin * off + share_of(surface.parsing, _AMID_SKIN) * local_means(off, skin)


def _several_colours(surface: Surface, plain: torch.Tensor, sure: torch.Tensor) -> float:
    """The degree to which the light on the skin (S, S) has several colours, [0, 1]."""
    light = without_mean(log_ratios(plain.float(), surface.albedo))[0][:, sure]
    least, most = torch.quantile(light, light.new_tensor([0.1, 0.9]), dim=1)
    return ramp(float((most - least).max()), *_SEVERAL_COLOURS)
