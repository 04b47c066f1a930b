"""The face-parsing classes: the paper's eight regions, the background, and the classes we add around them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from relight_core.imaging.ramp import ramp

if TYPE_CHECKING:
    import numpy as np
    import torch

CLASSES = (
    "background",
    "skin",
    "left_brow",
    "right_brow",
    "left_eye",
    "right_eye",
    "nose",
    "inner_mouth",
    "lips",
    "neck",
    "hair",
    "hat",
    "glasses",
    "cloth",
)
"""Names by label. Left and right are the person's own (paper, section 3.2: 2 eyebrows, 2 eyes, nose,
inner mouth, lips and skin); "neck" holds all bare skin outside the face: neck, ears, scalp."""

INDEX = {name: index for index, name in enumerate(CLASSES)}

PAPER_CLASSES = CLASSES[1:9]
"""The eight regions of the paper, in which everything else is black background."""

FACE_LABELS = tuple(INDEX[name] for name in PAPER_CLASSES)
"""The labels of those regions."""

_OTHER_SIDE = {"left_brow": "right_brow", "left_eye": "right_eye", "right_brow": "left_brow", "right_eye": "left_eye"}

MIRRORED = tuple(INDEX[_OTHER_SIDE.get(name, name)] for name in CLASSES)
"""The label that each label becomes when the image is mirrored."""

PALETTE_SRGB = (
    (0, 0, 0),
    (236, 188, 150),
    (120, 72, 30),
    (168, 104, 44),
    (70, 130, 220),
    (40, 190, 210),
    (250, 150, 90),
    (120, 20, 60),
    (220, 60, 90),
    (190, 140, 110),
    (90, 60, 120),
    (220, 200, 60),
    (60, 220, 120),
    (90, 110, 90),
)
"""Display colour of each class, sRGB bytes."""

SKIN, BROWS, EYES, MOUTH = (
    ("skin", "nose", "neck"),
    ("left_brow", "right_brow"),
    ("left_eye", "right_eye"),
    ("lips", "inner_mouth"),
)
"""Names of the classes of bare skin, of brows, of eyes and of the mouth."""

KINDS = (SKIN, (*BROWS, *EYES, *MOUTH), ("hair",), ("hat", "glasses", "cloth"))
"""Groups of classes that are inputs of the foreign-shadow network, one channel each: all but the background."""

SURELY = 0.6
"""A pixel surely belongs to a class, or to one of several, above this probability."""

FEWEST_PIXELS = 50
"""Pixels that must surely belong to a part of a view before its colour or brightness is measured."""

FEWEST_OF_SKIN = 100
"""Pixels that must surely be bare skin before such a measurement changes its albedo."""

_UNLIKELY, _LIKELY = 0.5, 0.75
"""Ramp of `likely`."""


def share_of(parsing: torch.Tensor, names: Sequence[str]) -> torch.Tensor:
    """The probability that a pixel is of any of some classes, (B, 1, S, S), from (B, classes, S, S)."""
    return sum(parsing[:, INDEX[name], None] for name in names)


def skin_share(parsing: torch.Tensor) -> torch.Tensor:
    """The probability of bare skin, (B, 1, S, S), from (B, classes, S, S)."""
    return share_of(parsing, SKIN).clamp(0, 1)


def likely(share: torch.Tensor) -> torch.Tensor:
    """A class's probability, sharpened: 1 from three times that of all others together on, 0 up to even odds."""
    return ramp(share, _UNLIKELY, _LIKELY)


def with_neck_as(parsing: torch.Tensor, name: str, share: torch.Tensor) -> torch.Tensor:
    """Parsing probabilities (B, classes, S, S) with a part (B, 1, S, S) of the neck's probability moved to a class."""
    parsing = parsing.clone()
    parsing[:, INDEX["neck"]] -= share[:, 0]
    parsing[:, INDEX[name]] += share[:, 0]
    return parsing


def middle_row(parsing: np.ndarray | torch.Tensor, names: Sequence[str], least_px: float) -> float | None:
    """The mean row of some classes in a parsing (classes, S, S); None if they have at most `least_px` pixels."""
    by_row = parsing[[INDEX[name] for name in names]].sum((0, 2)).tolist()
    total = sum(by_row)
    return sum(row * share for row, share in enumerate(by_row)) / total if total > least_px else None
