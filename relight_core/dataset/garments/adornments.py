"""What is worn at the neck and the ears: scarves, high collars, necklaces, earrings."""

from __future__ import annotations

import numpy as np

from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_binding import HeadSurface
from relight_core.dataset.garments.garment_mesh import fractal, smoothstep
from relight_core.dataset.garments.headwear.caps import tube
from relight_core.dataset.garments.headwear.ornaments import blob
from relight_core.dataset.garments.headwear.ring import AZIMUTH_DEG, HatRing, outline, sheet
from relight_core.dataset.heads import OUTER_SKIN, HeadModel

_NECK_CM = (-11.5, -9.5)
_AZIMUTH = np.radians(AZIMUTH_DEG)
_ROWS = 40


class NeckAndEars:
    """The vertices of a head model by which things are hung about its neck and from its ears."""

    def __init__(self, model: HeadModel):
        x, y = np.abs(model.mean[:, 0]), model.mean[:, 1]
        skin = model.has_vertices_of(*OUTER_SKIN)
        self._neck = np.flatnonzero(skin & (y > _NECK_CM[0]) & (y < _NECK_CM[1]) & (x < 7))
        ear = np.flatnonzero(skin & (x > 7.5) & (y > -4) & (y < 7))
        self._lobes = [_lowest(model.mean, ear[sign * model.mean[ear, 0] > 0]) for sign in (-1, 1)]

    def adorn(self, head: np.ndarray, skin: HeadSurface, rng: np.random.Generator) -> list[Garment]:
        """Something at the neck of one in six heads (V, 3), earrings in one of eight; nothing where neither is."""
        worn = []
        if rng.random() < 0.17 and len(self._neck):
            kind = rng.choice(["scarf", "collar", "necklace"])
            worn.append({"scarf": scarf, "collar": collar, "necklace": necklace}[str(kind)](self.ring(head), skin, rng))
        if rng.random() < 0.12 and all(len(lobe) for lobe in self._lobes):
            worn += earrings([head[lobe].mean(0) for lobe in self._lobes], rng)
        return worn

    def ring(self, head: np.ndarray) -> HatRing:
        """The outline of a neck, level from side to side and lower in front."""
        points = head[self._neck]
        low, high = points.min(0), points.max(0)
        middle = np.array([0.0, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2])
        tilt = np.radians(14)
        axes = np.array([[1, 0, 0], [0, np.cos(tilt), np.sin(tilt)], [0, -np.sin(tilt), np.cos(tilt)]])
        return HatRing(middle, axes, outline((points - middle) @ axes.T), 0.0)


def scarf(ring: HatRing, skin: HeadSurface, rng: np.random.Generator) -> Garment:
    """A scarf wound loosely around the neck."""
    return _wound(ring, skin, rng.uniform(1, 4), rng.uniform(-5, -2), rng.uniform(0.8, 2.5), rng.uniform(0.2, 0.6), rng)


def collar(ring: HatRing, skin: HeadSurface, rng: np.random.Generator) -> Garment:
    """A roll-neck or a stand-up collar of the shirt's own cloth."""
    worn = _wound(ring, skin, rng.uniform(0, 2.5), -4.0, rng.uniform(0.1, 0.5), rng.uniform(0.02, 0.15), rng)
    return Garment(worn.vertices, worn.faces, worn.uv, "cloth", name="collar")


def _wound(ring, skin, top_cm, bottom_cm, bulge_cm, folds_cm, rng) -> Garment:
    along = np.linspace(0, 1, _ROWS)[:, None]
    height = top_cm + (bottom_cm - top_cm) * along
    radius = ring.radius + 0.5 + bulge_cm * np.sin(np.pi * along**0.8) + rng.uniform(0.5, 3) * along**2
    points = ring.place(radius, height)
    bend = 0.5 * fractal(points.reshape(-1, 3), rng, 8.0, 3).reshape(radius.shape)
    turns = rng.uniform(1.0, 3.5) * along + rng.choice([-1, 1]) * _AZIMUTH / (2 * np.pi) + bend
    folds = folds_cm * np.abs(np.sin(np.pi * turns)) + 0.3 * folds_cm * bend
    # The seam at the back is where the end is tucked in.
    folds = folds * smoothstep(180, 165, np.abs(AZIMUTH_DEG))
    moved = skin.push_out(ring.place(radius + folds, height).reshape(-1, 3), 0.3)
    return sheet(moved.reshape(*radius.shape, 3), "scarf", label="cloth", made_of="trim")


def necklace(ring: HatRing, skin: HeadSurface, rng: np.random.Generator) -> Garment:
    """A chain or a string of beads that hangs in front."""
    hang = rng.uniform(1, 7)
    height = -2.0 - hang * (0.5 + 0.5 * np.cos(_AZIMUTH)) ** 1.5
    path = skin.push_out(ring.place(ring.radius + 0.5 - 0.4 * height, height), 0.2)
    thick = rng.uniform(0.08, 0.3) * np.ones(len(path))
    if rng.random() < 0.5:
        thick = thick * (0.5 + 0.7 * np.abs(np.sin(np.arange(len(path)) * rng.uniform(0.4, 1.2))))
    return tube(path, thick, "necklace", label="cloth")


def earrings(lobes: list[np.ndarray], rng: np.random.Generator) -> list[Garment]:
    """A stud, a drop or a hoop on each of two lobes (3,), the image's left first."""
    kind, size = rng.choice(["stud", "drop", "hoop"]), rng.uniform(0.6, 2.2)
    worn = []
    for sign, lobe in zip((-1, 1), lobes, strict=True):
        at = lobe + [0.25 * sign, 0, 0.2]
        if kind == "stud":
            worn.append(blob(at, 0.2 + 0.15 * size, 0.0, rng, "earring", "trim", "cloth"))
        elif kind == "drop":
            worn.append(blob(at - [0, size, 0], 0.3 + 0.3 * size, 0.2, rng, "earring", "trim", "cloth"))
            worn.append(tube(np.linspace(at, at - [0, size, 0], 6), np.full(6, 0.07), "earring", label="cloth"))
        else:
            angle = np.linspace(0, 2 * np.pi, 40)
            hoop = at - [0, size, 0] + size * np.stack([0 * angle, np.cos(angle), np.sin(angle)], 1)
            worn.append(tube(hoop, np.full(40, rng.uniform(0.1, 0.2)), "earring", label="cloth"))
    return worn


def _lowest(mean: np.ndarray, ear: np.ndarray) -> np.ndarray:
    """The vertices of an ear's lobe."""
    return ear[np.argsort(mean[ear, 1])[:8]]
