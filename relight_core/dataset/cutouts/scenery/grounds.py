"""What fills a picture behind a person: backdrops, cloths, shelves, walls, leaves, skies, clutter, lamps."""

from __future__ import annotations

import cv2
import numpy as np

from relight_core.dataset.cutouts.scenery.strokes import SIZE, any_colour, any_shape, put, unevenness
from relight_core.dataset.painting.texture import TexturePool, fractal_noise

_GREENS = np.array([[0.10, 0.20, 0.04], [0.22, 0.26, 0.06], [0.05, 0.10, 0.03], [0.30, 0.22, 0.10]], np.float32)


def backdrop(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """A studio's: plain, mottled, or two tones running into each other."""
    blend = 1 / (1 + np.exp(-rng.uniform(0.3, 2) * unevenness(pool, rng)))
    near = any_colour(rng)
    return near * (1 - blend) + near * np.exp(rng.normal(0, 0.5, 3)) * blend


def folds(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """A curtain or a flag: stripes of its own and the shading of its folds."""
    y, x = np.mgrid[:SIZE, :SIZE].astype(np.float32) / SIZE
    across = x + rng.normal(0, 0.15) * y + 0.03 * unevenness(pool, rng)[..., 0]
    shade = sum(
        rng.uniform(0.1, 0.4) * np.sin(2 * np.pi * (rng.uniform(2, 22) * across + rng.random())) for _ in range(4)
    )
    cloth = np.broadcast_to(any_colour(rng), (SIZE, SIZE, 3))
    if rng.random() < 0.4:
        along = y if rng.random() < 0.5 else across
        stripes = (np.sin(2 * np.pi * rng.uniform(3, 15) * (along + 0.02 * shade)) > rng.uniform(-0.5, 0.5))[..., None]
        cloth = np.where(stripes, cloth, any_colour(rng))
    return cloth * np.exp(rng.uniform(0.4, 1.4) * shade)[..., None]


def shelves(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Rows of upright things, of books or bottles, between boards."""
    image = np.full((SIZE, SIZE, 3), any_colour(rng) * 0.3, np.float32)
    pitch = int(rng.integers(30, 120))
    for bottom in range(int(rng.integers(0, pitch)), SIZE + pitch, pitch):
        left = 0
        while left < SIZE:
            wide = int(rng.integers(3, 22))
            top = bottom - int(pitch * rng.uniform(0.5, 0.9))
            cv2.rectangle(image, (left, top), (left + wide - 1, bottom), any_colour(rng).tolist(), -1)
            left += wide + int(rng.random() < 0.15) * wide
        cv2.rectangle(image, (0, bottom), (SIZE, bottom + 4), any_colour(rng).tolist(), -1)
    return image * np.exp(0.1 * unevenness(pool, rng))


def panels(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """A wall with frames, doors, windows, tiles or bricks."""
    image = np.full((SIZE, SIZE, 3), any_colour(rng), np.float32)
    if rng.random() < 0.4:
        wide, high = (int(v) for v in rng.integers(12, 70, 2))
        joint = (any_colour(rng)).tolist()
        for row, y in enumerate(range(0, SIZE, high)):
            cv2.line(image, (0, y), (SIZE, y), joint, 1 + int(rng.random() < 0.3))
            for x in range((row % 2) * wide // 2, SIZE, wide):
                cv2.rectangle(image, (x, y), (x + wide, y + high), (image[0, 0] * rng.uniform(0.8, 1.2)).tolist(), -1)
                cv2.line(image, (x, y), (x, y + high), joint, 1)
    for _ in range(int(rng.integers(0, 7))):
        x, y = (int(v) for v in rng.integers(-40, SIZE, 2))
        wide, high = (int(v) for v in rng.integers(30, 220, 2))
        inside = cv2.resize(pool.picture(rng), (wide, high)) * 2 ** rng.normal(0, 1)
        if rng.random() < 0.5:
            inside = np.broadcast_to(any_colour(rng) * 2 ** rng.normal(0, 1), (high, wide, 3))
        put(image, inside, x, y)
        cv2.rectangle(image, (x, y), (x + wide, y + high), any_colour(rng).tolist(), int(rng.integers(1, 9)))
    return image * np.exp(0.08 * unevenness(pool, rng))


def leaves(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Foliage, at times with the sky in its gaps: what hair is most often taken for."""
    sky = rng.random() < 0.5
    image = np.full((SIZE, SIZE, 3), rng.uniform(0.5, 1.5, 3) if sky else any_colour(rng) * 0.2, np.float32)
    tones = _GREENS * 2 ** rng.normal(0, 0.8) if rng.random() < 0.7 else np.stack([any_colour(rng) for _ in range(4)])
    clumps = fractal_noise(rng, SIZE, 1.3)
    size = rng.uniform(2, 9)
    for x, y in rng.integers(0, SIZE, (int(rng.integers(600, 2200)), 2)):
        if sky and clumps[y, x] < -0.3:
            continue
        tone = tones[rng.integers(4)] * 2 ** (rng.normal(0, 0.6) + 0.5 * clumps[y, x])
        axes = (max(int(size * rng.uniform(0.5, 1.6)), 1), max(int(size * rng.uniform(0.15, 0.7)), 1))
        cv2.ellipse(image, (int(x), int(y)), axes, float(rng.uniform(0, 180)), 0, 360, tone.tolist(), -1)
    return image


def horizon(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Sky over ground, with a skyline of houses, hills or hedges."""
    y = (np.arange(SIZE, dtype=np.float32) / SIZE)[:, None, None]
    sky = rng.uniform(0.3, 1.4) * (np.array([0.45, 0.65, 1.0]) * (1 - y) + y * rng.uniform(0.7, 1.1, 3))
    image = np.broadcast_to(sky, (SIZE, SIZE, 3)).astype(np.float32)
    image = image * (1 + 0.4 * np.clip(unevenness(pool, rng), 0, 2) * (rng.random() < 0.5))
    line = SIZE * (rng.uniform(0.3, 0.9) + rng.uniform(0, 0.08) * fractal_noise(rng, SIZE, 1.0)[0])
    if rng.random() < 0.5:
        steps = rng.integers(8, 50)
        line = np.repeat(line[::steps], steps)[:SIZE] + rng.normal(0, 6)
    ground = leaves(pool, rng) if rng.random() < 0.4 else backdrop(pool, rng) * np.exp(0.4 * unevenness(pool, rng))
    return np.where((np.arange(SIZE)[:, None] > line[None])[..., None], ground, image)


def clutter(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Dead leaves: shapes of all sizes over each other, each shaded or of a stuff of its own."""
    image = backdrop(pool, rng).astype(np.float32)
    for _ in range(int(rng.integers(40, 250))):
        image = any_shape(image, 6 * (1 - rng.random()) ** -0.7, pool, rng)
    return image


def bokeh(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Lamps out of focus before the dark."""
    image = np.full((SIZE, SIZE, 3), any_colour(rng) * 0.2, np.float32)
    radius = rng.uniform(3, 22)
    for x, y in rng.integers(0, SIZE, (int(rng.integers(15, 150)), 2)):
        disc = np.zeros_like(image)
        colour = np.exp(rng.normal(0, 0.5, 3)) * 10 ** rng.uniform(-1, 0.4)
        cv2.circle(disc, (int(x), int(y)), max(int(radius * rng.uniform(0.7, 1.2)), 1), colour.tolist(), -1)
        image += disc
    return image
