"""What scenes are drawn with: colours, unevenness, shapes of some stuff, pictures laid over each other."""

from __future__ import annotations

import cv2
import numpy as np

from relight_core.dataset.painting.texture import TexturePool

SIZE = 384
"""Side of a drawn scene; views of it are cut out."""


def falloff(size: int, rng: np.random.Generator) -> np.ndarray:
    """A wall is lit unevenly: (size, size, 1)."""
    axis = (np.arange(size, dtype=np.float32) + 0.5) / size * 2 - 1
    slope_x, slope_y, bow = rng.normal(0, 0.35, 3)
    stops = slope_x * axis[None] + slope_y * axis[:, None] + bow * (axis[None] ** 2 + axis[:, None] ** 2)
    return np.exp2(stops)[..., None]


def any_colour(rng: np.random.Generator) -> np.ndarray:
    """A paint or a stuff, linear (3,): mostly muted."""
    grey = rng.beta(0.9, 1.3)
    tint = np.exp(rng.normal(0, 0.12 if rng.random() < 0.6 else 0.7, 3))
    return np.clip(grey * tint / tint.mean(), 0.003, 1.2).astype(np.float32)


def unevenness(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Noise of zero mean and unit deviation, (SIZE, SIZE, 1)."""
    return cv2.resize(pool.noise(rng), (SIZE, SIZE))[..., None]


def any_shape(image: np.ndarray, radius: float, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """One ellipse, box or ragged blob, plain, shaded or of some stuff."""
    mask = np.zeros((SIZE, SIZE), np.uint8)
    x, y = (int(v) for v in rng.integers(0, SIZE, 2))
    axes = np.maximum(radius * rng.uniform(0.4, 1.6, 2), 1).astype(int)
    kind = rng.integers(3)
    if kind == 0:
        cv2.ellipse(mask, (x, y), axes.tolist(), float(rng.uniform(0, 180)), 0, 360, 1, -1)
    elif kind == 1:
        box = cv2.boxPoints(((x, y), tuple(2.0 * axes), float(rng.normal(0, 20))))
        cv2.fillPoly(mask, [box.astype(np.int32)], 1)
    else:
        angles = np.sort(rng.uniform(0, 2 * np.pi, int(rng.integers(3, 10))))
        reach = axes.max() * rng.uniform(0.4, 1.2, len(angles))
        corners = np.stack([x + reach * np.cos(angles), y + reach * np.sin(angles)], 1)
        cv2.fillPoly(mask, [corners.astype(np.int32)], 1)
    stuff = np.broadcast_to(any_colour(rng), image.shape)
    if rng.random() < 0.3:
        stuff = cv2.resize(pool.picture(rng), (SIZE, SIZE)) * 2 ** rng.normal(0, 0.8)
    if rng.random() < 0.5:
        stuff = stuff * falloff(SIZE, rng)
    return np.where(mask[..., None] > 0, stuff, image)


def put(image: np.ndarray, part: np.ndarray, x: int, y: int) -> None:
    """Lay a picture over another in place, as far as it fits."""
    height, width = image.shape[:2]
    x0, y0, x1, y1 = max(x, 0), max(y, 0), min(x + part.shape[1], width), min(y + part.shape[0], height)
    if x0 < x1 and y0 < y1:
        image[y0:y1, x0:x1] = part[y0 - y : y1 - y, x0 - x : x1 - x]
