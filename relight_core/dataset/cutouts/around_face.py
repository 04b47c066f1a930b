"""What is laid around a face is drawn in the face's own measure, and as bright as the person is."""

from __future__ import annotations

import cv2
import numpy as np

from relight_core.dataset.painting.texture import TexturePool


def axes_in_faces(size: int, middle: np.ndarray, face_px: float) -> tuple[np.ndarray, np.ndarray]:
    """How far right of and below a place pixels are, in faces: (1, S), (S, 1)."""
    axis = np.arange(size, dtype=np.float32) + 0.5
    return (axis[None] - middle[0]) / face_px, (axis[:, None] - middle[1]) / face_px


def white_beside(person: np.ndarray) -> float:
    """How bright a white thing would be beside a person, (S, S, 4) premultiplied, roughly."""
    body = person[person[..., 3] > 0.9]
    return float(np.median(body[:, :3].mean(1))) / 0.3 if len(body) else 0.5


def noise_over(pool: TexturePool, size: int, rng: np.random.Generator, times: int = 1) -> np.ndarray:
    """(size, size) noise of the pool's, repeated so many times across."""
    return cv2.resize(np.tile(pool.noise(rng), (times, times)), (size, size), interpolation=cv2.INTER_AREA)


def coverage(inside: np.ndarray, face_px: float) -> np.ndarray:
    """(S, S, 1) in [0, 1], of pixels that lie so far inside an outline (S, S), in faces."""
    return np.clip(inside * face_px + 0.5, 0, 1)[..., None]


def laid_over(person: np.ndarray, alpha: np.ndarray, radiance: np.ndarray) -> np.ndarray:
    """A person (S, S, 4) premultiplied behind a part of coverage (S, S, 1) and radiance (S, S, 3)."""
    return person * (1 - alpha) + np.dstack([radiance, np.ones_like(alpha)]) * alpha
