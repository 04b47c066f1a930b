"""Redness that belongs to the skin: a burn, a port-wine stain, sunburn, rouge.

It ends gradually, as a lamp's colour does. But apart from shadows, the colour that lamps give to skin is a function of
the normal, and for all lamps together nine spherical harmonics describe it (Ramamoorthi and Hanrahan 2001). So redness
that a face's normals don't explain is the skin's own. It comes from blood, which lowers green and blue together; lamps,
the sky and shadows seldom do.
"""

from __future__ import annotations

import torch

from relight_core.face.parsing import FEWEST_OF_SKIN, SURELY, share_of
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_means import local_means, middle_values
from relight_core.pipeline.per_photo.skin_colour import deep_shadow
from relight_core.pipeline.stages import Surface

_REACH = 0.04
"""Reach of the local mean, as a share of the view's side: narrower redness, as beside nostrils and lids, is more often
shaded skin."""
_REDDER = (0.15, 0.35)
"""Ramp of the unexplained log ratio of red to green over which redness becomes more than flush."""
_NOT_OF_BLOOD = (0.4, 0.8)
"""Ramp of the change of blue relative to green, as a share of that of red, over which it ceases to be blood's."""
_OF_LAMPS = (0.7, 1.0)
"""Ramp of the range of log ratios of red to green that normals explain, over nine tenths of the skin, over which a face
counts as lit by several lamps. What normals don't explain there are the lamps' shadows."""
_USUAL, _ROUNDS, _EVERY = 0.1, 6, 4
"""The robust fit: residuals above the first, in log ratios, lose weight; it has so many iterations, and uses every
fourth pixel."""
_RIDGE = 1e-3
"""Regularisation of the fit, per pixel."""


def own_redness(surface: Surface, ratios: torch.Tensor, skin: torch.Tensor) -> torch.Tensor:
    """Certainty that a face's pixels are redder than most of its skin by themselves, (1, 1, S, S) in [0, 1].

    Args:
        surface: of the photo.
        ratios: (1, 3, S, S) log ratios to green of the photo's colours, with the known colour of the light removed.
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
    """The part of values (1, C, S, S) that normals explain: spherical harmonics up to order 2, by a robust fit.

    Args:
        normal: (1, 3, S, S).
        sure: (S, S) bool, where they are fitted.
    """
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
