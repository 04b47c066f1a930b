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

WhatLightDoes = tuple[np.ndarray, tuple[PlacedChange, ...], tuple[PlacedCatchlight, ...]]
"""The parts of a `Picture` that a light decides about: `rest`, `changes` and `catchlights`."""


def mixed(
    rest: np.ndarray, changes: Sequence[PlacedChange], catchlights: Sequence[PlacedCatchlight], strength: float
) -> WhatLightDoes:
    """What the new light does to a person, mixed with the photo as it is.

    Args:
        strength: the share of the new light's picture, [0, 1].
    """
    share = np.float32(strength)

    def with_one(gain: np.ndarray) -> np.ndarray:
        return cv2.addWeighted(gain, strength, np.ones_like(gain), 1 - strength, 0)

    return (
        with_one(rest),
        tuple(replace(one, gain=with_one(one.gain), offset=one.offset * share) for one in changes),
        tuple(replace(one, added=one.added * share) for one in catchlights if strength),
    )
