"""What is worn on the head without covering it: headbands, crowns, wreaths, feathers, headphones."""

from __future__ import annotations

import numpy as np

from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_binding import HeadSurface
from relight_core.dataset.garments.garment_mesh import fractal, smoothstep
from relight_core.dataset.garments.headwear.caps import tube
from relight_core.dataset.garments.headwear.ring import AZIMUTH_DEG, HatRing, sheet

_AZIMUTH = np.radians(AZIMUTH_DEG)


def headband(ring: HatRing, skin: HeadSurface, rng: np.random.Generator) -> list[Garment]:
    """A ribbon or sweatband around the forehead."""
    levels = np.linspace(-0.5, 0.5, 14)[:, None] * rng.uniform(1.5, 7)
    thick = rng.uniform(0.1, 0.6) * np.sqrt(np.maximum(1 - np.linspace(-1, 1, 14) ** 2, 0))[:, None]
    points = ring.place(ring.radius + thick, levels)
    folds = fractal(points.reshape(-1, 3) * [1, 3, 1], rng, 4.0, 3).reshape(14, -1) * rng.uniform(0, 0.2)
    points = skin.push_out(ring.place(ring.radius + thick + folds, levels).reshape(-1, 3), 0.3)
    return [sheet(points.reshape(14, -1, 3), "headband")]


def crown(ring: HatRing, skin: HeadSurface, rng: np.random.Generator) -> list[Garment]:
    """A crown all round or a tiara in front, with points."""
    points, foot = int(rng.integers(4, 11)), rng.uniform(1, 3)
    rise = rng.uniform(2, 7) * np.abs(np.cos(points * _AZIMUTH / 2)) ** rng.uniform(0.6, 3)
    if rng.random() < 0.5:
        rise = rise * smoothstep(100, 20, np.abs(AZIMUTH_DEG))
    level = np.linspace(0, 1, 16)[:, None] * (foot + rise)
    flare = rng.uniform(-0.05, 0.25)
    worn = [sheet(ring.place(ring.radius + flare * level + 0.2, level), "crown")]
    if rng.random() < 0.6:
        at = ring.place(ring.radius + 0.5, foot * 0.5)[:-1][:: rng.integers(6, 16)]
        worn += [blob(place, rng.uniform(0.25, 0.6), 0.0, rng, "jewel", "trim") for place in at]
    return worn


def wreath(ring: HatRing, skin: HeadSurface, rng: np.random.Generator) -> list[Garment]:
    """Flowers or leaves on a ring."""
    size, low, high = rng.uniform(0.9, 2.4), *sorted(rng.uniform(-1, 3, 2))
    count = int(np.clip(90 / size, 30, 80))
    at = ring.place(ring.radius + 0.4 * size, 0)[rng.integers(0, len(_AZIMUTH), count)]
    at = at + rng.uniform(low, high, (count, 1)) * ring.axes[1] + rng.normal(0, 0.3, (count, 3))
    stuff = [None if rng.random() < 0.6 else "trim" for _ in at]
    return [
        blob(place, size * rng.uniform(0.6, 1.2), 0.35, rng, "flower", made_of)
        for place, made_of in zip(at, stuff, strict=True)
    ]


def blob(
    middle: np.ndarray,
    radius: float,
    rough: float,
    rng: np.random.Generator,
    name: str,
    made_of: str | None,
    label: str = "hat",
) -> Garment:
    """A ball of a random stretch, about (3,) `middle`, with petals as `rough` makes them."""
    theta, phi = np.meshgrid(np.linspace(0.05, np.pi - 0.05, 11), np.linspace(-np.pi, np.pi, 19), indexing="ij")
    ball = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1)
    petals = 1 + rough * np.cos(phi * rng.integers(3, 7) + rng.uniform(0, 6)) * np.sin(theta)
    turn, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    shape = (ball * petals[..., None] * rng.uniform(0.5, 1.0, 3)) @ turn.T
    return sheet(middle + radius * shape, name, label=label, made_of=made_of)


def feathers(ring: HatRing, skin: HeadSurface, rng: np.random.Generator) -> list[Garment]:
    """A headdress: a band, and feathers that fan out from it."""
    spread, count = rng.uniform(60, 175), int(rng.integers(14, 44))
    length, width = rng.uniform(10, 26), rng.uniform(1.2, 3.2)
    lean, rows = rng.uniform(-0.2, 0.7), int(rng.integers(1, 3))
    worn = [
        sheet(ring.place(ring.radius + 0.3, np.linspace(-1, rng.uniform(0.5, 4), 5)[:, None]), "band", made_of="trim")
    ]
    for row in range(rows):
        for azimuth in np.linspace(-spread, spread, count) + rng.normal(0, 1.5, count):
            reach = length * (1 - 0.45 * row) * rng.uniform(0.85, 1.1)
            made_of = "trim" if row else None
            worn.append(_feather(ring, azimuth, reach, width * rng.uniform(0.8, 1.2), lean + 0.15 * row, made_of, rng))
    return worn


def _feather(ring, azimuth_deg, length, width, lean, made_of, rng) -> Garment:
    """A blade with a ridge, from the ring upward and out, its tip bent."""
    along, across = np.meshgrid(np.linspace(0, 1, 18), np.linspace(-1, 1, 7), indexing="ij")
    outline = np.minimum(1, 4 * along + 0.1) * np.sqrt(np.maximum(1 - along**4, 0))
    azimuth = np.radians(azimuth_deg)
    out = np.array([np.sin(azimuth), 0, np.cos(azimuth)])
    side = np.array([np.cos(azimuth), 0, -np.sin(azimuth)])
    rise = length * (along - 0.12 * along**2)
    bend = lean * rise + rng.normal(0, 0.12) * length * along**2 - 0.25 * width * across**2
    fan = np.sin(azimuth) * 0.35 * rise
    local = (
        (np.interp(azimuth_deg, AZIMUTH_DEG, ring.radius, period=360) + 0.35 + bend)[..., None] * out
        + (0.5 * width * outline * across + rng.normal(0, 0.05) * rise)[..., None] * side
        + rise[..., None] * np.array([0, 1, 0])
        + fan[..., None] * np.array([1, 0, 0])
    )
    return sheet(ring.middle + local @ ring.axes, "feather", made_of=made_of)


def headphones(ears: np.ndarray, crown_cm: float, rng: np.random.Generator) -> list[Garment]:
    """A band over the crown and a cup on each ear.

    Args:
        ears: (2, 3) middles of the ears' outer sides, left of the image first.
        crown_cm: height of the top of the head with its hair.
    """
    cup = np.array([rng.uniform(1.2, 2.4), rng.uniform(3.2, 4.8), rng.uniform(2.8, 4.2)])
    worn = []
    for sign, ear in zip((-1, 1), ears, strict=True):
        worn.append(_cushion(ear + [sign * (cup[0] - 0.4), 0, 0], cup, None))
        worn.append(_cushion(ear + [sign * (cup[0] * 1.6), 0, 0], cup * [0.7, 0.75, 0.75], "trim"))
    half = abs(ears[:, 0]).max() + cup[0] * 0.9
    angle = np.linspace(0, np.pi, 60)
    low, top = ears[:, 1].mean() + 1.5, crown_cm + 0.5
    forward = ears[:, 2].mean() + rng.uniform(-1, 1.5) * np.sin(angle)
    path = np.stack([-half * np.cos(angle), low + (top - low) * np.sin(angle) ** 0.8, forward], 1)
    if rng.random() < 0.4:
        return [*worn, tube(path, np.full(60, rng.uniform(0.3, 0.7)), "headphone band", made_of="trim")]
    across = np.linspace(-0.5, 0.5, 6)[:, None, None] * rng.uniform(1.8, 4.5) * np.array([0, 0, 1])
    arched = np.array([0, -0.25, 0]) * np.linspace(-1, 1, 6)[:, None, None] ** 2
    return [*worn, sheet(path + across + arched, "headphone band")]


def _cushion(middle: np.ndarray, half: np.ndarray, made_of: str | None) -> Garment:
    """A rounded box about `middle` (3,) with half-widths `half` (3,): flat on its outer side."""
    theta, phi = np.meshgrid(np.linspace(0.01, np.pi - 0.01, 25), np.linspace(-np.pi, np.pi, 41), indexing="ij")
    shape = np.stack([np.cos(theta), np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi)], -1)
    flat = np.sign(shape) * np.abs(shape) ** np.array([0.5, 0.85, 0.85])
    return sheet(middle + flat * half, "ear cup", made_of=made_of)
