"""How far the new light takes the photo's place: the pictures under both lights, added up.

Light adds up. In linear radiance, a part of the picture under the photo's own light and the rest of the picture under
the new one are the picture under a mixture of both lights. A relit picture is a gain and an offset of the photo's own
colours, and under its own light the photo is itself, a gain of 1 without an offset; so mixing the maps mixes the
pictures, at any size and in a shader as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from relight_core.pipeline.results.picture import PlacedCatchlight, PlacedChange


def mixed_gain(gain: np.ndarray, strength: float) -> np.ndarray:
    """A gain of the photo's colours (h, w, 3), >= 0, mixed with 1: the photo's own light at 0, as it is at 1."""
    return gain if strength == 1 else cv2.addWeighted(gain, strength, np.ones_like(gain), 1 - strength, 0)


def mixed_changes(changes: Sequence[PlacedChange], strength: float) -> tuple[PlacedChange, ...]:
    """What a light does within the faces' views, mixed with the photo as it is; `strength` in [0, 1]."""
    if strength == 1:
        return tuple(changes)
    return tuple(
        replace(one, gain=mixed_gain(one.gain, strength), offset=one.offset * np.float32(strength)) for one in changes
    )


def mixed_catchlights(catchlights: Sequence[PlacedCatchlight], strength: float) -> tuple[PlacedCatchlight, ...]:
    """What is added in the eyes, over `mixed_changes` of the same strength; none at 0."""
    if strength == 1:
        return tuple(catchlights)
    return tuple(replace(one, added=one.added * np.float32(strength)) for one in catchlights if strength)
