"""What hats, clothes and frames are dyed: plain cloth from white to black, stripes, checks, dots, weaves, pictures."""

from __future__ import annotations

import numpy as np

from relight_core.dataset.painting.texture import TexturePool, look_up

_KINDS = ("plain", "picture", "stripes", "checks", "dots")
_SHARES = (0.45, 0.25, 0.13, 0.09, 0.08)
_DARK_FRAMES = 0.6


def fabric(uv: np.ndarray, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Linear reflectance (P, 3) at texture coordinates (P, 2) of one random stuff."""
    kind = rng.choice(_KINDS, p=_SHARES)
    if kind == "picture":
        return look_up(pool.picture(rng), uv, rng.uniform(1, 5))
    first, second = _dye(rng), _dye(rng)
    if kind == "plain":
        blend = np.zeros(len(uv), np.float32)
    elif kind == "stripes":
        blend = _stripes(uv, rng)
    elif kind == "checks":
        blend = _sharp(np.sin(_phase(uv[:, 0], rng)) + np.sin(_phase(uv[:, 1], rng)), rng)
    else:
        blend = _sharp(np.sin(_phase(uv[:, 0], rng)) * np.sin(_phase(uv[:, 1], rng)) - rng.uniform(0.2, 0.7), rng)
    colour = first + (second - first) * blend[:, None]
    return (colour * _weave(uv, pool, rng)[:, None]).astype(np.float32)


def frame(uv: np.ndarray, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Linear reflectance (P, 3) of the frame of glasses: black or nearly, else any stuff."""
    if rng.random() >= _DARK_FRAMES:
        return fabric(uv, pool, rng)
    dark = rng.uniform(0.015, 0.06) * np.exp(rng.normal(0, 0.25, 3))
    return np.broadcast_to(dark.astype(np.float32), (len(uv), 3))


def _dye(rng: np.random.Generator) -> np.ndarray:
    """A colour: neutral from black to white, muted, or anything."""
    chance = rng.random()
    if chance < 0.4:
        return rng.beta(0.5, 0.7) * np.exp(rng.normal(0, 0.05, 3))
    if chance < 0.7:
        return rng.uniform(0.02, 0.5) * np.exp(rng.normal(0, 0.35, 3))
    return rng.beta(0.6, 0.9, 3)


def _phase(along: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return 2 * np.pi * rng.integers(3, 30) * along + rng.uniform(0, 2 * np.pi)


def _stripes(uv: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Rings around, ribs along, or slanted stripes."""
    way = rng.integers(3)
    if way == 2:
        return _sharp(np.sin(_phase(uv @ rng.normal(0, 1, 2), rng)), rng)
    return _sharp(np.sin(_phase(uv[:, way], rng)) - rng.uniform(-0.6, 0.6), rng)


def _sharp(wave: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return np.clip(0.5 + wave * rng.uniform(1, 20), 0, 1)


def _weave(uv: np.ndarray, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Threads and wear (P,), about 1."""
    wear = rng.uniform(0, 0.2) * look_up(pool.noise(rng), uv, int(rng.integers(2, 5)))
    threads = np.zeros(len(uv))
    if rng.random() < 0.4:
        count = rng.integers(40, 160)
        threads = rng.uniform(0.05, 0.3) * np.sin(2 * np.pi * count * uv[:, 0]) * np.sin(2 * np.pi * count * uv[:, 1])
    return np.exp(wear + threads)
