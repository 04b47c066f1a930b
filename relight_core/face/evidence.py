"""How far a parsing map agrees that there is a face: the finder's cascades take curtains and hands for faces too."""

from __future__ import annotations

import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.parsing import BROWS, EYES, FACE_LABELS, INDEX, MOUTH

_FEATURES = (BROWS, (*EYES, "glasses"), MOUTH)
_LEAST_SHARE, _LEAST_SUSPECTED = 0.003, 0.0045
"""Shares of the crop that a feature fills: as labels, and as the mean of its probability."""
_LEAST_STEPS = (0.01, 0.12)
"""By how much of the crop's side eyes lie below brows, and a mouth below either."""
_HIGHEST, _LOWEST = 0.1, 0.9
"""Where in the crop brows, eyes and mouth may lie, from its top; those of faces lie between 0.2 and 0.8."""
_MIDDLE, _LEAST_FACE = 0.225, 0.45
"""Share of the crop's side to each side of its middle, and how much of that is face where there is one: nearly all of
it, two thirds at a photo's edge, half in profile."""


def evidence_of_face(labels: np.ndarray, view: Crop, crop: Crop) -> int:
    """How many of brows, eyes (or glasses) and mouth are seen where a face should be, in this order from above.

    Of a face two are seen at least: what is covered or out of sight may be missing. Where there is none, networks
    see skin and noses, and here and there a mouth.

    Args:
        labels: (S, S) parsing labels of the view.
        view: where they lie in the photo.
        crop: the paper's square about the face, within the view.

    Returns:
        0 to 3; 0 where they are not one above the other, or too little around them is face.
    """
    shares = [np.isin(labels, [INDEX[name] for name in names]).astype(np.float32) for names in _FEATURES]
    return _count(shares, np.isin(labels, FACE_LABELS), _LEAST_SHARE, view, crop)


def glimpses_of_face(probability: np.ndarray, view: Crop, crop: Crop) -> int:
    """`evidence_of_face` of what the parsing only suspects: in small or overexposed faces brows and eyes win no pixel.

    What it suspects of leaves and wheels may look the same, so this is to be asked of likely places alone.

    Args:
        probability: (classes, S, S) of the view.
        view, crop: as there.
    """
    shares = [probability[[INDEX[name] for name in names]].sum(0) for names in _FEATURES]
    return _count(shares, probability[list(FACE_LABELS)].sum(0), _LEAST_SUSPECTED, view, crop)


def certainty_of_face(probability: np.ndarray, view: Crop, crop: Crop) -> float:
    """How sure the parsing is of what it sees where a face should be; of faces about 0.75, in motley things less.

    Args:
        probability: (classes, S, S) of the view.
        view, crop: as there.

    Returns:
        The likeliest class's probability, on average over the middle of the crop; 0 where that is out of the view.
    """
    return float(_part(probability.max(0), view, crop, _MIDDLE).mean())


def _count(shares: list[np.ndarray], face: np.ndarray, least: float, view: Crop, crop: Crop) -> int:
    """How many features fill enough of the crop; 0 unless its middle is face and each is well below the last."""
    if _part(face, view, crop, _MIDDLE).mean() < _LEAST_FACE:
        return 0
    seen = [_part(share, view, crop, 0.5) for share in shares]
    heights = [_height(share) if share.mean() >= least else None for share in seen]
    # What is seen where it can't be is something else.
    brows, eyes, mouth = heights = [at if at is not None and _HIGHEST < at < _LOWEST else None for at in heights]
    for above, below, step in ((brows, eyes, 0), (eyes, mouth, 1), (brows, mouth, 1)):
        if above is not None and below is not None and below - above < _LEAST_STEPS[step]:
            return 0
    return sum(height is not None for height in heights)


def _part(share: np.ndarray, view: Crop, crop: Crop, reach: float) -> np.ndarray:
    """What of a map (S, S) of the view lies within so much of the crop's side around its middle; a 0 for nothing."""
    size = share.shape[0]
    x, y = view.from_photo(np.array([crop.centre_x, crop.centre_y]), size)
    half = reach * crop.side / view.side * size
    rows, columns = (slice(max(round(at - half), 0), max(round(at + half), 0)) for at in (y, x))
    part = share[rows, columns]
    return part if part.size else np.zeros((1, 1), np.float32)


def _height(share: np.ndarray) -> float:
    """The mean row of a feature, as a fraction of the crop from its top."""
    return float((share.sum(1) * np.arange(len(share))).sum() / share.sum() / len(share))
