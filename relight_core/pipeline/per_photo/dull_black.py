"""What is darker than any skin is cloth or hair, whatever the parsing takes it for, and gloss would be a haze over it.

Beside a fair face it needn't be black for that: what the parsing takes for skin and has half the face's albedo is a
beard, hair or a collar, each lifted by all that is bright around it. Nor does dark hair mirror as its smooth normals
would have it.
"""

from __future__ import annotations

import torch

from relight_core.face.parsing import FEWEST_PIXELS, INDEX, SURELY, share_of
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_colour import grey

_BLACK, _DARKEST_SKIN, _BLACK_GLOSS = 0.015, 0.045, 0.08
_BESIDE_THE_FACE = (
    (("skin", "neck"), (0.4, 0.75)),
    (("hair", "hat", "cloth"), (0.1, 0.25)),
)
"""Of the face's albedo: up to the first a part of such a kind counts as black, from the second on it has its gloss.
Beards have 0.3 to 0.7, most plain skin more than 0.8: of 25 photos' faces and necks, two faces and five necks have
more than a tenth below 0.6, beards and hair but for one neck in deep shade."""


def gloss_of_black(albedo: torch.Tensor, parsing: torch.Tensor) -> torch.Tensor:
    """How much of its gloss a surface has for being no darker than skin, (1, 1, S, S) in (0, 1].

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
    return ramp(dark, black, glossy).clamp_min(_BLACK_GLOSS)
