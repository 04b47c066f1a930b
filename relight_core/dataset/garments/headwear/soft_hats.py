"""Hats of cloth, wool and fur: grown from the head they are worn on."""

from __future__ import annotations

import numpy as np

from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_binding import HeadSurface
from relight_core.dataset.garments.garment_mesh import fractal, smoothstep, waves
from relight_core.dataset.garments.hair_shell import CM_PER_DEG, ScalpGrid, around

# Where a hat ends: angle from the crown at the angles from the front that `around` names.
_BEANIE_DEG = np.array([66, 67, 72, 78, 82, 84, 86, 90, 96, 102, 106, 108])
_BRIM_DEG = 18.0
"""Rows of the grid over this angle below a hat's line become its brim: they run outward, not down."""
_TURBAN_DEG = np.array([62, 63, 66, 72, 78, 82, 86, 94, 102, 108, 110, 112])
_BANDANA_DEG = np.array([58, 59, 62, 70, 78, 80, 82, 90, 98, 104, 108, 110])
_FLAPS_DEG = np.array([60, 61, 66, 82, 100, 116, 122, 122, 122, 122, 122, 122])
_CAP_DEG = np.array([63, 63, 66, 70, 74, 77, 80, 85, 91, 95, 100, 102])


def knit_beanie(grid: ScalpGrid, head: np.ndarray, skin: HeadSurface, rng: np.random.Generator) -> Garment:
    """A woollen hat on a head (V, 3): soft, ribbed, with a turned-up rim."""
    points, outward = grid.lay_on(head)
    azimuth, polar = grid.azimuth_deg.ravel(), grid.polar_deg.ravel()
    field = (around(azimuth, _BEANIE_DEG) + rng.uniform(-10, 4) - polar) * CM_PER_DEG
    rim = rng.uniform(2.0, 5.0)
    in_rim = 1 - smoothstep(rim - 0.25, rim + 0.25, field)
    height = 0.7 + rng.uniform(0.2, 0.6) * in_rim * smoothstep(0, 0.5, field)
    height += rng.uniform(0, 3.5) * smoothstep(60, 0, polar) + 0.15 * fractal(points, rng, 6.0, 2)
    height += 0.05 * np.sin(np.radians(azimuth) * 60) * smoothstep(5, 30, polar)
    moved = skin.push_out(points + outward * height[:, None], 0.35)
    return grid.shell(moved, field, "hat", "beanie")


def brimmed_hat(grid: ScalpGrid, head: np.ndarray, skin: HeadSurface, rng: np.random.Generator) -> Garment:
    """A cap with a visor, or a hat with a brim all round, on a head (V, 3)."""
    is_cap = rng.random() < 0.6
    points, outward = grid.lay_on(head)
    azimuth, polar = grid.azimuth_deg.ravel(), grid.polar_deg.ravel()
    line = around(azimuth, _CAP_DEG) + rng.uniform(-6, 5)
    crown = rng.uniform(0.8, 2.2) if is_cap else rng.uniform(2.0, 5.0)
    inside = np.minimum(polar, line)
    height = 0.7 + crown * smoothstep(90, 35, inside) + 0.08 * fractal(points, rng, 5.0, 2)
    dome = skin.push_out(points + outward * height[:, None], 0.35)
    edge = np.where((polar > line)[:, None], dome[grid.nearest_row(line)], dome)
    beyond = np.maximum(polar - line, 0)
    reach = _visor(azimuth, rng) if is_cap else np.full_like(azimuth, rng.uniform(4.0, 9.0))
    if is_cap:
        bend, dip = 0.03 * edge[:, 0] ** 2, rng.uniform(0.1, 0.35)
    else:
        bend, dip = 0.3 * waves(points, rng, 18.0), rng.uniform(-0.15, 0.3)
    moved = _spread_brim(edge, dome.mean(0), reach * np.clip(beyond / _BRIM_DEG, 0, 1), dip, bend)
    field = np.where(reach > 0.3, _BRIM_DEG - beyond, line + 1 - polar) * CM_PER_DEG
    return grid.shell(moved.astype(np.float32), field, "hat", "cap" if is_cap else "brimmed")


def _spread_brim(edge: np.ndarray, middle: np.ndarray, out_cm: np.ndarray, dip: float, bend: np.ndarray):
    """Vertices (N, 3) on a hat's edge moved `out_cm` (N,) level outward, then down by its slope and bend."""
    flat = (edge - middle) * [1, 0, 1]
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-6)
    moved = edge + flat * out_cm[:, None]
    moved[:, 1] -= dip * out_cm + bend * smoothstep(0, 6, out_cm)
    return moved


def _visor(azimuth_deg: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """How far a cap's visor reaches out at each angle from the front, cm."""
    half = rng.uniform(45, 60)
    turned = 180.0 if rng.random() < 0.12 else rng.normal(0, 4)
    away = np.abs((azimuth_deg - turned + 180) % 360 - 180)
    return rng.uniform(5.0, 7.5) * np.sqrt(np.maximum(1 - (away / half) ** 2, 0))


def turban(grid: ScalpGrid, head: np.ndarray, skin: HeadSurface, rng: np.random.Generator) -> Garment:
    """A long cloth wound around a head (V, 3), its turns crossing in front."""
    points, outward = grid.lay_on(head)
    azimuth, polar = grid.azimuth_deg.ravel(), grid.polar_deg.ravel()
    field = (around(azimuth, _TURBAN_DEG) + rng.uniform(-7, 6) - polar) * CM_PER_DEG
    slant = rng.uniform(0.1, 0.5) * (np.abs(azimuth) if rng.random() < 0.6 else azimuth)
    turns = (polar + slant) / rng.uniform(9, 20) + 0.15 * fractal(points, rng, 8.0, 2)
    bulge = rng.uniform(1.0, 4.5) * smoothstep(0, 5, field) * (1 + rng.uniform(-0.3, 0.5) * smoothstep(70, 20, polar))
    rounded = np.abs(np.sin(np.pi * turns)) ** 0.6
    height = 0.7 + bulge + rng.uniform(0.3, 0.9) * rounded * smoothstep(0, 1.2, field)
    height += 0.1 * fractal(points, rng, 2.0, 3)
    return grid.shell(skin.push_out(points + outward * height[:, None], 0.35), field, "hat", "turban")


def bandana(grid: ScalpGrid, head: np.ndarray, skin: HeadSurface, rng: np.random.Generator) -> Garment:
    """A thin cloth, a swimmer's cap or a wide band, tight on the skull of a head (V, 3)."""
    points, outward = grid.lay_on(head)
    azimuth, polar = grid.azimuth_deg.ravel(), grid.polar_deg.ravel()
    field = (around(azimuth, _BANDANA_DEG) + rng.uniform(-8, 3) - polar) * CM_PER_DEG
    if rng.random() < 0.25:
        field = np.minimum(field, (polar - rng.uniform(25, 45)) * CM_PER_DEG)
    folds = fractal(points * [1, 2.5, 1], rng, rng.uniform(3, 6), 3) * rng.uniform(0, 0.15)
    moved = skin.push_out(points + outward * (0.5 + folds)[:, None], 0.3)
    return grid.shell(moved, field, "hat", "bandana")


def fur_hat(grid: ScalpGrid, head: np.ndarray, skin: HeadSurface, rng: np.random.Generator) -> Garment:
    """A hat of fur or felt wool on a head (V, 3), with or without flaps over the ears."""
    points, outward = grid.lay_on(head)
    azimuth, polar = grid.azimuth_deg.ravel(), grid.polar_deg.ravel()
    line = around(azimuth, _FLAPS_DEG if rng.random() < 0.5 else _CAP_DEG) + rng.uniform(-5, 4)
    field = (line - polar) * CM_PER_DEG
    tufts = fractal(points, rng, rng.uniform(0.8, 2.5), 4) * rng.uniform(0.15, 0.45)
    height = 0.8 + (rng.uniform(1.5, 4.0) + tufts) * smoothstep(0, 1.5, field) + 2.0 * smoothstep(55, 15, polar)
    return grid.shell(skin.push_out(points + outward * height[:, None], 0.35), field, "hat", "fur hat")
