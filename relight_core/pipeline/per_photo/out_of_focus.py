"""Outlines that are out of focus in the photo are so in its matte.

Closed-form matting, filters along edges and the colours of hair all sharpen a matte. Where the lens drew an outline
soft, that of hair behind a face in focus or of a shoulder before it, somebody darkened before a bright wall would have
a jagged edge as if cut out with scissors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.imaging.masks import distance_to
from relight_core.imaging.ramp import ramp
from relight_core.imaging.resampling import resize_area, resize_smooth

_FINER_PX, _COARSER_PX = 1.5, 3.0
"""The blurs between which slopes are compared, standard deviations in pixels of each copy."""
_COPIES = 3
"""Each half as large as the one before, for outlines twice as soft."""
_TOO_SOFT = (0.7, 1.0)
"""From what part of the coarser blur on the next copy says how soft an outline is, and it alone."""
_ALONG_PX = 15.0
"""How far along an outline softness is averaged, in pixels of the matte."""
_SOFT_PX = (1.5, 2.5)
_CONTRAST = (0.02, 0.06)
"""In displayed values: what is fainter may be noise, and says little about how soft an outline is."""
_BLURS_PX = (0.0, 1.0, 2.0, 4.0, 8.0)
_HARDLY = 1 / 512
"""What changes by less stays: pixels of which a thousandth is wall would cost as much as those that are half wall."""


def softened(share: np.ndarray, guide: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A matte whose outlines are as soft as the photo's, where these are out of focus.

    An outline is blurred by what it lacks. Sharp ones, strands in focus, and what stands out from nothing stay.

    Args:
        share: (h, w) in [0, 1], some thousand pixels wide at the most.
        guide: (h, w) brightness of the photo as displayed, [0, 1].

    Returns:
        (h, w) float32 in [0, 1] the matte, and (h, w) in [0, 1] how far the outlines about each place are out of
        focus.
    """
    share = np.ascontiguousarray(share, np.float32)
    ends = cv2.morphologyEx((share > 0.5).astype(np.uint8), cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
    if not ends.any():
        return share, np.zeros_like(share)
    photo, own = _softness(np.ascontiguousarray(guide, np.float32), share, ends.astype(np.float32))
    out_of_focus = ramp(photo.blur_px, *_SOFT_PX) * ramp(photo.contrast, *_CONTRAST)
    lacking_px = out_of_focus * np.sqrt(np.maximum(photo.blur_px**2 - own.blur_px**2, 0))
    return _blurred_by(share, lacking_px), resize_smooth(out_of_focus, share.shape)


@dataclass(frozen=True, eq=False)
class _Softness:
    """How an image draws an outline, about each place of a small copy.

    Attributes:
        blur_px: (k, l) how soft, as the standard deviation of a blur in pixels of the matte.
        contrast: (k, l) the step between both sides.
    """

    blur_px: np.ndarray
    contrast: np.ndarray

    def unless_too_soft(self, softer: _Softness, limit_px: float) -> _Softness:
        """This, and a smaller copy's where an outline is about as soft as what this one can tell, or softer."""
        too_soft = ramp(self.blur_px / limit_px, *_TOO_SOFT)
        beyond_px = np.maximum(softer.blur_px, _TOO_SOFT[0] * limit_px)
        blur_px = self.blur_px + too_soft * (beyond_px - self.blur_px)
        return _Softness(blur_px, self.contrast + too_soft * (softer.contrast - self.contrast))


def _softness(guide: np.ndarray, share: np.ndarray, ends: np.ndarray) -> tuple[_Softness, _Softness]:
    """How a photo (h, w) and a matte (h, w) draw the matte's outlines, which lie where `ends` (h, w) is above 0."""
    copies = [_softness_in_copy(guide, share, ends, copy) for copy in range(_COPIES)]
    photo, own = copies[0]
    for copy in range(1, _COPIES):
        limit_px = _COARSER_PX * 2 ** (copy - 1)
        softer_photo, softer_own = copies[copy]
        photo, own = photo.unless_too_soft(softer_photo, limit_px), own.unless_too_soft(softer_own, limit_px)
    return photo, own


def _halved(size: tuple[int, int], times: int) -> tuple[int, int]:
    height, width = (max(round(length / 2**times), 1) for length in size)
    return height, width


def _softness_in_copy(guide: np.ndarray, share: np.ndarray, ends: np.ndarray, copy: int) -> list[_Softness]:
    """`_softness`, as far as it can be told in one copy.

    Across an edge that is soft by b, the squared slopes under a further blur by s add up to contrast² /
    (2 sqrt(pi (b² + s²))). How they fade from one blur to another therefore tells b (as the ratio of slopes does in
    Zhuo and Sim, "Defocus map estimation from a single image", Pattern Recognition 44, 2011), and what they add up to
    the contrast.
    """
    size, smallest = _halved(share.shape, copy), _halved(share.shape, _COPIES - 1)
    guide, share, ends = (resize_area(image, size) for image in (guide, share, ends))
    reach = 2 * _COARSER_PX
    near = np.clip(reach + 0.5 - distance_to(ends > 0), 0, 1)
    seen = np.maximum(_about(near, smallest), 1e-6) / (2 * reach + 1)
    right, down = _slopes(share, _COARSER_PX)
    # Across the outline, where the matte rises straight; 0 away from it.
    across = np.sqrt(near) / np.maximum(cv2.magnitude(right, down), 1e-6)
    right, down = right * across, down * across

    def added_up(image: np.ndarray, blur_px: float) -> np.ndarray:
        to_the_right, downward = _slopes(image, blur_px)
        to_the_right *= right
        downward *= down
        to_the_right += downward
        return _about(cv2.multiply(to_the_right, to_the_right), smallest) / seen

    return [_as_softness(added_up(image, _FINER_PX), added_up(image, _COARSER_PX), 2**copy) for image in (guide, share)]


def _as_softness(finer: np.ndarray, coarser: np.ndarray, px: int) -> _Softness:
    """From what squared slopes add up to under both blurs, (k, l) each, in a copy with pixels of `px` of the matte."""
    fading = np.maximum(finer / np.maximum(coarser, 1e-12), 1.0005) ** 2
    squared = np.maximum((_COARSER_PX**2 - fading * _FINER_PX**2) / (fading - 1), 0)
    contrast = np.sqrt(finer * 2 * np.sqrt(np.pi * (squared + _FINER_PX**2)))
    return _Softness(np.sqrt(squared) * px, contrast)


def _slopes(image: np.ndarray, blur_px: float) -> tuple[np.ndarray, np.ndarray]:
    """How much a blurred image (k, l) rises per pixel to the right, and downward, (k, l) each."""
    window = 2 * math.ceil(3 * blur_px) + 1
    blurred = cv2.GaussianBlur(image, (window, window), blur_px)
    return cv2.Scharr(blurred, cv2.CV_32F, 1, 0, scale=1 / 32), cv2.Scharr(blurred, cv2.CV_32F, 0, 1, scale=1 / 32)


def _about(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """An image (k, l) averaged about each place of a copy of some size."""
    return cv2.GaussianBlur(resize_area(image, size), (0, 0), _ALONG_PX / 2 ** (_COPIES - 1))


def _blurred_by(share: np.ndarray, blur_px: np.ndarray) -> np.ndarray:
    """A matte (h, w) blurred by another standard deviation at each place, (k, l) in pixels of the matte."""
    result = sharper = share
    widest_px, blur_px = blur_px.max(), resize_smooth(blur_px, share.shape)
    for less_px, more_px in zip(_BLURS_PX[:-1], _BLURS_PX[1:], strict=True):
        if widest_px <= less_px:
            break
        blurred = cv2.GaussianBlur(share, (0, 0), more_px)
        result = result + ramp(blur_px, less_px, more_px) * (blurred - sharper)
        sharper = blurred
    return np.where(np.abs(result - share) < _HARDLY, share, np.clip(result, 0.0, 1.0))
