"""The gloss of each part of a portrait, as a share of that of skin.

The paper gives everything the gloss of skin (section 3.2) and names the drawback (5.4): hair and cloth scatter more
than they mirror, so a sheen like that of skin looks like haze over them.
"""

from __future__ import annotations

import numpy as np

from relight_core.face.parsing import CLASSES

_DULL = {
    "background": 0.1,
    "left_brow": 0.4,
    "right_brow": 0.4,
    "left_eye": 0.5,
    "right_eye": 0.5,
    "hair": 0.15,
    "hat": 0.15,
    "cloth": 0.08,
}

GLOSS_SHARE = tuple(_DULL.get(name, 1.0) for name in CLASSES)
"""The share by label, in (0, 1]."""


def gloss_of(labels: np.ndarray, dullness: float = 1.0) -> np.ndarray:
    """The shares of pixels with labels (P,), (P, 1) float32, to the power of `dullness`: at 0 all have skin's gloss."""
    return np.array(GLOSS_SHARE, np.float32)[labels][:, None] ** dullness
