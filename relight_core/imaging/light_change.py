"""What a light does to a photo, as a gain and an offset of its pixels, in linear light; `view_of_photo` finds both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

LARGEST_GAIN = 16.0
"""By how many times a pixel of the photo is brightened at the most, in whichever way its light is changed."""


@dataclass(frozen=True, eq=False)
class LightChange:
    """relit = gain * photo + offset.

    Attributes:
        gain: (S, S, 3) float32, >= 0.
        offset: (S, S, 3) float32, >= 0.
        shine: (S, S, 3) float32, >= 0: by how much a unit of gloss raises the gain.
        veil: (S, S, 3) float32, [0, 1]: by how much it raises the offset.
        lift: by how much diffuse light (S, S, 3) raises the gain, (S, S, 3) >= 0; None where it, too, is a matter of
            the offset.
    """

    gain: np.ndarray
    offset: np.ndarray
    shine: np.ndarray
    veil: np.ndarray
    lift: Callable[[np.ndarray], np.ndarray] | None = None

    def apply(self, photo: np.ndarray) -> np.ndarray:
        """A picture of the maps' size relit: (S, S, 3), linear."""
        return self.gain * photo + self.offset

    def moved(self, kept: np.ndarray, gloss: np.ndarray, lifted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Gain and offset with a share of the relit picture kept, and gloss and diffuse light added to it.

        Args:
            kept, gloss, lifted: (S, S, 3), >= 0, the first <= 1.
        """
        if self.lift is None:
            return self.gain * kept, self.offset * kept + gloss + lifted
        gain, offset = self.gain * kept + gloss * self.shine, self.offset * kept + gloss * self.veil
        return _with_added(gain, self.lift(lifted)), offset


def share_in_reach(gain: np.ndarray) -> np.ndarray:
    """By what to multiply a gain (h, w, 3) >= 0 so that none of its colours is above LARGEST_GAIN; (h, w, 3) in (0, 1].

    It keeps the gain's colour: dark hair in a warm light would turn green.
    """
    return LARGEST_GAIN / np.maximum(_largest(gain), LARGEST_GAIN)


def _with_added(gain: np.ndarray, more: np.ndarray) -> np.ndarray:
    """The sum, but of what is added no more than LARGEST_GAIN leaves room for."""
    room = np.maximum(LARGEST_GAIN - _largest(gain), 0.0)
    return gain + more * np.minimum(1.0, room / np.maximum(_largest(more), 1e-6))


def _largest(image: np.ndarray) -> np.ndarray:
    """The largest of three colours, in all three channels: (h, w, 3); NumPy's own maximum is twenty times as slow."""
    red, green, blue = cv2.split(image)
    return cv2.merge([cv2.max(cv2.max(red, green), blue)] * 3)
