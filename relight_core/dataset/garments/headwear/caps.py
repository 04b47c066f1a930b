"""Headgear with a visor, a board or a soft disc on a band: officers' caps, flat caps, berets, mortarboards."""

from __future__ import annotations

import numpy as np

from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_binding import HeadSurface
from relight_core.dataset.garments.garment_mesh import fractal
from relight_core.dataset.garments.headwear.ring import AZIMUTH_DEG, HatRing, sheet
from relight_core.dataset.garments.headwear.stiff_hats import HatShape, badge, make_stiff_hat

_AZIMUTH = np.radians(AZIMUTH_DEG)
_FRONT = (0.5 + 0.5 * np.cos(_AZIMUTH)) ** 1.5


def peaked_cap(ring: HatRing, skin: HeadSurface, rng: np.random.Generator) -> list[Garment]:
    """An officer's or chauffeur's cap: a stiff band, a top that flares out over it, a visor."""
    band_cm, flare = rng.uniform(3, 5), rng.uniform(1.5, 4.5)
    rise = rng.uniform(2.5, 4.5) + rng.uniform(0, 4) * _FRONT
    worn = _disc_cap(ring, skin, band_cm, np.full_like(_AZIMUTH, flare), rise, rng.uniform(0.02, 0.2), rng)
    worn.append(visor(ring, rng, made_of="trim"))
    if rng.random() < 0.7:
        worn.append(badge(ring, _band_points(ring, band_cm + 2.5), rng))
    return worn


def flat_cap(ring: HatRing, skin: HeadSurface, rng: np.random.Generator) -> list[Garment]:
    """A flat cap or a newsboy's: a soft top that falls forward onto a small visor."""
    flare = rng.uniform(0.5, 3.5) + rng.uniform(0, 2) * _FRONT
    rise = rng.uniform(2.0, 4.0) - rng.uniform(0, 1.5) * _FRONT
    worn = _disc_cap(ring, skin, rng.uniform(0.5, 2), flare, rise, rng.uniform(0.2, 0.6), rng, same=True)
    worn.append(visor(ring, rng, reach=rng.uniform(3, 5)))
    return worn


def beret(ring: HatRing, skin: HeadSurface, rng: np.random.Generator) -> list[Garment]:
    """A beret: a soft disc pulled to one side."""
    toward = np.radians(rng.choice([-1, 1]) * rng.uniform(40, 130))
    pulled = 0.5 + 0.5 * np.cos(_AZIMUTH - toward)
    flare = rng.uniform(0.5, 2) + rng.uniform(1, 5) * pulled
    rise = rng.uniform(2, 5) - rng.uniform(1, 4) * pulled
    return _disc_cap(ring, skin, rng.uniform(0.5, 2), flare, rise, rng.uniform(0.2, 0.6), rng, same=rng.random() < 0.7)


def _band_points(ring: HatRing, height_cm: float) -> np.ndarray:
    return ring.place(ring.radius, np.linspace(0, height_cm, 12)[:, None])


def _disc_cap(ring, skin, band_cm, flare, rise, slump_cm, rng, *, same: bool = False) -> list[Garment]:
    """A band and a top whose edge stands `flare` (columns,) outside it and `rise` (columns,) above it, cm."""
    outer, edge_cm = ring.radius + flare, band_cm + rise
    underside = np.linspace(0, 1, 10)[:, None]
    top = np.linspace(0, 1, 24)[1:, None]
    across = np.cos(top * np.pi / 2) ** 0.8
    dome = max(ring.top_cm + 1.0 - float(edge_cm.mean()), 0.4)
    radius = np.concatenate([ring.radius + flare * np.sqrt(underside), outer * across])
    # Toward the middle the tilted edge levels out.
    mean = edge_cm.mean()
    height = np.concatenate([band_cm + rise * underside, mean + (edge_cm - mean) * across + dome * (1 - across**2)])
    points = ring.place(radius, height)
    lumps = fractal(points.reshape(-1, 3), rng, 6.0, 3).reshape(height.shape) * slump_cm
    points = points + lumps[..., None] * ring.axes[1]
    points = skin.push_out(points.reshape(-1, 3), 0.4).reshape(points.shape)
    around = sheet(_band_points(ring, band_cm), "cap band", made_of=None if same else "trim")
    return [sheet(points, "cap"), around]


def visor(
    ring: HatRing, rng: np.random.Generator, *, reach: float | None = None, made_of: str | None = None
) -> Garment:
    """A peak over the eyes, curved down to its sides."""
    reach = rng.uniform(4, 7) if reach is None else reach
    half, dip = rng.uniform(50, 75), rng.uniform(0.15, 0.9)
    azimuth = np.linspace(-half, half, len(AZIMUTH_DEG))
    out = np.linspace(0, 1, 16)[:, None]
    foot = np.interp(azimuth, AZIMUTH_DEG, ring.radius)
    width = reach * np.sqrt(np.maximum(1 - (azimuth / half) ** 2, 0)) * out
    angle = np.radians(azimuth)
    across, forward = (foot + width) * np.sin(angle), (foot + width) * np.cos(angle)
    down = dip * width + 0.012 * (foot * np.sin(angle)) ** 2
    local = np.stack([across, -down, forward], -1)
    return sheet(ring.middle + local @ ring.axes, "visor", made_of=made_of)


def sun_visor(ring: HatRing, skin: HeadSurface, rng: np.random.Generator) -> list[Garment]:
    """A band around the forehead with a visor, open above."""
    around = sheet(ring.place(ring.radius, np.linspace(0, rng.uniform(2, 5), 6)[:, None]), "visor band")
    return [around, visor(ring, rng, reach=rng.uniform(6, 9))]


def mortarboard(ring: HatRing, skin: HeadSurface, rng: np.random.Generator) -> list[Garment]:
    """A graduate's cap: a tight cap, a square board, a tassel over its edge."""
    cap = make_stiff_hat(ring, skin, HatShape(crown_cm=ring.top_cm + 0.8, roundness=rng.uniform(2.4, 4)), rng)[:1]
    level, half = ring.top_cm + 0.9, rng.uniform(10.5, 13.5)
    turn = np.radians(rng.choice([45, 0]) + rng.normal(0, 6))
    board = _box(np.array([half, 0.25, half]), turn)
    board += [0, level, 0]
    faces = _BOX_FACES
    uv = np.clip(board[:, [0, 2]] / (3 * half) + 0.5, 0, 1).astype(np.float32)
    top = Garment((ring.middle + board @ ring.axes).astype(np.float32), faces, uv, "hat", name="board")
    return [*cap, top, _tassel(ring, level + 0.3, half, rng)]


_BOX_FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
     [1, 5, 7], [1, 7, 3]], np.int32)  # fmt: skip


def _box(half: np.ndarray, turn: float) -> np.ndarray:
    """Corners (8, 3) of a box turned about +y."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    cosine, sine = np.cos(turn), np.sin(turn)
    return signs @ np.array([[cosine, 0, -sine], [0, 1, 0], [sine, 0, cosine]])


def _tassel(ring: HatRing, level: float, half: float, rng: np.random.Generator) -> Garment:
    """A cord from the middle of a board to its edge and a tuft that hangs from there."""
    azimuth = rng.choice([-1, 1]) * np.radians(rng.uniform(20, 110))
    toward = np.array([np.sin(azimuth), 0, np.cos(azimuth)]) * half * rng.uniform(0.95, 1.1)
    hang = rng.uniform(5, 14)
    middle, edge, end = np.array([0, level, 0]), toward + [0, level, 0], toward + [0, level - hang, 0]
    path = np.concatenate([np.linspace(middle, edge, 12), np.linspace(edge, end, 14)[1:]])
    tuft = np.interp(np.linspace(0, 1, 13), [0, 0.35, 0.45, 1], [0.2, 0.25, 0.7, 1.0])
    thick = np.concatenate([np.full(12, 0.2), tuft])
    return tube(ring.middle + path @ ring.axes, thick, "tassel")


def tube(path: np.ndarray, radius: np.ndarray, name: str, label: str = "hat", made_of: str | None = "trim") -> Garment:
    """A round cord of radii (N,) cm along a path (N, 3)."""
    along = np.gradient(path, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    side = np.cross(along, [0.31, 0.17, 0.93])
    side /= np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-9)
    other = np.cross(along, side)
    angle = np.linspace(0, 2 * np.pi, 13)[None, :, None]
    ring_points = np.cos(angle) * side[:, None] + np.sin(angle) * other[:, None]
    return sheet(path[:, None] + radius[:, None, None] * ring_points, name, label=label, made_of=made_of)
