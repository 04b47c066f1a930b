"""Marks in the skin: moles, freckles in clusters, birthmarks, scars, tattoos. They are albedo, never light."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from relight_core.dataset.baking.bake import SKIN, BakedHead
from relight_core.dataset.lighting.occluders import positions
from relight_core.dataset.painting.texture import TexturePool, look_up

_FACE_TILE_CM = 29.0
"""About what the face tile's side covers of the skin."""
_BEHIND_CM = 2.5
_MELANIN = np.array([1.0, 1.35, 1.7], np.float32)
_BLOOD = np.array([0.12, 0.8, 0.7], np.float32)
_INK = np.array([0.03, 0.035, 0.045], np.float32)
_RUDDY, _PALE = np.array([0.62, 0.40, 0.36], np.float32), np.array([0.78, 0.62, 0.54], np.float32)
_DOTS_SIZE, _DOTS = 256, 500


@dataclass(frozen=True)
class SkinSurface:
    """The skin that is seen of a head: pixel numbers (N,), places (N, 3) in cm and unit normals (N, 3)."""

    pixels: np.ndarray
    places: np.ndarray
    normals: np.ndarray

    def around(self, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """A random place: the pixels near its tangent plane, and where they lie in that plane, (M, 2) cm."""
        middle = rng.integers(len(self.pixels))
        normal = self.normals[middle]
        first = np.cross([0, 1, 0.01], normal)
        first /= np.linalg.norm(first)
        offset = self.places - self.places[middle]
        near = (np.abs(offset @ normal) < _BEHIND_CM) & (self.normals @ normal > 0)
        return self.pixels[near], offset[near] @ np.stack([first, np.cross(normal, first)], 1)


def skin_surface(head: BakedHead) -> SkinSurface | None:
    """The skin of a head; None where none is seen."""
    pixels = np.flatnonzero(np.isin(head.material, SKIN))
    if len(pixels) < 2:
        return None
    places, uv = positions(head)[pixels], head.uv[pixels]
    # Texture coordinates tell how large the crop is: their step from pixel to pixel, against that in space.
    beside = np.diff(pixels) == 1
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)[beside]
    uv_steps = np.linalg.norm(np.diff(uv, axis=0), axis=1)[beside]
    share = np.median(uv_steps / steps) if beside.any() else 1.0
    return SkinSurface(pixels, places * max(float(share), 1e-3) * _FACE_TILE_CM, head.normal[pixels])


def mark_skin(skin: np.ndarray, head: BakedHead, pool: TexturePool, rng: np.random.Generator) -> None:
    """Put random marks into linear skin colours (P, 3), in place."""
    marks = [mark for share, mark in _MARKS if rng.random() < share]
    surface = skin_surface(head) if marks else None
    for mark in marks if surface is not None else []:
        mark(skin, surface, pool, rng)


def add_moles(skin: np.ndarray, surface: SkinSurface, pool: TexturePool, rng: np.random.Generator) -> None:
    """One to a dozen dark spots of 1.5 to 8 mm across."""
    for _ in range(1 + rng.poisson(3)):
        where, offset = surface.around(rng)
        radius = rng.uniform(0.08, 0.2) if rng.random() < 0.8 else rng.uniform(0.2, 0.4)
        inside = _soft(np.hypot(*offset.T) / radius, rng.uniform(0.15, 0.6))
        _absorb(skin, where, inside * rng.uniform(0.5, 2.2), _MELANIN)


def add_freckles(skin: np.ndarray, surface: SkinSurface, pool: TexturePool, rng: np.random.Generator) -> None:
    """Clusters of freckles, a few centimetres or half a face wide."""
    for _ in range(rng.integers(1, 4)):
        where, offset = surface.around(rng)
        spots = look_up(_freckle_map(), offset / rng.uniform(5, 9) + rng.random(2))
        cluster = np.exp(-((np.hypot(*offset.T) / rng.uniform(1.5, 7)) ** 2))
        cluster = cluster * np.clip(0.7 + 0.4 * look_up(pool.noise(rng), offset / 20 + 0.5), 0, 1)
        _absorb(skin, where, cluster * spots * rng.uniform(0.3, 1.2), _MELANIN)


@functools.cache
def _freckle_map() -> np.ndarray:
    """Soft dots (T, T) float32 in [0, 1] of different size and strength, wrapping around."""
    rng = np.random.default_rng(0)
    axis = np.arange(_DOTS_SIZE)
    dots = np.zeros((_DOTS_SIZE, _DOTS_SIZE), np.float32)
    for x, y in rng.uniform(0, _DOTS_SIZE, (_DOTS, 2)):
        across, down = ((axis - at + _DOTS_SIZE / 2) % _DOTS_SIZE - _DOTS_SIZE / 2 for at in (x, y))
        distance = np.hypot(across[None] * rng.uniform(0.8, 1.25), down[:, None]) / rng.uniform(1.5, 4.0)
        dots = np.maximum(dots, rng.uniform(0.4, 1.0) * _soft(distance, 0.8).astype(np.float32))
    return dots


def add_birthmark(skin: np.ndarray, surface: SkinSurface, pool: TexturePool, rng: np.random.Generator) -> None:
    """A red, a brown or a pale patch with a ragged edge."""
    where, offset = surface.around(rng)
    ragged = 0.35 * look_up(pool.noise(rng), offset / rng.uniform(8, 20) + 0.5)
    inside = _soft(np.hypot(*offset.T) / rng.uniform(0.5, 5) + ragged, rng.uniform(0.05, 0.4))
    kind = rng.integers(3)
    if kind == 2:
        _cover(skin, where, inside * rng.uniform(0.3, 0.9), _PALE)
    else:
        _absorb(skin, where, inside * rng.uniform(0.3, 1.1), (_BLOOD, _MELANIN)[kind])


def add_scar(skin: np.ndarray, surface: SkinSurface, pool: TexturePool, rng: np.random.Generator) -> None:
    """A bent line of 1 to 7 cm, ruddy or pale, at times with stitches across."""
    where, offset = surface.around(rng)
    turn, half = rng.uniform(0, np.pi), rng.uniform(0.5, 3.5)
    along = offset @ [np.cos(turn), np.sin(turn)]
    across = offset @ [-np.sin(turn), np.cos(turn)] - rng.normal(0, 0.06) * along**2
    across = across + 0.05 * look_up(pool.noise(rng), offset / 10 + 0.5)
    within = np.abs(along) < half
    width = rng.uniform(0.07, 0.25) * np.sqrt(np.clip(1 - (along / half) ** 2, 1e-4, 1))
    inside = _soft(np.abs(across) / width, 0.5) * within
    if rng.random() < 0.3:
        stitches = (np.abs((along * 1.5) % 1 - 0.5) < 0.12) & (np.abs(across) < 0.4) & within
        inside = np.maximum(inside, 0.7 * stitches)
    _cover(skin, where, inside * rng.uniform(0.3, 0.9), _RUDDY if rng.random() < 0.6 else _PALE)


def add_tattoo(skin: np.ndarray, surface: SkinSurface, pool: TexturePool, rng: np.random.Generator) -> None:
    """A drawing in ink: lines and areas of a picture, black or in colours, somewhere on face, scalp or neck."""
    where, offset = surface.around(rng)
    size, turn = rng.uniform(1.5, 6), rng.uniform(0, 2 * np.pi)
    local = offset @ np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) / size
    picture = pool.picture(rng)
    colour = look_up(picture, local * 0.5 + 0.5)
    level = np.quantile(1 - picture.mean(2), rng.uniform(0.3, 0.7))
    drawn = np.clip((1 - colour.mean(1) - level) * rng.uniform(4, 20) + 0.5, 0, 1)
    outline = _soft(np.abs(local).max(1) if rng.random() < 0.3 else np.hypot(*local.T), 0.08)
    ink = colour * rng.uniform(0.2, 0.7) if rng.random() < 0.3 else _INK * np.exp(rng.normal(0, 0.3, 3))
    _cover(skin, where, outline * drawn * rng.uniform(0.5, 0.95), ink.astype(np.float32))


_MARKS: tuple[tuple[float, Callable[..., None]], ...] = (
    (0.45, add_moles),
    (0.15, add_freckles),
    (0.06, add_birthmark),
    (0.06, add_scar),
    (0.06, add_tattoo),
)


def _soft(distance: np.ndarray, softness: float) -> np.ndarray:
    """1 where a distance is well under 1, 0 well over it."""
    return np.clip((1 - distance) / softness + 0.5, 0, 1)


def _absorb(skin: np.ndarray, where: np.ndarray, amount: np.ndarray, pigment: np.ndarray) -> None:
    skin[where] *= np.exp(-amount[:, None] * pigment)


def _cover(skin: np.ndarray, where: np.ndarray, weight: np.ndarray, colour: np.ndarray) -> None:
    skin[where] += weight[:, None].astype(np.float32) * (colour - skin[where])
