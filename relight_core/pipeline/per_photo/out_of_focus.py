"""Softens the matte's outlines where they are out of focus in the photo.

Closed-form matting, edge-aware filters and the colours of hair all sharpen a matte. But the outline of hair behind a
face in focus, or of a shoulder in front of it, is soft in the photo. With a sharp matte, a person who is darkened in
front of a bright wall would look as if cut out with scissors.
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
"""Standard deviations, in pixels of each copy, of the two blurs under which slopes are compared."""
_COPIES = 3
"""Copies in which softness is measured, each half as large as the one before, for outlines twice as soft."""
_TOO_SOFT = (0.7, 1.0)
"""Ramp of an outline's softness, as a share of the coarser blur, over which the next copy's measurement takes over."""
_ALONG_PX = 15.0
"""Standard deviation, in pixels of the matte, of the blur by which softness is averaged along an outline."""
_SOFT_PX = (1.5, 2.5)
"""Ramp of softness over which an outline becomes out of focus."""
_CONTRAST = (0.02, 0.06)
"""Ramp of contrast, in displayed values, over which softness is trusted: fainter outlines may be noise."""
_BLURS_PX = (0.0, 1.0, 2.0, 4.0, 8.0)
"""Standard deviations of the blurs between which `_blurred_by` interpolates."""
_HARDLY = 1 / 512
"""Smaller changes are dropped: soft pixels cost time, even if only a thousandth of them is wall."""


def softened(share: np.ndarray, guide: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Make a matte's outlines as soft as the photo's where these are out of focus.

    An outline is blurred by the difference in softness. Sharp outlines, strands in focus, and outlines without contrast
    don't change.

    Args:
        share: (h, w) in [0, 1], at most some thousand pixels wide.
        guide: (h, w) brightness of the photo as displayed, [0, 1].

    Returns:
        The matte, (h, w) float32 in [0, 1], and the degree to which the outlines around each place are out of focus,
        (h, w) in [0, 1].
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
    """How an outline looks in an image, around each place of a small copy.

    Attributes:
        blur_px: (k, l) its softness, as the standard deviation of a blur in pixels of the matte.
        contrast: (k, l) the step between both sides.
    """

    blur_px: np.ndarray
    contrast: np.ndarray

    def unless_too_soft(self, softer: _Softness, limit_px: float) -> _Softness:
        """This measurement, replaced by a smaller copy's where an outline is too soft for this one."""
        too_soft = ramp(self.blur_px / limit_px, *_TOO_SOFT)
        beyond_px = np.maximum(softer.blur_px, _TOO_SOFT[0] * limit_px)
        blur_px = self.blur_px + too_soft * (beyond_px - self.blur_px)
        return _Softness(blur_px, self.contrast + too_soft * (softer.contrast - self.contrast))


def _softness(guide: np.ndarray, share: np.ndarray, ends: np.ndarray) -> tuple[_Softness, _Softness]:
    """The softness of the matte's outlines in the photo (h, w) and in the matte (h, w); they lie where `ends` > 0."""
    copies = [_softness_in_copy(guide, share, ends, copy) for copy in range(_COPIES)]
    photo, own = copies[0]
    for copy in range(1, _COPIES):
        limit_px = _COARSER_PX * 2 ** (copy - 1)
        softer_photo, softer_own = copies[copy]
        photo, own = photo.unless_too_soft(softer_photo, limit_px), own.unless_too_soft(softer_own, limit_px)
    return photo, own


def _halved(size: tuple[int, int], times: int) -> tuple[int, int]:
    """A size halved some times, at least 1."""
    height, width = (max(round(length / 2**times), 1) for length in size)
    return height, width


def _softness_in_copy(guide: np.ndarray, share: np.ndarray, ends: np.ndarray, copy: int) -> list[_Softness]:
    """`_softness` as measured in one copy.

    If an edge of softness b is blurred further by s, the squared slopes across it sum to contrast² /
    (2 sqrt(pi (b² + s²))). So the ratio of the sums under two blurs gives b (as the ratio of slopes does in Zhuo and
    Sim, "Defocus map estimation from a single image", Pattern Recognition 44, 2011), and the sum itself the contrast.
    """
    size, smallest = _halved(share.shape, copy), _halved(share.shape, _COPIES - 1)
    guide, share, ends = (resize_area(image, size) for image in (guide, share, ends))
    reach = 2 * _COARSER_PX
    near = np.clip(reach + 0.5 - distance_to(ends > 0), 0, 1)
    seen = np.maximum(_about(near, smallest), 1e-6) / (2 * reach + 1)
    right, down = _slopes(share, _COARSER_PX)
    # Unit vectors across the outline, along the matte's gradient, times the weight of being near it.
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
    """Softness from the sums of squared slopes under both blurs, (k, l) each.

    Args:
        px: size of the copy's pixels, in pixels of the matte.
    """
    fading = np.maximum(finer / np.maximum(coarser, 1e-12), 1.0005) ** 2
    squared = np.maximum((_COARSER_PX**2 - fading * _FINER_PX**2) / (fading - 1), 0)
    contrast = np.sqrt(finer * 2 * np.sqrt(np.pi * (squared + _FINER_PX**2)))
    return _Softness(np.sqrt(squared) * px, contrast)


def _slopes(image: np.ndarray, blur_px: float) -> tuple[np.ndarray, np.ndarray]:
    """The gradient of a blurred image (k, l) per pixel, to the right and downward, (k, l) each."""
    window = 2 * math.ceil(3 * blur_px) + 1
    blurred = cv2.GaussianBlur(image, (window, window), blur_px)
    return cv2.Scharr(blurred, cv2.CV_32F, 1, 0, scale=1 / 32), cv2.Scharr(blurred, cv2.CV_32F, 0, 1, scale=1 / 32)


def _about(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """An image (k, l), shrunk to a size and blurred along outlines by `_ALONG_PX`."""
    return cv2.GaussianBlur(resize_area(image, size), (0, 0), _ALONG_PX / 2 ** (_COPIES - 1))


def _blurred_by(share: np.ndarray, blur_px: np.ndarray) -> np.ndarray:
    """A matte (h, w) blurred by a standard deviation that varies, (k, l) in pixels of the matte."""
    result = sharper = share
    widest_px, blur_px = blur_px.max(), resize_smooth(blur_px, share.shape)
    for less_px, more_px in zip(_BLURS_PX[:-1], _BLURS_PX[1:], strict=True):
        if widest_px <= less_px:
            break
        blurred = cv2.GaussianBlur(share, (0, 0), more_px)
        result = result + ramp(blur_px, less_px, more_px) * (blurred - sharper)
        sharper = blurred
    return np.where(np.abs(result - share) < _HARDLY, share, np.clip(result, 0.0, 1.0))
