"""Closed-form matting (Levin, Lischinski and Weiss 2008): a mask's soft edges, by the photo's colours.

Within a small window the matte is taken for a linear function of the colours; among all mattes that are nearly so
the one nearest to a first guess, as far as that is sure, is found by conjugate gradients. The matting Laplacian is
never built: its product with a matte is that matte less its guided filter, by box sums (He, Sun and Tang 2010).
"""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

_RADIUS = 1
_COLOUR_DEVIATION = 0.01
_PULL = 0.15
_LEAST_PULL = 1e-3
_STEPS = 80
_ACCURACY = 1e-3


def closed_form_matte(guide: np.ndarray, likely: np.ndarray) -> np.ndarray:
    """The matte that colours and a guess agree on.

    Args:
        guide: (h, w, 3) sRGB in [0, 1], finite.
        likely: (h, w) in [0, 1], probability of person; near 0 and 1 it is believed, about 0.5 hardly.

    Returns:
        (h, w) float32 in [0, 1]; the guess itself where there is no room for a window.
    """
    if min(likely.shape) <= 2 * _RADIUS:
        return np.clip(likely, 0, 1).astype(np.float32)
    likely = likely.astype(np.float64)
    pull = _PULL * np.square(2 * likely - 1) + _LEAST_PULL
    laplacian = _MattingLaplacian(guide.astype(np.float64))
    matte = _conjugate_gradients(lambda p: laplacian(p) + pull * p, pull * likely, likely, laplacian.covering + pull)
    return np.clip(matte, 0, 1).astype(np.float32)


class _MattingLaplacian:
    """Its product with a matte; windows that reach beyond the image are left out.

    Colours lie in planes, (3, h, w): box sums and products are over each of them.
    """

    def __init__(self, guide: np.ndarray):
        self._guide = np.ascontiguousarray(np.moveaxis(guide, -1, 0))
        self._whole = np.zeros(guide.shape[:2])
        self._whole[_RADIUS:-_RADIUS, _RADIUS:-_RADIUS] = 1
        self.covering = _sum(self._whole)
        self._mean = _of_planes(_mean, self._guide)
        covariance = np.stack(
            [self._covariance(plane, mean) for plane, mean in zip(self._guide, self._mean, strict=True)]
        )
        regular = np.moveaxis(covariance, (0, 1), (-2, -1)) + _COLOUR_DEVIATION**2 * np.eye(3)
        self._inverse = np.ascontiguousarray(np.moveaxis(np.linalg.inv(regular), (-2, -1), (0, 1)))

    def _covariance(self, image: np.ndarray, mean: np.ndarray) -> np.ndarray:
        """(3, h, w) of the colours with an image (h, w) in each window, given its mean there."""
        return _of_planes(_mean, self._guide * image) - self._mean * mean

    def __call__(self, matte: np.ndarray) -> np.ndarray:
        mean = _mean(matte)
        slope = _dot(self._inverse, self._covariance(matte, mean)) * self._whole
        level = mean * self._whole - _dot(slope, self._mean)
        return self.covering * matte - _dot(_of_planes(_sum, slope), self._guide) - _sum(level)


def _dot(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Sum over the first axis of both, three planes: einsum takes twice as long."""
    return first[0] * second[0] + first[1] * second[1] + first[2] * second[2]


def _of_planes(measure: Callable[[np.ndarray], np.ndarray], planes: np.ndarray) -> np.ndarray:
    return np.stack([measure(plane) for plane in planes])


def _sum(image: np.ndarray) -> np.ndarray:
    window = (2 * _RADIUS + 1,) * 2
    return cv2.boxFilter(image, -1, window, normalize=False, borderType=cv2.BORDER_CONSTANT)


def _mean(image: np.ndarray) -> np.ndarray:
    return _sum(image) / (2 * _RADIUS + 1) ** 2


def _conjugate_gradients(product, right: np.ndarray, start: np.ndarray, diagonal: np.ndarray) -> np.ndarray:
    """Solve product(x) = right for a symmetric positive product, preconditioned by its diagonal."""
    result = start.copy()
    left = right - product(result)
    eased = left / diagonal
    direction, power = eased.copy(), float((left * eased).sum())
    enough = (_ACCURACY**2) * max(power, 1e-30)
    for _ in range(_STEPS):
        if power <= enough:
            break
        answer = product(direction)
        step = power / float((direction * answer).sum())
        result += step * direction
        left -= step * answer
        eased = left / diagonal
        before, power = power, float((left * eased).sum())
        direction = eased + (power / before) * direction
    return result
