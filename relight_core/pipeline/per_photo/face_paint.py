"""A face that is painted all over, in a colour that neither skin nor the photo's light has.

The networks don't know paint and predict coloured light, so hair and neck get the opposite colour: the hair of a blue
face turns orange in a white light. But a lamp would light neck and hair like the face. So if all of a face has one
colour that isn't that of skin, and neck and hair have usual colours, it is paint.
"""

from __future__ import annotations

from dataclasses import replace

import torch

from relight_core.face.parsing import FEWEST_PIXELS, SURELY, share_of
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_colour import as_bright_as, grey
from relight_core.imaging.tensor_logs import exact_logs
from relight_core.imaging.tensor_means import middle_values
from relight_core.pipeline.stages import Surface

_FACE, _NECK, _HAIR = ("skin", "nose"), ("neck",), ("hair",)
_OF_SKIN, _OF_HAIR = ((0.2, 1.6), (-1.1, 0.1)), ((-0.2, 1.3), (-1.6, 0.3))
"""Usual ranges of the log ratios of red to green and of blue to green, in a light that the camera nearly balances."""
_SURELY_BEYOND = 0.2
"""A log ratio so far outside of its range is surely unusual."""
_APART = (0.6, 0.9)
"""Ramp of the difference in log ratios over which a face is of another colour than its neck and its hair."""
_OF_ONE_COLOUR = (0.7, 1.0)
"""Ramp of the range of log ratios over eight tenths of a face, over which it goes from one colour to several."""
_SEEN = (0.02, 0.95)
"""Linear values: darker ones have the colour of noise, brighter ones are clipped."""


def face_paint(surface: Surface) -> torch.Tensor:
    """Certainty that a face's skin is painted, (1, 1, S, S) in [0, 1]; 0 if neck or hair can't be seen."""
    return share_of(surface.parsing, _FACE) * _surely_painted(surface)


def with_paint(surface: Surface) -> Surface:
    """The surface with the paint in its albedo: it differs from the neck's colour as much as in the photo.

    The albedo's brightness is kept.
    """
    paint = face_paint(surface)
    if not bool(paint.any()):
        return surface
    seen, beside = (_middle(_seen_ratios(surface, part)) for part in (_FACE, _NECK))
    neck = middle_values(surface.albedo, (share_of(surface.parsing, _NECK) > SURELY)[0, 0])
    painted = as_bright_as(neck * torch.exp(seen - beside)[None, :, None, None], surface.albedo)
    return replace(surface, albedo=torch.lerp(surface.albedo, painted.clamp(0, 1), paint))


def _surely_painted(surface: Surface) -> float:
    """Certainty that the face is painted, [0, 1]."""
    ratios = [_seen_ratios(surface, part) for part in (_FACE, _NECK, _HAIR)]
    if min(part.shape[1] for part in ratios) < FEWEST_PIXELS:
        return 0.0
    face, neck, hair = map(_middle, ratios)
    apart = min(float((face - other).abs().max()) for other in (neck, hair))
    least, most = torch.quantile(ratios[0], face.new_tensor([0.1, 0.9]), dim=1)
    of_one_colour = 1 - ramp(float((most - least).max()), *_OF_ONE_COLOUR)
    others_as_usual = (1 - _beyond(neck, _OF_SKIN)) * (1 - _beyond(hair, _OF_HAIR))
    return _beyond(face, _OF_SKIN) * others_as_usual * of_one_colour * ramp(apart, *_APART)


def _beyond(colour: torch.Tensor, usual: tuple[tuple[float, float], tuple[float, float]]) -> float:
    """Certainty that a colour (3,), as log ratios to green, is unusual, [0, 1]."""
    off = (max(least - value, value - most) for value, (least, most) in zip(colour[::2].tolist(), usual, strict=True))
    return ramp(max(off), 0.0, _SURELY_BEYOND)


def _middle(ratios: torch.Tensor) -> torch.Tensor:
    return ratios.median(1).values


def _seen_ratios(surface: Surface, part: tuple[str, ...]) -> torch.Tensor:
    """Log ratios to green (3, N) of those pixels of some classes that are neither black nor clipped in the photo."""
    least, most = _SEEN
    seen = (share_of(surface.parsing, part) > SURELY) & (grey(surface.photo) > least)
    logs = exact_logs(surface.photo)
    return (logs - logs[:, 1:2])[0][:, (seen & (surface.photo.amax(1, keepdim=True) < most))[0, 0]]
