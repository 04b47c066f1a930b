"""Where shadows end on the skin in a photo, and what a light that takes them out makes of it there.

Skin is of one colour, so a steep step of its luminance is the light's. A gain that undoes it has as steep a step. Known
on a lattice that is coarser than the photo's edge, it leaves a dark line beside a bright one.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.imaging.colour import luminance
from relight_core.imaging.half_floats import within_halves
from relight_core.imaging.masks import bounds
from relight_core.imaging.ramp import ramp

_DARK = 0.02
_STEP, _SHARP_STEP, _GAIN_STEP = (0.3, 0.6), (0.2, 0.4), (0.15, 0.4)
"""By how much, in logs, luminance and gain differ between neighbours' neighbours where there may be a step, and surely
is one; of a sharp one, by how much more than along a straight slope."""
_HOLE_PX = 5
_SPECK_PX, _FINE_SPECK_PX, _FINE = 3, 5, 4
"""Sides of the squares for medians on a lattice, the latter from so many times the networks' size on."""
_AROUND, _TWICE_AS_FAR = np.ones((3, 3), np.uint8), np.ones((5, 5), np.uint8)


@dataclass(frozen=True, eq=False)
class ShadowSteps:
    """The steps on a lattice that are too sharp for it.

    Attributes:
        within: rows and columns about all of them.
        picture: (H, W, 3) linear, the photo there.
        share: (H, W) in [0, 1], how surely each pixel is at one.
    """

    within: tuple[slice, slice]
    picture: np.ndarray
    share: np.ndarray

    @classmethod
    def find(cls, skin: np.ndarray, steep: np.ndarray, plain: np.ndarray, large: np.ndarray) -> ShadowSteps | None:
        """Find them on a lattice; None where there are none.

        Args:
            skin, steep: (s, s) in [0, 1], how surely there is bare skin, and a step, at the networks' size.
            plain: (S, S) `reciprocal` on the lattice, without specks.
            large: (S, S, 3) linear, the photo there.
        """
        # Beside hair or a background the lattice's pixels have some of that in them.
        amid_skin = np.minimum(cv2.erode(skin, _AROUND), cv2.dilate(steep, _AROUND))
        nearby = cv2.resize(amid_skin, large.shape[1::-1], interpolation=cv2.INTER_LINEAR)
        share = cv2.blur(nearby * sharpness(plain), (3, 3))
        within = bounds(share)
        return cls(within, within_halves(large[within]), share[within]) if within[0].stop else None

    def taken_out(
        self, gain: np.ndarray, offset: np.ndarray, of_light: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """The same change of the lattice's picture, but of a finer one without lines where the gain undoes a step.

        There the lattice's own pixels, relit, replace the photo's, as an offset. A gain that has no step leaves the
        photo's as they are.

        Args:
            gain, offset: (S, S, 3) linear, on the lattice.
            of_light: (S, S) luminance of the gain that tells where a step is undone; None for that of `gain`. What
                sliders do to the gain must not change where: more shadow would be brighter than less there.
        """
        part = gain[self.within]
        undoing = luminance(part) if of_light is None else of_light[self.within]
        share = self.share * ramp(_log_range(undoing + np.float32(_DARK)), *_GAIN_STEP)
        share = cv2.merge([share.astype(np.float32)] * 3)
        gain, offset = gain.copy(), offset.copy()
        gain[self.within] = part * (1 - share)
        offset[self.within] += share * part * self.picture
        return gain, offset


def reciprocal(linear: np.ndarray) -> np.ndarray:
    """(S, S) one over the luminance of an image (S, S, 3), of no less than a dark one: what undoes a shadow on skin."""
    grey = luminance(np.clip(np.nan_to_num(linear, nan=0.0), 0, 1))
    return np.float32(1 / (grey + _DARK))


def without_specks(over_luminance: np.ndarray, factor: int) -> np.ndarray:
    """`reciprocal` without the pores and freckles of skin; slopes and steps stay where they are.

    Args:
        over_luminance: (f s, f s), of what is (s, s) at the networks' size.
        factor: f.
    """
    return cv2.medianBlur(over_luminance, _SPECK_PX if factor < _FINE else _FINE_SPECK_PX)


def without_holes(over_luminance: np.ndarray) -> np.ndarray:
    """`reciprocal` at the networks' size without what is small and dark: nostrils and moles are no shadows' ends."""
    return cv2.morphologyEx(over_luminance, cv2.MORPH_OPEN, np.ones((_HOLE_PX, _HOLE_PX), np.uint8))


def steepness(over_luminance: np.ndarray) -> np.ndarray:
    """(S, S) in [0, 1] how surely there is a step of `reciprocal`."""
    return ramp(_log_range(over_luminance), *_STEP)


def sharpness(over_luminance: np.ndarray) -> np.ndarray:
    """(S, S) in [0, 1] how surely there is a step of `reciprocal` that is finer than its pixels.

    Pixels hold a slope, however steep: a picture of more pixels keeps its pores there.
    """
    beyond_slope = 2 * _log_range(over_luminance) - _log_range(over_luminance, _TWICE_AS_FAR)
    return ramp(beyond_slope, *_SHARP_STEP)


def _log_range(values: np.ndarray, around: np.ndarray = _AROUND) -> np.ndarray:
    return np.log(cv2.dilate(values, around) / cv2.erode(values, around))
