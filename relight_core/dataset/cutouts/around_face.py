"""What is laid around a face is drawn in the face's own measure, and as bright as the person is."""

from __future__ import annotations

import numpy as np


def axes_in_faces(size: int, middle: np.ndarray, face_px: float) -> tuple[np.ndarray, np.ndarray]:
    """How far right of and below a place pixels are, in faces: (1, S), (S, 1)."""
    axis = np.arange(size, dtype=np.float32) + 0.5
    return (axis[None] - middle[0]) / face_px, (axis[:, None] - middle[1]) / face_px


def white_beside(person: np.ndarray) -> float:
    """How bright a white thing would be beside a person, (S, S, 4) premultiplied, roughly."""
    body = person[person[..., 3] > 0.9]
    return float(np.median(body[:, :3].mean(1))) / 0.3 if len(body) else 0.5
