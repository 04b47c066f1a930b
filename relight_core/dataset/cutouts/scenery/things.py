"""What stands before a background: trunks and columns, furniture, signs."""

from __future__ import annotations

import cv2
import numpy as np

from relight_core.dataset.cutouts.scenery.strokes import SIZE, any_colour, any_shape, unevenness
from relight_core.dataset.painting.texture import TexturePool


def with_trunks(image: np.ndarray, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Upright round things: trunks, columns, poles."""
    for _ in range(int(rng.integers(1, 4))):
        middle, half = rng.uniform(0, SIZE), rng.uniform(3, 60)
        y, x = np.mgrid[:SIZE, :SIZE].astype(np.float32)
        place = (x - middle - rng.normal(0, 0.15) * (y - SIZE / 2)) / half
        shade = np.clip(0.3 + 0.7 * np.cos(np.clip(place - rng.normal(0, 0.4), -1.5, 1.5)), 0.05, 1)
        bark = any_colour(rng) * np.exp(rng.uniform(0, 0.6) * unevenness(pool, rng))
        image = np.where((np.abs(place) < 1)[..., None], bark * shade[..., None], image)
    return image


def with_things(image: np.ndarray, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """A few large things: furniture, cars, doors."""
    image = np.ascontiguousarray(image, np.float32)
    for _ in range(int(rng.integers(1, 9))):
        image = any_shape(image, rng.uniform(15, 110), pool, rng)
    return image


def with_sign(image: np.ndarray, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Letters and rings, as on posters and seals."""
    image = np.ascontiguousarray(image, np.float32)
    for _ in range(int(rng.integers(1, 5))):
        x, y = (int(v) for v in rng.integers(0, SIZE, 2))
        colour, thick = any_colour(rng).tolist(), int(rng.integers(1, 12))
        if rng.random() < 0.4:
            cv2.circle(image, (x, y), int(rng.integers(15, 140)), colour, thick, cv2.LINE_AA)
        else:
            word = "".join(chr(c) for c in rng.integers(65, 91, int(rng.integers(2, 9))))
            cv2.putText(image, word, (x - 60, y), int(rng.integers(0, 8)), rng.uniform(0.5, 4), colour, thick)
    return image
