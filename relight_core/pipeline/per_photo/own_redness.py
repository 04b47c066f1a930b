"""Redness that skin has by itself: a burn, a port-wine stain, sunburn, rouge.

They end little by little, as a lamp's colour does. But what a lamp does to skin follows from the way the skin faces,
and that of all lamps together from nine numbers (Ramamoorthi and Hanrahan 2001), but for shadows. Redness that a face's
normals don't explain is its own. It is blood's: green and blue go together, where those of lamps, of the sky and of
shadows seldom do.
"""

from __future__ import annotations

import torch

from relight_core.face.parsing import FEWEST_OF_SKIN, SURELY, share_of
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_means import local_means, middle_values
from relight_core.pipeline.per_photo.skin_colour import deep_shadow
from relight_core.pipeline.stages import Surface

_REACH = 0.04
"""Of the view's side: what is narrower, as beside nostrils and lids, is shaded skin more often than red skin."""
_REDDER = (0.15, 0.35)
"""Log ratios of red to green beyond what normals explain that may be, and surely are, more than flush."""
_NOT_OF_BLOOD = (0.4, 0.8)
"""How far blue leaves green, as a share of how far red does, from which on it may not, and surely doesn't, do it."""
_OF_LAMPS = (0.7, 1.0)
"""How far apart normals alone make log ratios of red to green, in nine tenths of the skin, where several lamps may,
and surely do, light a face; what they don't explain there are the lamps' shadows."""
_USUAL, _ROUNDS, _EVERY = 0.1, 6, 4
"""Log ratios by which skin differs from pixel to pixel; how often it is fitted anew with less of what is off by more;
of how many pixels one is enough for that."""
_RIDGE = 1e-3


def own_redness(surface: Surface, ratios: torch.Tensor, skin: torch.Tensor) -> torch.Tensor:
    """(1, 1, S, S) how surely a face's pixels are redder than most of it by themselves, [0, 1].

    Args:
        ratios: (1, 3, S, S) log ratios to green of what the photo shows, beside the model of its light.
        skin: (1, 1, S, S) probability of bare skin that the photo shows.
    """
    sure = (skin > SURELY)[0, 0]
    if int(sure.sum()) < FEWEST_OF_SKIN:
        return torch.zeros_like(skin)
    off = (ratios - middle_values(ratios, sure))[:, ::2]
    explained = _by_normals(off, surface.normal.float(), sure)
    red, blue = local_means(off - explained, skin, _REACH).split(1, dim=1)
    least, most = torch.quantile(explained[0, 0][sure], off.new_tensor([0.05, 0.95]))
    of_one_light = 1 - ramp(float(most - least), *_OF_LAMPS)
    of_blood = 1 - ramp(blue.abs() / red.clamp_min(_REDDER[0]), *_NOT_OF_BLOOD)
    face = share_of(surface.parsing, ("skin", "nose")) * (1 - deep_shadow(surface.photo, skin))
    return of_one_light * face * of_blood * ramp(red, *_REDDER)


def _by_normals(values: torch.Tensor, normal: torch.Tensor, sure: torch.Tensor) -> torch.Tensor:
    """(1, C, S, S) what normals (1, 3, S, S) explain of values of that shape, by most of a part (S, S), bool."""
    x, y, z = normal[0]
    harmonics = torch.stack([torch.ones_like(x), x, y, z, x * y, y * z, z * x, x * x - y * y, 3 * z * z - 1], -1)
    known, target = harmonics[sure][::_EVERY], values[0][:, sure].T[::_EVERY]
    weight = torch.ones_like(known[:, :1])
    for _ in range(_ROUNDS):
        weighted = weight * known
        ridge = _RIDGE * len(known) * torch.eye(known.shape[1], device=known.device)
        fit = torch.linalg.solve(weighted.T @ known + ridge, weighted.T @ target)
        miss = (target - known @ fit).norm(dim=1, keepdim=True)
        weight = 1 / (1 + (miss / _USUAL).square())
    return (harmonics @ fit).movedim(-1, 0)[None]
