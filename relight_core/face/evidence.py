"""Evidence of a face in a parsing map, needed because the cascades also take curtains and hands for faces."""

from __future__ import annotations

import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.parsing import BROWS, EYES, FACE_LABELS, INDEX, MOUTH

_FEATURES = (BROWS, (*EYES, "glasses"), MOUTH)
_LEAST_SHARE, _LEAST_SUSPECTED = 0.003, 0.0045
"""Least share of the crop that a feature covers: by labels, and by its mean probability."""
_LEAST_STEPS = (0.01, 0.12)
"""Least distance, as a share of the crop's side, of eyes below brows, and of a mouth below either."""
_HIGHEST, _LOWEST = 0.1, 0.9
"""Where brows, eyes and mouth may lie, as shares of the crop's height; those of faces lie between 0.2 and 0.8."""
_MIDDLE, _LEAST_FACE = 0.225, 0.45
"""The crop's middle reaches this share of its side in each direction, and at least so much of it must be face. Of faces
it is nearly all, two thirds at a photo's edge, half in profile."""


def evidence_of_face(labels: np.ndarray, view: Crop, crop: Crop) -> int:
    """How many of brows, eyes (or glasses) and mouth are seen where a face should be, from top to bottom.

    A face shows at least two of them, even if one is covered or out of view. Where there is no face, networks see
    skin and noses, and here and there a mouth.

    Args:
        labels: (S, S) parsing labels of the view.
        view: where they lie in the photo.
        crop: the paper's square around the face, within the view.

    Returns:
        0 to 3; 0 if they are in the wrong order or too close to each other, or too little around them is face.
    """
    shares = [np.isin(labels, [INDEX[name] for name in names]).astype(np.float32) for names in _FEATURES]
    return _count(shares, np.isin(labels, FACE_LABELS), _LEAST_SHARE, view, crop)


def glimpses_of_face(probability: np.ndarray, view: Crop, crop: Crop) -> int:
    """`evidence_of_face` from probabilities: in small or overexposed faces brows and eyes may win no pixel.

    Leaves and wheels may give as much of it as faces do, so this is for places that are likely to be faces.

    Args:
        probability: (classes, S, S) of the view.
        view, crop: as of `evidence_of_face`.
    """
    shares = [probability[[INDEX[name] for name in names]].sum(0) for names in _FEATURES]
    return _count(shares, probability[list(FACE_LABELS)].sum(0), _LEAST_SUSPECTED, view, crop)


def certainty_of_face(probability: np.ndarray, view: Crop, crop: Crop) -> float:
    """How certain the parsing is of its classes where a face should be: about 0.75 for faces, less for clutter.

    Args:
        probability: (classes, S, S) of the view.
        view, crop: as of `evidence_of_face`.

    Returns:
        The mean over the crop's middle of the likeliest class's probability; 0 if that is outside the view.
    """
    return float(_part(probability.max(0), view, crop, _MIDDLE).mean())


def _count(shares: list[np.ndarray], face: np.ndarray, least: float, view: Crop, crop: Crop) -> int:
    """How many features cover enough of the crop; 0 unless its middle is face and each is well below the one before.

    Args:
        shares: of each feature, (S, S) in [0, 1] of the view.
        face: the same of all of the face.
        least: mean over the crop from which on a feature counts as seen.
    """
    if _part(face, view, crop, _MIDDLE).mean() < _LEAST_FACE:
        return 0
    seen = [_part(share, view, crop, 0.5) for share in shares]
    heights = [_height(share) if share.mean() >= least else None for share in seen]
    # A feature outside the possible heights is something else.
    brows, eyes, mouth = heights = [at if at is not None and _HIGHEST < at < _LOWEST else None for at in heights]
    for above, below, step in ((brows, eyes, 0), (eyes, mouth, 1), (brows, mouth, 1)):
        if above is not None and below is not None and below - above < _LEAST_STEPS[step]:
            return 0
    return sum(height is not None for height in heights)


def _part(share: np.ndarray, view: Crop, crop: Crop, reach: float) -> np.ndarray:
    """The part of a view's map (S, S) that lies within `reach` sides of the crop's centre; a single 0 if none does."""
    size = share.shape[0]
    x, y = view.from_photo(np.array([crop.centre_x, crop.centre_y]), size)
    half = reach * crop.side / view.side * size
    rows, columns = (slice(max(round(at - half), 0), max(round(at + half), 0)) for at in (y, x))
    part = share[rows, columns]
    return part if part.size else np.zeros((1, 1), np.float32)


def _height(share: np.ndarray) -> float:
    """The mean row of a feature, as a fraction of the crop's height from its top."""
    return float((share.sum(1) * np.arange(len(share))).sum() / share.sum() / len(share))
