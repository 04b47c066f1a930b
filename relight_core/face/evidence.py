"""How far a parsing map agrees that there is a face: the finder's cascades take curtains and hands for faces too."""

from __future__ import annotations

import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.parsing import INDEX

_FEATURES = (("left_brow", "right_brow"), ("left_eye", "right_eye", "glasses"), ("lips", "inner_mouth"))
_LEAST_SHARE = 0.004
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
    size = labels.shape[0]
    x, y = view.from_photo(np.array([crop.centre_x, crop.centre_y]), size)
    half = crop.side / view.side * size / 2
    rows, columns = (slice(max(round(at - half), 0), max(round(at + half), 0)) for at in (y, x))
    seen = labels[rows, columns]
    if seen.size == 0:
        return 0
    masks = [np.isin(seen, [INDEX[name] for name in names]) for names in _FEATURES]
    heights = [np.nonzero(mask)[0].mean() / len(seen) if mask.mean() >= _LEAST_SHARE else None for mask in masks]
    return _count_in_order(heights)


def _count_in_order(heights: list[float | None]) -> int:
    """How many heights there are; 0 unless each lies far enough below the one before."""
    brows, eyes, mouth = heights
    for above, below, least in ((brows, eyes, 0), (eyes, mouth, 1), (brows, mouth, 1)):
        if above is not None and below is not None and below - above < _LEAST_STEPS[least]:
            return 0
    return sum(height is not None for height in heights)
