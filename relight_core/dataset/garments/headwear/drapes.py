"""What wraps the whole head: headscarves, hoods, balaclavas, helmets. An opening leaves the face free."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree

from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_binding import HeadSurface
from relight_core.dataset.garments.garment_mesh import fractal, smoothstep
from relight_core.dataset.garments.headwear.ring import cut, sheet

_MIDDLE_CM = np.array([0.0, 1.0, 0.0])
_ROWS, _COLUMNS = 130, 200
_LOWEST_DEG = 166.0
_CM_PER_RADIAN = 10.0
_CHIN_CM = -7.6
"""Height of the mean head's chin: below it, what is worn counts as cloth."""


@dataclass(frozen=True)
class DrapeShape:
    """One way to wrap a head.

    Attributes:
        name: for previews.
        up_deg, down_deg, side_deg: half-widths of the opening, seen from the middle of the head.
        ease_cm: how far it stands away from what it covers; smooth_deg: how little it follows that.
        forward_cm: how far the opening's edge stands out before the face.
        lowest_cm: the height at which it ends.
        folds_cm, fold_cm: depth and spacing of folds.
        soft: folds hang and wrap; False for a shell.
    """

    name: str
    up_deg: float
    down_deg: float
    side_deg: float
    ease_cm: float
    smooth_deg: float
    forward_cm: float
    lowest_cm: float
    folds_cm: float
    fold_cm: float
    soft: bool = True


def sample_drape(name: str, rng: np.random.Generator) -> DrapeShape:
    """A "headscarf", "hood", "balaclava", "helmet" or "face helmet"."""
    draw = rng.uniform
    if name == "headscarf":
        down = draw(44, 52) if rng.random() < 0.85 else draw(2, 10)
        return DrapeShape(name, draw(33, 45), down, draw(50, 62), draw(0.5, 1.6), draw(3, 8), draw(-0.2, 0.8),
                          draw(-19, -10), draw(0.15, 0.6), draw(2.5, 7))  # fmt: skip
    if name == "hood":
        return DrapeShape(name, draw(42, 58), draw(44, 60), draw(60, 80), draw(1.5, 4), draw(6, 12), draw(0, 3.5),
                          draw(-16, -12), draw(0.2, 0.7), draw(5, 12))  # fmt: skip
    if name == "balaclava":
        down = draw(10, 20) if rng.random() < 0.4 else draw(40, 47)
        return DrapeShape(name, draw(22, 32), down, draw(44, 54), draw(0.35, 0.7), draw(1.5, 3), 0.0,
                          draw(-14, -9), draw(0.02, 0.12), draw(2, 5))  # fmt: skip
    down = draw(42, 50) if name == "helmet" else draw(8, 25)
    return DrapeShape(name, draw(25, 40), down, draw(52, 66), draw(2.0, 3.5), draw(14, 20), draw(0.5, 2.5),
                      draw(-8, -4), 0.0, 5.0, soft=False)  # fmt: skip


def wrap_head(head: np.ndarray, skin: HeadSurface, shape: DrapeShape, rng: np.random.Generator) -> list[Garment]:
    """A wrapped head (`head`: (V, 3) skin vertices): "hat" above the chin and "cloth", of the same stuff, below."""
    directions, polar, azimuth = _directions()
    distance = _envelope(head, directions, shape.smooth_deg) + shape.ease_cm
    points = _MIDDLE_CM + directions * distance[:, None]
    opening = _opening(directions, shape)
    if shape.folds_cm > 0:
        points += directions * _folds(points, opening, shape, rng)[:, None]
    if not shape.soft and rng.random() < 0.5:
        ridges = np.cos(3 * np.radians(azimuth) * rng.integers(1, 4)) * smoothstep(75, 30, polar)
        points += directions * (rng.uniform(0.2, 0.7) * ridges)[:, None]
    lip = np.exp(-np.maximum(opening, 0) / 1.6)
    points += np.array([0, 0.15, 1.0]) * (shape.forward_cm * lip * smoothstep(110, 60, polar))[:, None]
    points = skin.push_out(points, 0.4 if shape.soft else 0.8, 3.0)
    whole = sheet(points.reshape(_ROWS, _COLUMNS + 1, 3), shape.name)
    kept = np.minimum(opening, points[:, 1] - shape.lowest_cm)
    chin = _CHIN_CM + rng.uniform(-1.5, 0.5)
    parts = [cut(whole, np.minimum(kept, points[:, 1] - chin))]
    if shape.soft:
        below = cut(whole, np.minimum(kept, chin - points[:, 1]))
        parts.append(replace(below, label="cloth", made_of="hat"))
    return [part for part in parts if len(part.faces)]


def _directions() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit directions (N, 3) and their angles from the crown and around from the front, degrees."""
    polar, azimuth = np.meshgrid(
        np.linspace(0.5, _LOWEST_DEG, _ROWS), np.linspace(-180, 180, _COLUMNS + 1), indexing="ij"
    )
    theta, phi = np.radians(polar), np.radians(azimuth)
    toward = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], -1)
    return toward.reshape(-1, 3), polar.ravel(), azimuth.ravel()


def _envelope(head: np.ndarray, directions: np.ndarray, smooth_deg: float) -> np.ndarray:
    """How far the head reaches in each direction (N,), smoothed but nowhere less than the head."""
    offset = head - _MIDDLE_CM
    reach = np.linalg.norm(offset, axis=1)
    _, nearest = cKDTree(offset / reach[:, None]).query(directions, 5)
    nearest = reach[nearest].max(1).reshape(_ROWS, _COLUMNS + 1)
    rows_per_deg, columns_per_deg = _ROWS / _LOWEST_DEG, _COLUMNS / 360
    sigma = (smooth_deg * rows_per_deg, smooth_deg * columns_per_deg)
    open_grid = nearest[:, :-1]
    smooth = gaussian_filter(open_grid, sigma, mode=("nearest", "wrap"))
    smooth = gaussian_filter(np.maximum(open_grid, smooth), (1.2, 1.2), mode=("nearest", "wrap"))
    return np.concatenate([smooth, smooth[:, :1]], 1).ravel()


def _opening(directions: np.ndarray, shape: DrapeShape) -> np.ndarray:
    """Distance (N,) from the edge of the opening along the head, about cm, negative where the face is free."""
    from_front = np.arccos(np.clip(directions[:, 2], -1, 1))
    around = np.hypot(directions[:, 0], directions[:, 1])
    across = np.degrees(from_front) * directions[:, 0] / np.maximum(around, 1e-6)
    upward = np.degrees(from_front) * directions[:, 1] / np.maximum(around, 1e-6)
    half = np.where(upward > 0, shape.up_deg, shape.down_deg)
    edge = (np.abs(across / shape.side_deg) ** 2.4 + np.abs(upward / half) ** 2.4) ** (1 / 2.4)
    return (edge - 1) * np.radians(np.minimum(half, shape.side_deg)) * _CM_PER_RADIAN


def _folds(points: np.ndarray, opening: np.ndarray, shape: DrapeShape, rng: np.random.Generator) -> np.ndarray:
    """Heights (N,) of folds that run around the face and hang below the chin."""
    bend = 0.35 * fractal(points, rng, 12.0, 2)
    around_face = np.cos(2 * np.pi * (opening / shape.fold_cm + bend))
    hang = np.arctan2(points[:, 0], points[:, 2] + 3)
    hanging = np.cos(hang * 2 * np.pi * 10 / shape.fold_cm / 2 + 2 * bend * np.pi)
    low = smoothstep(-4, -10, points[:, 1])
    soft = 0.7 * fractal(points, rng, shape.fold_cm, 3)
    crest = around_face * (1 - low) + hanging * low
    return shape.folds_cm * (0.6 * np.abs(crest) + soft) * smoothstep(0, 1.0, opening)
