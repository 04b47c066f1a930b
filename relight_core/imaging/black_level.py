"""The light that lies over all of a photo: blacks that are grey, or of a colour.

A matte grade lifts them, one that is split into two tones makes them blue, a print under glass and a hazy lens do both.
No light on the person multiplies that. Were it taken for a part of hair or of the dark between lips, it would be made
sixteen times as bright with them, and fade to black in the shadow of another light.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from relight_core.imaging.ramp import ramp

LOOKED_AT = 1024
"""Pixels along the longer side in which a photo is looked at: pupils and nostrils have to be some of them."""

_DARKEST_SHARE, _DARK_SHARE = 2e-5, 0.01
"""Of all pixels, how many may be darker than what counts as the darkest, and than what counts as dark."""
_LEAST_RATIO = 2.2
"""Over at least as much spreads the darkest hundredth of any of 33 photos, some overexposed by 1.3 stops."""
_NEXT_TO_NONE, _SOME = 0.001, 0.003
_MOST, _NO_BLACK = 0.06, 0.1
"""Shares of white, as those before. A photo whose darkest is brighter has no black to tell by, unless it is flat."""
_FLAT, _DEEP = 5.0, 8.0
"""How many times its darkest is the brightest of a photo that is flat, and of one that need not be: of portraits it is
20 times and more, also where they are overexposed by 2.3 stops, or only a blurred face without hair and clothes."""
_BRIGHTEST_PERCENT = 99.8
_UNCLIPPED, _CLIPPED = 0.7, 0.9
"""Shares of white that the brightest of a flat photo may have: of an overexposed one the half may be gone."""


@dataclass(frozen=True, eq=False)
class Black:
    """What lies over all of a photo, in the photo's units.

    Attributes:
        level: (3,) float32 linear.
        white: what is as bright without it.
    """

    level: np.ndarray
    white: float = 1.0

    @property
    def left(self) -> np.ndarray:
        """(3,) float32, what it leaves of the light that it lies over."""
        return 1 - self.level / np.float32(self.white)


def black_level_of(pixels: np.ndarray, white: float = 1.0) -> np.ndarray:
    """What has been added to all of a photo's pixels, by how little their darkest differ.

    Light falls off in the folds of black cloth, too: without anything added, the darkest pixels differ by factors. What
    is found is rather too little than too much, and nothing in a photo that is as dark somewhere as photos are.

    Args:
        pixels: (N, 3) linear, >= 0, of the photo no longer than `LOOKED_AT`.
        white: what the photo has for white, in its units; > 0.

    Returns:
        (3,) float32 linear, [0, 0.06] of white; of a photo that is flat up to its darkest.
    """
    if not len(pixels):
        return np.zeros(3, np.float32)
    places = [int(share * len(pixels)) for share in (_DARKEST_SHARE, _DARK_SHARE)]
    # NumPy takes three times as long along the first axis.
    darkest, dark = np.partition(np.ascontiguousarray(pixels.T), places, axis=1)[:, places].T
    found = np.maximum((_LEAST_RATIO * darkest - dark) / (_LEAST_RATIO - 1), 0)
    added = np.minimum(found, _MOST * white) * ramp(darkest, _NO_BLACK * white, _MOST * white)
    if darkest.max() > _MOST * white:
        added += _flatness(pixels, float(darkest.min()), white) * (found - added)
    return (added * ramp(float(added.max()), _NEXT_TO_NONE * white, _SOME * white)).astype(np.float32)


def _flatness(pixels: np.ndarray, darkest: float, white: float) -> float:
    """Whether all of a photo (N, 3) lies in few stops far below white, from 0 to 1: no skin, eyes and hair do."""
    brightest = float(np.percentile(pixels.max(axis=1), _BRIGHTEST_PERCENT))
    return ramp(brightest / white, _CLIPPED, _UNCLIPPED) * ramp(brightest / max(darkest, 1e-12), _DEEP, _FLAT)
