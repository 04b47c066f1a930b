"""Places put together from what fills and what stands in them: rooms with windows and curtains, parks."""

from __future__ import annotations

import cv2
import numpy as np

from relight_core.dataset.cutouts.scenery.grounds import backdrop, folds, horizon, leaves, panels, shelves
from relight_core.dataset.cutouts.scenery.strokes import SIZE, any_colour, falloff, put, unevenness
from relight_core.dataset.cutouts.scenery.things import with_trunks
from relight_core.dataset.painting.texture import TexturePool, fractal_noise


def room(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """A wall with a window or two, curtains at their sides, flags, a bookcase, a lamp, the back of a chair."""
    image = np.array(panels(pool, rng) if rng.random() < 0.3 else backdrop(pool, rng), np.float32)
    if rng.random() < 0.3:
        image[int(SIZE * rng.uniform(0.5, 0.9)) :] = backdrop(pool, rng)[:1, :1]
    if rng.random() < 0.3:
        wide = int(rng.integers(60, 200))
        put(image, shelves(pool, rng)[:, :wide], int(rng.integers(-30, SIZE - 30)), 0)
    for _ in range(int(rng.integers(0, 3))):
        _window(image, pool, rng)
    for _ in range(int(rng.integers(0, 3))):
        _hanging(image, int(rng.integers(-20, SIZE)), int(rng.integers(15, 80)), pool, rng)
    if rng.random() < 0.25:
        _lamp(image, rng)
    if rng.random() < 0.3:
        _chair(image, pool, rng)
    return image * falloff(SIZE, rng)


def park(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Sky and ground, trunks, and the crowns of trees before the sky."""
    image = with_trunks(horizon(pool, rng), pool, rng) if rng.random() < 0.6 else horizon(pool, rng)
    return with_crowns(image, pool, rng)


def with_crowns(image: np.ndarray, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Foliage from above, dense and dark here, with the sky shining through there."""
    down = (np.arange(SIZE, dtype=np.float32) / SIZE)[:, None]
    ragged = fractal_noise(rng, SIZE, rng.uniform(0.7, 1.4))
    cover = rng.uniform(1, 5) * (rng.uniform(0.1, 0.8) - down) + ragged
    alpha = 0.5 + 0.5 * np.tanh(rng.uniform(1, 6) * cover)
    tone = np.array([0.07, 0.09, 0.03], np.float32) * np.exp(rng.normal(0, 0.35, 3)) * 2 ** rng.normal(-0.5, 1.2)
    if rng.random() < 0.3:
        tone = any_colour(rng) * 0.4
    crown = tone * np.exp(rng.uniform(0.2, 0.9) * fractal_noise(rng, SIZE, rng.uniform(0.3, 1.0))[..., None])
    return image * (1 - alpha[..., None]) + crown * alpha[..., None]


def _window(image: np.ndarray, pool: TexturePool, rng: np.random.Generator) -> None:
    wide, high = int(rng.integers(50, 230)), int(rng.integers(120, SIZE + 60))
    x, y = int(rng.integers(-40, SIZE - 20)), int(rng.integers(-80, 90))
    outside = (_daylight, leaves, horizon, park, _picture)[rng.integers(5)](pool, rng) * 2 ** rng.uniform(-1, 2)
    pane = cv2.GaussianBlur(cv2.resize(np.asarray(outside, np.float32), (wide, high)), (0, 0), rng.uniform(0.5, 6))
    bar = any_colour(rng).tolist()
    across, along = int(rng.integers(1, 5)), int(rng.integers(1, 8))
    thick = int(rng.integers(2, 8))
    for n in range(across + 1):
        cv2.line(pane, (n * wide // across, 0), (n * wide // across, high), bar, thick)
    for n in range(along + 1):
        cv2.line(pane, (0, n * high // along), (wide, n * high // along), bar, thick)
    put(image, pane, x, y)
    if rng.random() < 0.6:
        cloth, width = folds(pool, rng), int(rng.integers(15, 90))
        shift = int(rng.integers(0, SIZE - width))
        strip = cloth[:, shift : shift + width]
        put(image, strip, x - int(width * rng.uniform(0.2, 0.8)), 0)
        put(image, strip[:, ::-1], x + wide - int(width * rng.uniform(0.2, 0.8)), 0)
        if rng.random() < 0.4:
            put(image, folds(pool, rng)[: int(rng.integers(20, 80)), : wide + 2 * width], x - width, max(y, 0))


def _daylight(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """What is too bright to be seen through a window."""
    return np.ones((SIZE, SIZE, 1), np.float32) * rng.uniform(0.7, 1.2, 3) * falloff(SIZE, rng)


def _picture(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    return pool.picture(rng)


def _hanging(image: np.ndarray, x: int, width: int, pool: TexturePool, rng: np.random.Generator) -> None:
    """A flag or a single curtain: folded cloth that widens downward, at times on a pole."""
    top = int(rng.integers(-40, 120))
    rows = np.arange(SIZE, dtype=np.float32)
    widening = 0.5 * width * (0.4 + 0.6 * np.clip((rows - top) / SIZE, 0, 1)) + 3 * fractal_noise(rng, SIZE, 1.5)[0]
    across = np.abs(np.arange(SIZE)[None] - x - rng.normal(0, 0.05) * rows[:, None])
    inside = (across < widening[:, None]) & (rows[:, None] > top)
    image[inside] = np.asarray(folds(pool, rng), np.float32)[inside]
    if rng.random() < 0.5:
        cv2.line(image, (x, 0), (x, SIZE), any_colour(rng).tolist(), int(rng.integers(1, 5)))


def _lamp(image: np.ndarray, rng: np.random.Generator) -> None:
    x, y = (float(v) for v in rng.integers(0, SIZE, 2))
    rows, columns = np.mgrid[:SIZE, :SIZE].astype(np.float32)
    far = np.hypot(columns - x, rows - y) / rng.uniform(8, 60)
    glow = rng.uniform(0.5, 3) * np.exp(-(far**2)) + 0.2 / (1 + far**2)
    image += glow[..., None] * np.array([1, 0.8, 0.55]) ** rng.uniform(0, 2)


def _chair(image: np.ndarray, pool: TexturePool, rng: np.random.Generator) -> None:
    mask = np.zeros((SIZE, SIZE), np.uint8)
    x, y = int(rng.integers(0, SIZE)), int(rng.integers(SIZE // 3, SIZE))
    wide, high = (int(v) for v in rng.integers(40, 170, 2))
    cv2.rectangle(mask, (x - wide // 2, y), (x + wide // 2, SIZE), 1, -1)
    cv2.ellipse(mask, (x, y), (wide // 2, high // 3), 0, 0, 360, 1, -1)
    stuff = any_colour(rng) * np.exp(0.2 * unevenness(pool, rng)) * falloff(SIZE, rng)
    image[mask > 0] = stuff.astype(np.float32)[mask > 0]
