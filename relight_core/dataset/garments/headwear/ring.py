"""The line on which a stiff hat sits on a head, and surfaces swept around it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_mesh import clip, grid_faces
from relight_core.dataset.garments.hair_shell import ScalpGrid

COLUMNS = 180
AZIMUTH_DEG = np.linspace(-180, 180, COLUMNS + 1)
"""Angles around a hat, 0 in front, positive toward the image's right; the seam is at the back."""

_BINS = 48
_LOWEST_SCALP_DEG = 112.0


@dataclass(frozen=True)
class HatRing:
    """A tilted plane through a head's forehead and its back, with the head's outline in it.

    Attributes:
        middle: (3,) cm, in the frame of the head.
        axes: (3, 3) unit rows: right, up, forward.
        radius: (COLUMNS + 1,) cm from the middle to the hat's inner edge at `AZIMUTH_DEG`.
        top_cm: how far the skull rises above the plane.
    """

    middle: np.ndarray
    axes: np.ndarray
    radius: np.ndarray
    top_cm: float

    def place(self, radius_cm: np.ndarray, height_cm: np.ndarray) -> np.ndarray:
        """Points (..., COLUMNS + 1, 3) at distances from the ring's axis and heights above its plane."""
        angle = np.radians(AZIMUTH_DEG)
        radius_cm, height_cm = np.broadcast_arrays(radius_cm, height_cm)
        local = np.stack([radius_cm * np.sin(angle), height_cm, radius_cm * np.cos(angle)], -1)
        return self.middle + local @ self.axes

    def local(self, points: np.ndarray) -> np.ndarray:
        """Coordinates (N, 3) of points (N, 3) in the ring's own frame: right, up, forward."""
        return (points - self.middle) @ self.axes.T


def fit_ring(
    grid: ScalpGrid, head: np.ndarray, front_deg: float, back_deg: float, roll_deg: float, ease_cm: float
) -> HatRing:
    """The ring of a hat on a head (V, 3).

    Args:
        front_deg, back_deg: where it crosses the forehead and the back, angles from the crown.
        roll_deg: tilt to one side.
        ease_cm: room between skull and hat, for hair and lining.
    """
    points, _ = grid.lay_on(head)
    polar, azimuth = grid.polar_deg.ravel(), grid.azimuth_deg.ravel()
    front = points[np.argmin(np.hypot(polar - front_deg, azimuth))]
    back = points[np.argmin(np.hypot(polar - back_deg, azimuth + 180))]
    roll = np.radians(roll_deg)
    forward = _unit((front - back) * [0, 1, 1])
    right = np.array([np.cos(roll), np.sin(roll), 0.0])
    right = _unit(right - forward * (right @ forward))
    axes = np.stack([right, np.cross(forward, right), forward])
    middle = (front + back) / 2 * [0, 1, 1]
    local = (points[polar < _LOWEST_SCALP_DEG] - middle) @ axes.T
    near = local[(local[:, 1] > -1.5) & (local[:, 1] < 4)]
    return HatRing(middle, axes, outline(near) + ease_cm, float(local[:, 1].max()))


def outline(points: np.ndarray) -> np.ndarray:
    """Largest distance from the axis of points (N, 3) at each of `AZIMUTH_DEG`, smooth."""
    bins = ((np.degrees(np.arctan2(points[:, 0], points[:, 2])) + 180) / 360 * _BINS).astype(int) % _BINS
    farthest = np.zeros(_BINS)
    np.maximum.at(farthest, bins, np.hypot(points[:, 0], points[:, 2]))
    known = np.flatnonzero(farthest)
    centres = (np.arange(_BINS) + 0.5) / _BINS * 360 - 180
    around = np.interp(AZIMUTH_DEG, centres[known], farthest[known], period=360)
    return gaussian_filter1d(around, 5, mode="wrap")


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)


def sheet(points: np.ndarray, name: str, *, label: str = "hat", made_of: str | None = None) -> Garment:
    """A garment from a grid of points (rows, columns, 3); texture runs along the columns, v up the rows."""
    rows, columns = points.shape[:2]
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    return Garment(
        points.reshape(-1, 3).astype(np.float32),
        grid_faces(rows, columns),
        np.stack([u.ravel(), v.ravel()], 1).astype(np.float32),
        label,
        name=name,
        made_of=made_of,
    )


def cut(garment: Garment, field: np.ndarray) -> Garment:
    """The part of a garment where a field (V,) over its vertices is positive."""
    faces, values = clip(garment.faces, field, np.concatenate([garment.vertices, garment.uv], 1))
    values = values.astype(np.float32)
    return Garment(
        values[:, :3],
        faces,
        np.clip(values[:, 3:], 0, 1),
        garment.label,
        name=garment.name,
        made_of=garment.made_of,
    )
