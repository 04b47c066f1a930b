"""The light that lies over all of a photo: blacks that are grey, or of a colour.

A matte grade lifts them, one that is split into two tones makes them blue, a print under glass and a hazy lens do both,
and so does the air between: mist, smoke, and water.
No light on the person multiplies that. Were it taken for a part of hair or of the dark between lips, it would be made
sixteen times as bright with them, and fade to black in the shadow of another light.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.imaging.colour import luminance
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
_NOTHING, _THICK = 0.8, 0.6
"""Shares of white: a haze that leaves nothing of a photo, and the thickest under which a face is still seen."""
_SMOOTH_PX = 2.0
"""Noise and compression make single pixels darker than the haze."""
_SPREAD, _HAZY = 1.4, 1.25
"""Over how much the darkest hundredth of a hazy photo spreads. That of 17 portraits, of their heads and of their faces
alone spreads over 1.55 and more, overexposed by up to 3 stops; under a haze of 0.12 over at most 1.25."""
_GRAINY, _CLEAN = 2.0, 1.5
"""How many times the darkest hundredth of single pixels what has been added may be."""
_FINE, _FINE_PERCENT = 1 / 256, 99.5
_BLURRED, _SHARP = 0.024, 0.035
"""Contrast within a 256th of the longer side, as a share of the brightest. In a blurred photo nothing is dark either:
that of the same portraits is 0.052 and more, of ones blurred by a hundredth of their width up to 0.023."""


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


def light_over(image: np.ndarray, counted: np.ndarray, white: float = 1.0) -> np.ndarray:
    """What has been added to all of a photo, of which some is dark or nothing is.

    Args:
        image: (H, W, 3) linear, >= 0, of the photo no longer than `LOOKED_AT`.
        counted: (H, W) bool, which pixels have a say.
        white: what the photo has for white, in its units; > 0.

    Returns:
        (3,) float32 linear.
    """
    return np.maximum(black_level_of(image[counted], white), haze_of(image, counted, white))


def black_level_of(pixels: np.ndarray, white: float = 1.0) -> np.ndarray:
    """What has been added to all of a photo's pixels, by how little their darkest differ.

    Light falls off in the folds of black cloth, too: without anything added, the darkest pixels differ by factors. What
    is found is rather too little than too much, and nothing in a photo that is as dark somewhere as photos are.

    Args:
        pixels: (N, 3), those of an image that have a say.
        white: see `light_over`.

    Returns:
        (3,) float32 linear, [0, 0.06] of white; of a photo that is flat up to its darkest.
    """
    if not len(pixels):
        return np.zeros(3, np.float32)
    darkest, dark = _darkest(pixels)
    found = _added(darkest, dark)
    added = np.minimum(found, _MOST * white) * ramp(darkest, _NO_BLACK * white, _MOST * white)
    if darkest.max() > _MOST * white:
        added += _flatness(pixels, float(darkest.min()), white) * (found - added)
    return (added * ramp(float(added.max()), _NEXT_TO_NONE * white, _SOME * white)).astype(np.float32)


def haze_of(image: np.ndarray, counted: np.ndarray, white: float = 1.0) -> np.ndarray:
    """What has been added to all of a photo of which nothing is dark, however much: the light in a haze or a flare.

    Args:
        image, counted, white: see `light_over`.

    Returns:
        (3,) float32 linear; nothing for a blurred photo, which has no dark spots either, or one of mere noise.
    """
    if not counted.any():
        return np.zeros(3, np.float32)
    darkest, dark = _darkest(cv2.GaussianBlur(image, (0, 0), _SMOOTH_PX)[counted])
    found = _added(darkest, dark)
    most = float(found.max()) / white
    hazy = ramp(_ratio(dark, darkest), _SPREAD, _HAZY) * ramp(most, _NEXT_TO_NONE, _SOME) * ramp(most, _NOTHING, _THICK)
    if hazy > 0:
        hazy *= _sharpness(image) * ramp(_ratio(found, _darkest(image[counted])[1]), _GRAINY, _CLEAN)
    return (hazy * found).astype(np.float32)


def _darkest(pixels: np.ndarray) -> np.ndarray:
    """(2, 3): the darkest of pixels (N, 3), and the brightest of their darkest hundredth."""
    places = [int(share * len(pixels)) for share in (_DARKEST_SHARE, _DARK_SHARE)]
    # NumPy takes three times as long along the first axis.
    return np.partition(np.ascontiguousarray(pixels.T), places, axis=1)[:, places].T


def _added(darkest: np.ndarray, dark: np.ndarray) -> np.ndarray:
    """(3,): without how much they would spread as those of other photos do."""
    return np.maximum((_LEAST_RATIO * darkest - dark) / (_LEAST_RATIO - 1), 0)


def _ratio(brighter: np.ndarray, darker: np.ndarray) -> float:
    """By how much one colour is brighter than another, in the channel where it is most."""
    return float((brighter / np.maximum(darker, 1e-12)).max())


def _sharpness(image: np.ndarray) -> float:
    """Whether a photo (H, W, 3) has fine detail, from 0 to 1."""
    grey = luminance(image)
    fine = np.abs(grey - cv2.GaussianBlur(grey, (0, 0), max(_FINE * max(grey.shape), 0.5)))
    contrast, brightest = (float(np.percentile(of, _FINE_PERCENT)) for of in (fine, grey - grey.min()))
    # What a photo of one colour has of either is rounding.
    return ramp(contrast / max(brightest, 1e-3 * float(grey.max()), 1e-12), _BLURRED, _SHARP)


def _flatness(pixels: np.ndarray, darkest: float, white: float) -> float:
    """Whether all of a photo (N, 3) lies in few stops far below white, from 0 to 1: no skin, eyes and hair do."""
    brightest = float(np.percentile(pixels.max(axis=1), _BRIGHTEST_PERCENT))
    return ramp(brightest / white, _CLIPPED, _UNCLIPPED) * ramp(brightest / max(darkest, 1e-12), _DEEP, _FLAT)
