"""Things exactly behind a head: a window or a column, a seal or a halo, a picture frame, the back of a chair.

At random they would hardly ever line up with it, and where they do is where a hat or a veil would be.
"""

from __future__ import annotations

import cv2
import numpy as np

from relight_core.dataset.cutouts.around_face import axes_in_faces

_SHIFT, _SOFTEST = 0.35, 0.012


def with_something_behind(
    image: np.ndarray, stuff: np.ndarray, centre: np.ndarray, face_px: float, rng: np.random.Generator
) -> np.ndarray:
    """A background with a shape of some stuff behind the face.

    Args:
        image, stuff: (S, S, 3) linear.
        centre: (x, y) of the face's middle, in pixels.
        face_px: the longer side of the face's bounding box.
    """
    size = len(image)
    middle = np.asarray(centre) + face_px * rng.normal(0, _SHIFT, 2) * [1, 0.5]
    mask = (_column, _disc, _ring, _board)[rng.integers(4)](size, middle, face_px, rng)
    softness = size * _SOFTEST * rng.random() ** 2
    mask = cv2.GaussianBlur(mask, (0, 0), max(softness, 0.4))[..., None]
    return image * (1 - mask) + stuff * mask


def _column(size: int, middle: np.ndarray, face_px: float, rng: np.random.Generator) -> np.ndarray:
    """From top to bottom, or as far as the shoulders."""
    across, down = axes_in_faces(size, middle, face_px)
    ends = rng.uniform(0.4, 1.2) if rng.random() < 0.5 else np.inf
    return ((np.abs(across) < rng.uniform(0.45, 1.4)) & (down < ends)).astype(np.float32)


def _disc(size: int, middle: np.ndarray, face_px: float, rng: np.random.Generator) -> np.ndarray:
    return (_radius(size, middle, face_px, rng) < 1).astype(np.float32)


def _ring(size: int, middle: np.ndarray, face_px: float, rng: np.random.Generator) -> np.ndarray:
    radius = _radius(size, middle, face_px, rng)
    return ((radius < 1) & (radius > rng.uniform(0.6, 0.95))).astype(np.float32)


def _radius(size: int, middle: np.ndarray, face_px: float, rng: np.random.Generator) -> np.ndarray:
    across, down = axes_in_faces(size, middle, face_px)
    wide = rng.uniform(0.6, 1.6)
    return np.hypot(across / wide, (down + rng.uniform(0, 0.8)) / (wide * np.exp(rng.normal(0, 0.2))))


def _board(size: int, middle: np.ndarray, face_px: float, rng: np.random.Generator) -> np.ndarray:
    """Its upper edge somewhere beside or above the head, and down to the bottom or as far as it is wide."""
    across, down = axes_in_faces(size, middle, face_px)
    wide, top = rng.uniform(0.6, 1.6), rng.uniform(-1.3, 0.3)
    bottom = np.inf if rng.random() < 0.6 else top + rng.uniform(0.5, 2)
    slope = 0.15 * rng.normal()
    return ((np.abs(across) < wide) & (down > top + slope * across) & (down < bottom)).astype(np.float32)
