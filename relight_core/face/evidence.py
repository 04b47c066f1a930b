"""How far a parsing map agrees that there is a face: the finder's cascades take curtains and hands for faces too."""

from __future__ import annotations

import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.parsing import INDEX

_FEATURES = (("left_brow", "right_brow"), ("left_eye", "right_eye", "glasses"), ("lips", "inner_mouth"))
_LEAST_SHARE, _LEAST_SUSPECTED = 0.004, 0.005
_LEAST_STEPS = (0.01, 0.12)


def evidence_of_face(labels: np.ndarray, view: Crop, crop: Crop) -> int:
    """How many of brows, eyes (or glasses) and mouth are seen where a face should be, in this order from above.

    Of a face two are seen at least: what is covered or out of sight may be missing. Where there is none, networks
    see skin and noses, and here and there a mouth.

    Args:
        labels: (S, S) parsing labels of the view.
        view: where they lie in the photo.
        crop: the paper's square about the face, within the view.

    Returns:
        0 to 3; 0 where they are not one above the other.
    """
    shares = [np.isin(labels, [INDEX[name] for name in names]).astype(np.float32) for names in _FEATURES]
    return _count(shares, _LEAST_SHARE, view, crop)


def glimpses_of_face(probability: np.ndarray, view: Crop, crop: Crop) -> int:
    """`evidence_of_face` of what the parsing only suspects: in small or overexposed faces brows and eyes win no pixel.

    What it suspects of leaves and wheels may look the same, so this is to be asked of likely places alone.

    Args:
        probability: (classes, S, S) of the view.
        view, crop: as there.
    """
    shares = [probability[[INDEX[name] for name in names]].sum(0) for names in _FEATURES]
    return _count(shares, _LEAST_SUSPECTED, view, crop)


def _count(shares: list[np.ndarray], least: float, view: Crop, crop: Crop) -> int:
    """How many features fill enough of the crop; 0 unless each lies far enough below the one before."""
    size = shares[0].shape[0]
    x, y = view.from_photo(np.array([crop.centre_x, crop.centre_y]), size)
    half = crop.side / view.side * size / 2
    rows, columns = (slice(max(round(at - half), 0), max(round(at + half), 0)) for at in (y, x))
    seen = [share[rows, columns] for share in shares]
    if seen[0].size == 0:
        return 0
    brows, eyes, mouth = heights = [_height(share) if share.mean() >= least else None for share in seen]
    for above, below, step in ((brows, eyes, 0), (eyes, mouth, 1), (brows, mouth, 1)):
        if above is not None and below is not None and below - above < _LEAST_STEPS[step]:
            return 0
    return sum(height is not None for height in heights)


def _height(share: np.ndarray) -> float:
    """The mean row of a feature, as a fraction of the crop from its top."""
    return float((share.sum(1) * np.arange(len(share))).sum() / share.sum() / len(share))
