"""The relit crop back into the photo."""

from __future__ import annotations

import numpy as np

from relight_core.face.crop import Crop
from relight_core.imaging.resampling import resample_window

SOFT_EDGE = 0.1
"""Width of the default soft edge, as a fraction of the crop's side."""


def paste_crop(
    base: np.ndarray, relit: np.ndarray, crop: Crop, weight: np.ndarray | None = None
) -> np.ndarray:
    """Blend a crop into the photo at its place.

    Args:
        base: (H, W, 3) or (H, W) linear.
        relit: (S, S, 3) or (S, S) linear, any S.
        crop: where `relit` lies; parts beyond the photo are left out.
        weight: (T, T) in [0, 1], any T: 1 shows `relit`, 0 `base`. None fades towards the crop's edges.

    Returns:
        A new float32 array of the shape of `base`.
    """
    pasted = np.array(base, np.float32, order="C")
    place = _covered_pixels(crop, base.shape[:2])
    if place is None:
        return pasted
    x0, y0, x1, y1 = place
    if weight is None:
        weight = soft_edge(relit.shape[0])
    share = np.clip(_fit(weight, crop, place), 0.0, 1.0)
    share *= _coverage(crop.window[1], crop.window[3], y0, y1)[:, None]
    share *= _coverage(crop.window[0], crop.window[2], x0, x1)[None, :]
    if base.ndim == 3:
        share = share[..., None]
    under = pasted[y0:y1, x0:x1]
    under *= 1.0 - share
    under += share * _fit(relit, crop, place)
    return pasted


def soft_edge(size: int, width: float = SOFT_EDGE) -> np.ndarray:
    """A weight that is 1 inside and falls smoothly to 0 at the edges of a crop.

    Args:
        size: of the crop.
        width: of the falling part, as a fraction of the crop's side, above 0 and up to 0.5.

    Returns:
        (size, size) float32, [0, 1].
    """
    position = (np.arange(size) + 0.5) / size
    ramp = np.clip(np.minimum(position, 1.0 - position) / width, 0.0, 1.0)
    smooth = (ramp * ramp * (3.0 - 2.0 * ramp)).astype(np.float32)
    return smooth[:, None] * smooth[None, :]


def _covered_pixels(crop: Crop, size: tuple[int, int]) -> tuple[int, int, int, int] | None:
    """x0, y0, x1, y1 of the photo's pixels that the crop touches, or None."""
    low_x, low_y, high_x, high_y = crop.window
    x0, y0 = max(int(np.floor(low_x)), 0), max(int(np.floor(low_y)), 0)
    x1, y1 = min(int(np.ceil(high_x)), size[1]), min(int(np.ceil(high_y)), size[0])
    return (x0, y0, x1, y1) if x1 > x0 and y1 > y0 else None


def _fit(image: np.ndarray, crop: Crop, place: tuple[int, int, int, int]) -> np.ndarray:
    """The crop's image resampled to the photo's pixels."""
    x0, y0, x1, y1 = place
    corners = crop.from_photo(np.array([[x0, y0], [x1, y1]]), image.shape[0])
    return resample_window(image, tuple(corners.ravel()), (y1 - y0, x1 - x0))


def _coverage(low: float, high: float, first: int, last: int) -> np.ndarray:
    """(last - first,) share of each pixel that lies in [low, high]."""
    edges = np.arange(first, last)
    return np.clip(np.minimum(edges + 1, high) - np.maximum(edges, low), 0.0, 1.0).astype(np.float32)
