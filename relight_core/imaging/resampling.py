"""Resampling: whole images, and any window of an image, by exact area when shrinking."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from scipy import sparse

_LEAST_ALPHA = 1e-4
_VALUES_AT_ONCE = 2**20
"""What a processor keeps near itself."""


def resize_area(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Resize by averaging over areas, which keeps the mean; the right way to shrink.

    Args:
        image: (H, W) or (H, W, C), any real type.
        size: (height, width) of the result.

    Returns:
        float32 of the new size.
    """
    height, width = image.shape[:2]
    return resample_window(image, (0.0, 0.0, width, height), size)


def at_size(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """`resize_area` of (H, W) or (H, W, C) where another size is wanted; else the image itself, as float32."""
    return np.asarray(image, np.float32) if image.shape[:2] == size else resize_area(image, size)


def resize_cut_out(image: np.ndarray, alpha: np.ndarray, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """`at_size` of a picture in which what is transparent has no say.

    Args:
        image: (H, W, 3), not premultiplied.
        alpha: (H, W) in [0, 1].

    Returns:
        Image and alpha of the new size, float32; next to where nothing is seen, the image fades to black.
    """
    small = at_size(alpha, size)
    return at_size(image * alpha[..., None], size) / np.maximum(small, _LEAST_ALPHA)[..., None], small


def shrunk_size(size: tuple[int, int], longest_side: int | None) -> tuple[int, int]:
    """(height, width) of a picture shrunk so that no side is longer; never enlarged, and never without pixels."""
    height, width = size
    if longest_side is None or max(size) <= longest_side:
        return height, width
    scale = longest_side / max(size)
    return max(1, round(height * scale)), max(1, round(width * scale))


def resize_smooth(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Resize with smooth interpolation: bilinear for growing, by area where it shrinks.

    Fast, and never outside the range of the image's values: for gains, weights and masks.

    Args:
        image: (H, W) or (H, W, C) of at most 4 channels.
        size: (height, width) of the result.

    Returns:
        float32 of the new size.
    """
    if size[0] < image.shape[0] or size[1] < image.shape[1]:
        return resize_area(image, size)
    source = np.ascontiguousarray(image, np.float32)
    resized = cv2.resize(source, (size[1], size[0]), interpolation=cv2.INTER_LINEAR)
    return resized.reshape(*size, *image.shape[2:])


def resample_window(image: np.ndarray, window: tuple[float, float, float, float], size: tuple[int, int]) -> np.ndarray:
    """Resample a rectangle of an image, which may reach beyond it; its edge pixels continue outward.

    Along an axis that shrinks, each new pixel is the exact mean of the area it covers, fractions of
    pixels included; along one that grows, it is a Catmull-Rom interpolation, kept within the image's
    range of values.

    Args:
        image: (H, W) or (H, W, C), any real type.
        window: x0, y0, x1, y1 in pixel edges: pixel i spans i to i + 1.
        size: (height, width) of the result.

    Returns:
        float32 of the new size.
    """
    x0, y0, x1, y1 = window
    source = np.asarray(image, np.float32)
    if (x1 - x0, y1 - y0) == (size[1], size[0]) and _lies_on_pixels(window, source.shape[:2]):
        return source[int(y0) : int(y1), int(x0) : int(x1)].copy()
    if _is_whole_and_shrinks(source, window, size):
        return _shrunk(source, size)
    within_rows, vertical = _axis_weights(y0, y1, source.shape[0], size[0])
    within_columns, horizontal = _axis_weights(x0, x1, source.shape[1], size[1])
    # A face is a small part of a photo, whose other columns would cost as much.
    used = source[within_rows, within_columns]
    rows = _weighted_rows(vertical, used).reshape(size[0], used.shape[1], -1)
    columns = np.ascontiguousarray(rows.swapaxes(0, 1)).reshape(used.shape[1], -1)
    result = (horizontal @ columns).reshape(size[1], size[0], -1).swapaxes(0, 1)
    if (x1 - x0) < size[1] or (y1 - y0) < size[0]:
        result = np.clip(result, source.min(), source.max())
    return np.ascontiguousarray(result).reshape(*size, *source.shape[2:])


def _weighted_rows(weights: sparse.csr_array, image: np.ndarray) -> np.ndarray:
    """(count, w C) of an image (n, w) or (n, w, C) and weights (count, n), a few rows at a time.

    SciPy copies what does not lie in one piece, and of a large photo that takes longer than the sums.
    """
    values = image.reshape(len(image), -1)
    at_once = max(_VALUES_AT_ONCE * weights.shape[0] // max(values.size, 1), 1)
    parts = []
    for first in range(0, weights.shape[0], at_once):
        some = weights[first : first + at_once]
        read = slice(int(some.indices.min()), int(some.indices.max()) + 1)
        parts.append(some[:, read] @ values[read])
    return np.concatenate(parts)


def _is_whole_and_shrinks(source: np.ndarray, window: tuple[float, float, float, float], size: tuple[int, int]) -> bool:
    height, width = source.shape[:2]
    return window == (0, 0, width, height) and height >= size[0] and width >= size[1]


def _shrunk(source: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Exact area means of all of an image; OpenCV takes four channels at a time."""
    if source.ndim == 3 and source.shape[2] > 4:
        parts = np.split(source, range(4, source.shape[2], 4), axis=2)
        return np.concatenate([_shrunk(np.ascontiguousarray(part), size) for part in parts], axis=2)
    small = cv2.resize(source, (size[1], size[0]), interpolation=cv2.INTER_AREA)
    return small.reshape(*size, *source.shape[2:])


def _lies_on_pixels(window: tuple[float, float, float, float], size: tuple[int, int]) -> bool:
    x0, y0, x1, y1 = window
    whole = all(float(edge).is_integer() for edge in window)
    return whole and 0 <= x0 < x1 <= size[1] and 0 <= y0 < y1 <= size[0]


@lru_cache(maxsize=64)
def _axis_weights(start: float, stop: float, length: int, count: int) -> tuple[slice, sparse.csr_array]:
    """Which n pixels of an axis of `length` count, and their (count, n) weights in its part [start, stop].

    That part becomes `count` pixels; the rows of the weights sum to 1.
    """
    step = (stop - start) / count
    if step >= 1.0 - 1e-9:
        positions, weights = _area_taps(start, step, count)
    else:
        positions, weights = _cubic_taps(start, step, count)
    columns = np.clip(positions, 0, length - 1)
    rows = np.repeat(np.arange(count), positions.shape[1])
    used = slice(int(columns.min()), int(columns.max()) + 1)
    entries = (weights.ravel().astype(np.float32), (rows, columns.ravel() - used.start))
    return used, sparse.csr_array(sparse.coo_array(entries, shape=(count, used.stop - used.start)))


def _area_taps(start: float, step: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    low = start + step * np.arange(count)[:, None]
    positions = np.floor(low).astype(np.int64) + np.arange(int(np.ceil(step)) + 1)
    covered = np.minimum(positions + 1, low + step) - np.maximum(positions, low)
    covered = np.maximum(covered, 0.0)
    return positions, covered / covered.sum(axis=1, keepdims=True)


def _cubic_taps(start: float, step: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    centre = start + step * (np.arange(count)[:, None] + 0.5) - 0.5
    positions = np.floor(centre).astype(np.int64) + np.arange(-1, 3)
    t = np.abs(centre - positions)
    near = (1.5 * t - 2.5) * t * t + 1.0
    far = ((-0.5 * t + 2.5) * t - 4.0) * t + 2.0
    return positions, np.where(t < 1.0, near, np.where(t < 2.0, far, 0.0))
