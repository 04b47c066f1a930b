"""How much of the gloss of skin each part of a portrait has.

The paper gives everything the gloss of skin (section 3.2) and names what that costs (5.4): hair and cloth scatter
more than they mirror, and a sheen as of skin lies over them as haze.
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
"""By label, (0, 1]."""


def gloss_of(labels: np.ndarray, dullness: float = 1.0) -> np.ndarray:
    """The shares of pixels (P,), as (P, 1) float32, to the power of `dullness`: 0 gives all the gloss of skin."""
    return np.array(GLOSS_SHARE, np.float32)[labels][:, None] ** dullness
