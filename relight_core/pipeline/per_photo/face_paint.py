"""A face that is painted all over, in a colour that no skin has and no light of the photo's.

To the networks there is no paint, but coloured light, in which hair and neck would have to be of the opposite colour:
a blue face's hair turns orange in a white light. A lamp lights a neck and hair as it does the face. So where all of a
face has one colour that is no skin's, and neck and hair are seen in colours that they do have, it is paint.
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
"""Log ratios of red and of blue to green, the least and the most of each, in a light that a camera nearly balances."""
_SURELY_BEYOND = 0.2
_APART = (0.6, 0.9)
"""Log ratios by which a face may be, and surely is, of another colour than its neck and its hair."""
_OF_ONE_COLOUR = (0.7, 1.0)
"""How far apart log ratios are over eight tenths of a face up to which it has one colour, and from which several."""
_SEEN = (0.02, 0.95)
"""Linear: what is darker has colours of noise, and what is brighter is clipped."""


def face_paint(surface: Surface) -> torch.Tensor:
    """(1, 1, S, S) how surely a face's skin is painted, [0, 1]; nowhere if its neck and hair don't tell."""
    return share_of(surface.parsing, _FACE) * _surely_painted(surface)


def with_paint(surface: Surface) -> Surface:
    """The surface with its paint as albedo: as far from the neck's colour as it is seen, and as bright as it was."""
    paint = face_paint(surface)
    if not bool(paint.any()):
        return surface
    seen, beside = (_middle(_seen_ratios(surface, part)) for part in (_FACE, _NECK))
    neck = middle_values(surface.albedo, (share_of(surface.parsing, _NECK) > SURELY)[0, 0])
    painted = as_bright_as(neck * torch.exp(seen - beside)[None, :, None, None], surface.albedo)
    return replace(surface, albedo=torch.lerp(surface.albedo, painted.clamp(0, 1), paint))


def _surely_painted(surface: Surface) -> float:
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
    """How surely a colour (3,), log ratios to green, is none of the usual ones, [0, 1]."""
    off = (max(least - value, value - most) for value, (least, most) in zip(colour[::2].tolist(), usual, strict=True))
    return ramp(max(off), 0.0, _SURELY_BEYOND)


def _middle(ratios: torch.Tensor) -> torch.Tensor:
    return ratios.median(1).values


def _seen_ratios(surface: Surface, part: tuple[str, ...]) -> torch.Tensor:
    """(3, N) log ratios to green of the photo's pixels of some classes that are neither black nor clipped."""
    least, most = _SEEN
    seen = (share_of(surface.parsing, part) > SURELY) & (grey(surface.photo) > least)
    logs = exact_logs(surface.photo)
    return (logs - logs[:, 1:2])[0][:, (seen & (surface.photo.amax(1, keepdim=True) < most))[0, 0]]
