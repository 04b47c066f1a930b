"""What stands before a lamp and throws a shadow with edges: leaves, blinds, a brim, a window's bars, a hand, a wall.

Stage lighting calls such patterns gobos. `lighting.occluders` has things whose shadows are as soft as the light that
the heads are baked for; here they are drawn, and as sharp as sun makes them.
"""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from relight_core.dataset.painting.texture import TexturePool

_TEXTURE_PX = 384
_REACH = 1.6
"""Half the width of what is drawn, in half-widths of the view: a head's depth moves a shadow over it."""
_PARALLAX = 0.7
_FINGERS = (1.5, 1.75, 1.65, 1.25)
"""Their lengths, in half-widths of the palm."""
_SHARPEST, _SOFTEST = -2.9, -1.4
"""Deviation of the edges' blur, powers of ten of the view's side."""


def sample_gobo(relief: np.ndarray, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """How much of a lamp reaches each pixel of a head past a random gobo.

    Args:
        relief: (S, S) height toward the camera in half-widths of the view: the lamp stands aside of the camera, so
            that a straight edge bends over a nose.

    Returns:
        (S, S) float32 in [0, 1].
    """
    size = len(relief)
    drawn = _draw(pool, rng)
    passes = drawn if rng.random() < 0.5 else 1 - drawn
    axis = ((np.arange(size) + 0.5) / size * 2 - 1).astype(np.float32)
    x, y = np.meshgrid(axis, axis)
    toward_x, toward_y = rng.normal(0, _PARALLAX, 2).astype(np.float32)
    wave = cv2.resize(rng.standard_normal((2, 4, 4)).transpose(1, 2, 0).astype(np.float32), (size, size))
    wave = wave * np.float32(rng.choice([0, 0.04, 0.1]))
    places = (np.stack([x + toward_x * relief, y + toward_y * relief], -1) + wave) / (2 * _REACH) + 0.5
    places = np.ascontiguousarray((places * _TEXTURE_PX - 0.5).astype(np.float32))
    seen = cv2.remap(passes, places, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    softness_px = size * 10 ** rng.uniform(_SHARPEST, _SOFTEST)
    return np.clip(cv2.GaussianBlur(seen, (0, 0), softness_px), 0, 1)


def _draw(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """(T, T) float32, 1 inside of something."""
    kinds: tuple[Callable[[TexturePool, np.random.Generator], np.ndarray], ...]
    kinds = (_edge, _disc, _leaves, _bars, _branches, _edge, _leaves, _hand)
    return kinds[rng.integers(len(kinds))](pool, rng)


def _grid() -> tuple[np.ndarray, np.ndarray]:
    axis = ((np.arange(_TEXTURE_PX) + 0.5) / _TEXTURE_PX * 2 - 1).astype(np.float32) * np.float32(_REACH)
    return np.meshgrid(axis, axis)


def _turned(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    x, y = _grid()
    angle = rng.uniform(0, 2 * np.pi)
    cosine, sine = np.float32(np.cos(angle)), np.float32(np.sin(angle))
    return x * cosine + y * sine, y * cosine - x * sine


def _filled(distance: np.ndarray) -> np.ndarray:
    """1 where a signed distance, in half-widths of the view, is below 0, its edge a pixel of the texture wide."""
    return np.clip(0.5 - distance * (_TEXTURE_PX / (2 * _REACH)), 0, 1).astype(np.float32)


def _edge(_pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """A wall's, a door's or, bent, a brim's."""
    along, across = _turned(rng)
    bend = rng.uniform(-0.8, 0.8) * (rng.random() < 0.6)
    return _filled(across + bend * (along - rng.uniform(-0.3, 0.3)) ** 2 - rng.uniform(-0.5, 0.5))


def _disc(_pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """A ball, a head in front, a spot."""
    along, across = _turned(rng)
    (cx, cy), radius, stretch = rng.uniform(-0.6, 0.6, 2), rng.uniform(0.12, 0.7), rng.uniform(0.5, 1.0)
    return _filled(np.hypot(along - cx, (across - cy) / stretch) - radius)


def _leaves(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    noise = cv2.resize(pool.noise(rng), (_TEXTURE_PX, _TEXTURE_PX))
    noise = cv2.GaussianBlur(noise, (0, 0), _TEXTURE_PX * 10 ** rng.uniform(-2.1, -1.2))
    high = (noise - np.quantile(noise, rng.uniform(0.25, 0.8))) / max(float(noise.std()), 1e-6)
    steepness = np.hypot(*np.gradient(high)).mean()
    return np.clip(0.5 + high / max(2 * float(steepness), 1e-6), 0, 1).astype(np.float32)


def _bars(_pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Blinds, fences; crossed, a window's bars."""
    along, across = _turned(rng)
    filled = np.zeros_like(along)
    for axis in (along, across)[: 1 + int(rng.random() < 0.35)]:
        period, share = rng.uniform(0.12, 0.9), rng.uniform(0.2, 0.65)
        phase = (axis / period + rng.random()) % 1
        filled = np.maximum(filled, _filled((np.abs(phase - 0.5) - share / 2) * period))
    return filled


def _branches(_pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Twigs, strands, a pole, the temple of a pair of glasses."""
    image = np.zeros((_TEXTURE_PX, _TEXTURE_PX), np.uint8)
    for _ in range(rng.integers(1, 9)):
        start, bow = rng.uniform(-1, 1, 2), rng.normal(0, 0.35, 2)
        end = start + rng.normal(0, 1.0, 2)
        way = np.linspace(0, 1, 16)[:, None]
        points = start + (end - start) * way + bow * (way * (1 - way))
        points = ((points / (2 * _REACH) + 0.5) * _TEXTURE_PX).astype(np.int32)
        thickness = max(1, int(_TEXTURE_PX * 10 ** rng.uniform(-2.4, -1.1)))
        cv2.polylines(image, [points], False, 255, thickness, cv2.LINE_AA)
    return image.astype(np.float32) / 255


def _hand(_pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """A palm, its fingers, together or spread, stretched or closed, and its arm."""
    palm, (cx, cy) = rng.uniform(0.12, 0.35), rng.uniform(-0.6, 0.6, 2)
    angle, spread = rng.uniform(0, 2 * np.pi), rng.uniform(0.05, 0.3)
    along, aside = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    aside = aside * rng.choice([-1, 1])
    middle = np.array([cx, cy])
    arm = (middle, middle - 3 * along + rng.normal(0, 0.3, 2), 0.75 * palm)
    limbs = [arm, (middle - 0.3 * palm * along, middle + 0.4 * palm * along, palm)]
    for offset, length in zip((-1.5, -0.5, 0.5, 1.5), _FINGERS, strict=True):
        root = middle + palm * (0.9 * along + 0.55 * offset * aside)
        toward = np.sin(offset * spread) * aside + np.cos(offset * spread) * along
        closed = rng.choice([1, 1, 1, 0.4])
        limbs.append((root, root + palm * length * closed * toward, 0.23 * palm))
    root, thumb = middle - 0.9 * palm * aside, along * rng.uniform(0.2, 0.9) - aside * rng.uniform(0.1, 0.9)
    limbs.append((root, root + 1.3 * palm * thumb, 0.28 * palm))
    x, y = _grid()
    return _filled(np.min([_away(x, y, *limb) for limb in limbs], 0))


def _away(x: np.ndarray, y: np.ndarray, start: np.ndarray, end: np.ndarray, radius: float) -> np.ndarray:
    """Signed distance from a rod with round ends."""
    way = (end - start).astype(np.float32)
    px, py = x - np.float32(start[0]), y - np.float32(start[1])
    share = ((px * way[0] + py * way[1]) / max(float(way @ way), 1e-6)).clip(0, 1)
    return np.hypot(px - share * way[0], py - share * way[1]) - np.float32(radius)
