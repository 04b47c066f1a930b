"""Hair as an opaque shell grown from the scalp: mass and relief, not strands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree

from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_binding import HeadSurface
from relight_core.dataset.garments.garment_mesh import clip, fractal, grid_faces, smoothstep, waves
from relight_core.dataset.heads import OUTER_SKIN, HeadModel

_ROWS, _COLUMNS = 118, 240
_LOWEST_POLAR_DEG = 150.0
_SKULL_CENTRE_CM = np.array([0.0, 5.0, 0.5])
_EAR_HALF_WIDTH_CM = 7.7
CM_PER_DEG = 0.17
"""Length on the scalp of one degree seen from the middle of the skull."""

# Hairline of a full head of hair: angle from the crown at angles from the front (both sides alike).
_AZIMUTH_DEG = np.array([0, 22, 42, 56, 66, 74, 82, 100, 116, 128, 150, 180])
_HAIRLINE_DEG = np.array([57, 57, 64, 82, 97, 98, 86, 86, 100, 118, 134, 138])


@dataclass(frozen=True)
class ShellStyle:
    """One haircut. Lengths in cm stand away from the skin; angles in degrees.

    Attributes:
        top_cm, side_cm, back_cm: thickness on the crown, above the ears, at the back.
        recede_deg: how far the hairline is drawn back at the temples.
        peak_deg: how far it dips in the middle of the forehead.
        bare_crown_deg: radius of a bald crown, 0 for none.
        relief: strength of tufts and strands relative to the thickness.
        strand_cm: size of the tufts; comb: how much longer they are along the head than across.
        ragged_deg: unevenness of the hairline.
        sweep_cm: how far the top is swept to one side (its sign) and forward.
    """

    top_cm: float
    side_cm: float
    back_cm: float
    recede_deg: float
    peak_deg: float
    bare_crown_deg: float
    relief: float
    strand_cm: float
    comb: float
    ragged_deg: float
    sweep_cm: float


def sample_style(rng: np.random.Generator) -> ShellStyle:
    """A buzz cut, a short cut, a quiff, a voluminous one or an afro."""
    kind = rng.choice(["buzz", "short", "quiff", "volume", "afro"], p=[0.22, 0.33, 0.2, 0.15, 0.1])
    # Ranges: thickness on top, sides as a share of it, relief, size of tufts, their stretch.
    ranges = {
        "buzz": ((0.12, 0.5), (0.5, 1.0), (0.15, 0.4), (0.4, 0.6), (1, 1)),
        "short": ((0.7, 2.2), (0.25, 0.8), (0.25, 0.5), (0.8, 1.8), (1, 4)),
        "quiff": ((2.0, 3.5), (0.1, 0.4), (0.2, 0.4), (1.0, 2.2), (2, 5)),
        "volume": ((1.8, 3.2), (0.7, 1.1), (0.2, 0.4), (1.2, 3.0), (1.5, 5)),
        "afro": ((2.5, 6.5), (0.7, 1.1), (0.1, 0.25), (0.6, 1.4), (1, 1)),
    }[str(kind)]
    top, side, relief, strand, comb = (rng.uniform(low, high) for low, high in ranges)
    return ShellStyle(
        top_cm=top,
        side_cm=max(top * side, 0.1),
        back_cm=max(top * rng.uniform(0.5, 1.0), 0.1),
        recede_deg=max(rng.normal(0, 9), -4),
        peak_deg=rng.normal(0, 3),
        bare_crown_deg=rng.uniform(15, 55) if rng.random() < 0.07 else 0.0,
        relief=relief,
        strand_cm=strand,
        comb=comb,
        ragged_deg=rng.uniform(0.4, 2.5),
        sweep_cm=rng.normal(0, 0.35) * top,
    )


class ScalpGrid:
    """A regular grid over the skull, without the ears, bound to the vertices of a head model."""

    def __init__(self, model: HeadModel):
        skin = model.has_vertices_of(*OUTER_SKIN) & (np.abs(model.mean[:, 0]) < _EAR_HALF_WIDTH_CM)
        centred = model.mean - _SKULL_CENTRE_CM
        self._anchors = np.flatnonzero(skin)
        self.polar_deg, self.azimuth_deg = np.meshgrid(
            np.linspace(0.5, _LOWEST_POLAR_DEG, _ROWS), np.linspace(-180, 180, _COLUMNS + 1), indexing="ij"
        )
        polar, azimuth = np.radians(self.polar_deg.ravel()), np.radians(self.azimuth_deg.ravel())
        ring = np.sin(polar)
        toward = np.stack([ring * np.sin(azimuth), np.cos(polar), ring * np.cos(azimuth)], 1)
        unit = centred[self._anchors]
        unit /= np.linalg.norm(unit, axis=1, keepdims=True)
        distance, nearest = cKDTree(unit).query(toward, 8)
        weight = 1 / (distance + 0.01) ** 2
        weight /= weight.sum(1, keepdims=True)
        rows = np.repeat(np.arange(len(toward)), 8)
        shape = (len(toward), len(self._anchors))
        self._weights = csr_matrix((weight.ravel(), (rows, nearest.ravel())), shape)
        self._faces = grid_faces(*self.polar_deg.shape)
        u, v = self.azimuth_deg / 360 + 0.5, 1 - self.polar_deg / _LOWEST_POLAR_DEG
        self._uv = np.stack([u.ravel(), v.ravel()], 1).astype(np.float32)

    def lay_on(self, head: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points (N, 3) of the grid on a head's scalp and outward unit normals (N, 3)."""
        points = (self._weights @ head[self._anchors]).reshape(*self.polar_deg.shape, 3)
        points = gaussian_filter(points[:, :-1], (1.5, 1.5, 0), mode=("nearest", "wrap", "nearest"))
        points = np.concatenate([points, points[:, :1]], 1)
        down = np.gradient(points, axis=0)
        right = np.gradient(np.concatenate([points[:, -2:-1], points, points[:, 1:2]], 1), axis=1)[:, 1:-1]
        normal = np.cross(down, right).reshape(-1, 3)
        radial = points.reshape(-1, 3) - (points[:, :-1].mean((0, 1)) * [1, 0.6, 1])
        radial /= np.linalg.norm(radial, axis=1, keepdims=True)
        # Near the pole the grid degenerates; mixing with the radius also keeps big hair from folding.
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        normal = np.where(length > 1e-3, normal / np.maximum(length, 1e-9), radial)
        normal *= np.sign((normal * radial).sum(1, keepdims=True))
        mixed = 0.5 * normal + 0.5 * radial
        return points.reshape(-1, 3), mixed / np.linalg.norm(mixed, axis=1, keepdims=True)

    def nearest_row(self, line_deg: np.ndarray) -> np.ndarray:
        """Index (N,) of the grid point in each point's own column that is nearest to a polar angle (N,)."""
        rows, columns = self.polar_deg.shape
        row = np.rint((line_deg - self.polar_deg[0, 0]) / (self.polar_deg[1, 0] - self.polar_deg[0, 0]))
        return np.clip(row, 0, rows - 1).astype(int) * columns + np.tile(np.arange(columns), rows)

    def shell(self, points: np.ndarray, field: np.ndarray, label: str, name: str) -> Garment:
        """The part of displaced grid points (N, 3) where the field (N,) is positive."""
        faces, values = clip(self._faces, field, np.concatenate([points, self._uv], 1))
        values = values.astype(np.float32)
        return Garment(values[:, :3], faces, np.clip(values[:, 3:], 0, 1), label, name=name)


def around(azimuth_deg: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Interpolate values (12,) given at fixed angles from the front to the back, both sides alike."""
    return np.interp(np.abs(azimuth_deg), _AZIMUTH_DEG, values)


def grow_hair(
    grid: ScalpGrid, head: np.ndarray, skin: HeadSurface, style: ShellStyle, rng: np.random.Generator
) -> Garment:
    """Hair of a style on a head (V, 3) whose surface is `skin`."""
    points, outward = grid.lay_on(head)
    azimuth, polar = grid.azimuth_deg.ravel(), grid.polar_deg.ravel()
    front = np.exp(-((azimuth / 28) ** 2))
    temples = np.exp(-(((np.abs(azimuth) - 38) / 14) ** 2))
    line = around(azimuth, _HAIRLINE_DEG) + style.peak_deg * front
    line += style.ragged_deg * waves(points, rng, 2.0) - style.recede_deg * (temples + 0.4 * front)
    field = (line - polar) * CM_PER_DEG
    if style.bare_crown_deg > 0:
        field = np.minimum(field, (polar - style.bare_crown_deg) * CM_PER_DEG)
    thickness = _thickness(style, azimuth, polar)
    rise = smoothstep(0, np.clip(thickness, 0.4, 2.0), field)
    tufts = fractal(points, rng, 2 * style.strand_cm, 4) if style.comb == 1 else _combed(points, style, rng)
    # Tufts higher than they are wide would stand as spines.
    steepest = np.minimum(style.relief * thickness, 0.3 * style.strand_cm)
    height = 0.06 + rise * np.maximum(thickness + steepest * tufts, 0.2 * thickness)
    moved = points + outward * height[:, None]
    top = smoothstep(75, 25, polar) if style.top_cm > 0.6 else np.zeros_like(polar)
    moved += (top * rise)[:, None] * np.array([style.sweep_cm, 0, 0.5 * abs(style.sweep_cm)])
    moved = skin.push_out(moved, 0.06)
    return grid.shell(moved, field, "hair", "shell")


def _thickness(style: ShellStyle, azimuth: np.ndarray, polar: np.ndarray) -> np.ndarray:
    lower = smoothstep(35, 80, polar)
    back = smoothstep(100, 150, np.abs(azimuth))
    below = style.side_cm * (1 - back) + style.back_cm * back
    faded = below * (1 - 0.6 * smoothstep(95, 135, polar))
    return style.top_cm * (1 - lower) + faded * lower


def _combed(points: np.ndarray, style: ShellStyle, rng: np.random.Generator) -> np.ndarray:
    """Relief drawn out along one direction, as of combed or wavy hair."""
    stretch = [1.0, style.comb, style.comb] if rng.random() < 0.7 else [style.comb, 1.0, style.comb]
    layers = [waves(points, rng, 2 * style.strand_cm / 2**o, stretch) / 1.6**o for o in range(4)]
    return sum(layers) / 1.3
