"""Gloss of black things, which the parsing may take for skin and on which the gloss of skin would look like haze.

What is darker than any skin is cloth or hair, whatever the parsing says. Beside a fair face it needn't be black: what
is parsed as skin and has half the face's albedo is a beard, hair or a collar, brightened by what is bright around it.
Dark hair is also duller than its smooth predicted normals make it.
"""

from __future__ import annotations

import torch

from relight_core.face.parsing import FEWEST_PIXELS, INDEX, SURELY, share_of
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_colour import grey

_BLACK, _DARKEST_SKIN, _BLACK_GLOSS = 0.015, 0.045, 0.08
"""Ramp of the albedo's luminance, from the gloss of black cloth, the last number, to full gloss."""
_BESIDE_THE_FACE = (
    (("skin", "neck"), (0.4, 0.75)),
    (("hair", "hat", "cloth"), (0.1, 0.25)),
)
"""The same ramp for classes, relative to the face's albedo: up to the first a part of such a class counts as black,
from the second on it has its gloss. Beards have 0.3 to 0.7, most plain skin more than 0.8. In 25 photos, two faces and
five necks have more than a tenth of their pixels below 0.6: beards and hair, and one neck in deep shade."""


def gloss_of_black(albedo: torch.Tensor, parsing: torch.Tensor) -> torch.Tensor:
    """The factor by which a surface's gloss is reduced for being darker than skin, (1, 1, S, S) in (0, 1].

    Args:
        albedo: (1, 3, S, S) linear.
        parsing: (1, classes, S, S) probabilities.
    """
    dark, face = grey(albedo), parsing[:, INDEX["skin"], None] > SURELY
    share = _from_to(dark, _BLACK, _DARKEST_SKIN)
    if int(face.sum()) < FEWEST_PIXELS:
        return share
    fairness, duller = float(dark[face].median()), 0.0
    for names, (black, glossy) in _BESIDE_THE_FACE:
        beside = _from_to(dark, max(black * fairness, _BLACK), max(glossy * fairness, _DARKEST_SKIN))
        duller = duller + share_of(parsing, names) * (share - beside)
    return (share - duller).clamp(_BLACK_GLOSS, 1)


def _from_to(dark: torch.Tensor, black: float, glossy: float) -> torch.Tensor:
    """The ramp of gloss over an albedo's luminance."""
    return ramp(dark, black, glossy).clamp_min(_BLACK_GLOSS)
