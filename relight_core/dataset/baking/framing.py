"""Where the camera looks: the square crop of the virtual photograph that a head is baked in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

CAMERA_DISTANCE_CM = 350.0
"""The paper places heads 3.5 m from the camera (section 3.2)."""

_PAPER_PX = 256


@dataclass(frozen=True)
class Framing:
    """A square window on the plane z = 0, seen from the camera at z = CAMERA_DISTANCE_CM.

    Attributes:
        centre_cm: (x, y) of the window's middle.
        half_width_cm: half its side.
    """

    centre_cm: tuple[float, float]
    half_width_cm: float

    def rays(self, size: int) -> tuple[np.ndarray, np.ndarray]:
        """Origin (3,) and unit directions (size * size, 3) through the pixel centres, row 0 on top."""
        offsets = ((np.arange(size) + 0.5) / size * 2 - 1) * self.half_width_cm
        x, y = np.meshgrid(self.centre_cm[0] + offsets, self.centre_cm[1] - offsets)
        toward = np.stack([x, y, np.full_like(x, -CAMERA_DISTANCE_CM)], -1).reshape(-1, 3)
        toward /= np.linalg.norm(toward, axis=1, keepdims=True)
        return np.array([0, 0, CAMERA_DISTANCE_CM], np.float32), toward.astype(np.float32)


def project(points_cm: np.ndarray) -> np.ndarray:
    """(N, 2) positions on the plane z = 0 as the camera sees the points (N, 3)."""
    return points_cm[:, :2] * (CAMERA_DISTANCE_CM / (CAMERA_DISTANCE_CM - points_cm[:, 2:3]))


def sample_framing(face_points_cm: np.ndarray, rng: np.random.Generator) -> Framing:
    """The paper's crop (20 to 40 pixels of padding of 256, section 3.2), or a looser one as often.

    Args:
        face_points_cm: (N, 3) posed vertices of the face proper.
    """
    seen = project(face_points_cm)
    low, high = seen.min(0), seen.max(0)
    centre, side = (low + high) / 2, float((high - low).max())
    padding_px = rng.uniform(20, 40)
    half_width = side / 2 * _PAPER_PX / (_PAPER_PX - 2 * padding_px)
    if rng.random() < 0.5:
        half_width *= rng.uniform(1.05, 2.3)
        centre = centre + rng.uniform(-0.25, 0.25, 2) * half_width + np.array([0, -0.08 * half_width])
    else:
        centre = centre + rng.uniform(-0.04, 0.04, 2) * half_width
    return Framing((float(centre[0]), float(centre[1])), half_width)
