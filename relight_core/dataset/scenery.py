"""What stands behind people in photographs, drawn: walls, shelves, curtains, leaves, trunks, skies, lights, signs.

A network that is to tell a person from what lies behind needs to have seen what lies behind. Photographs that may
be used are few, so layers of shapes are drawn instead, whose edges, sizes and colours are like those of real scenes
(the dead leaves model: Lee, Mumford and Huang 2001).
"""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from relight_core.dataset.texture import TexturePool, fractal_noise

SIZE = 384
"""Side of a drawn scene; views of it are cut out."""

_POOLED = 96
_GREENS = np.array([[0.10, 0.20, 0.04], [0.22, 0.26, 0.06], [0.05, 0.10, 0.03], [0.30, 0.22, 0.10]], np.float32)

Drawing = Callable[[TexturePool, np.random.Generator], np.ndarray]


class SceneryPool:
    """Scenes drawn once per process; views of them are drawn at random, turned over, recoloured, out of focus."""

    def __init__(self, pool: TexturePool, rng: np.random.Generator, count: int = _POOLED):
        self._pool = pool
        self._scenes = [_scene(pool, rng) for _ in range(count)]

    def view(self, size: int, rng: np.random.Generator) -> np.ndarray:
        """(size, size, 3) float32 linear, about [0, 1]; where lights are seen, brighter."""
        scene = self._scenes[rng.integers(len(self._scenes))]
        if rng.random() < 0.25:
            # Coarse panoramas are among the pictures: their texels are no scene.
            scene = cv2.GaussianBlur(cv2.resize(self._pool.picture(rng), (SIZE, SIZE)), (0, 0), 3.0)
        side = int(rng.integers(SIZE // 3, SIZE + 1))
        y, x = rng.integers(0, SIZE - side + 1, 2)
        view = cv2.resize(scene[y : y + side, x : x + side], (size, size), interpolation=cv2.INTER_LINEAR)
        if rng.random() < 0.5:
            view = view[:, ::-1]
        if rng.random() < 0.3:
            view = view[..., rng.permutation(3)]
        view = view * np.exp(rng.normal(0, 0.25, 3)) * 2 ** rng.normal(0, 0.8)
        if rng.random() < 0.6:
            view = cv2.GaussianBlur(view, (0, 0), size * 10 ** rng.uniform(-2.5, -1.2))
        return (view * _falloff(size, rng)).astype(np.float32)


def _scene(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """One drawn scene: a ground, and at times things before it."""
    ground = _GROUNDS[rng.integers(len(_GROUNDS))](pool, rng)
    for draw in _THINGS:
        if rng.random() < 0.3:
            ground = draw(ground, pool, rng)
    return np.clip(ground, 0, 4).astype(np.float32)


def _falloff(size: int, rng: np.random.Generator) -> np.ndarray:
    """A wall is lit unevenly: (size, size, 1)."""
    axis = (np.arange(size, dtype=np.float32) + 0.5) / size * 2 - 1
    slope_x, slope_y, bow = rng.normal(0, 0.35, 3)
    stops = slope_x * axis[None] + slope_y * axis[:, None] + bow * (axis[None] ** 2 + axis[:, None] ** 2)
    return np.exp2(stops)[..., None]


def _colour(rng: np.random.Generator) -> np.ndarray:
    """A paint or a stuff: mostly muted."""
    grey = rng.beta(0.9, 1.3)
    tint = np.exp(rng.normal(0, 0.12 if rng.random() < 0.6 else 0.7, 3))
    return np.clip(grey * tint / tint.mean(), 0.003, 1.2).astype(np.float32)


def _noise(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    return cv2.resize(pool.noise(rng), (SIZE, SIZE))[..., None]


def _backdrop(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """A studio's: plain, mottled, or two tones running into each other."""
    blend = 1 / (1 + np.exp(-rng.uniform(0.3, 2) * _noise(pool, rng)))
    near = _colour(rng)
    return near * (1 - blend) + near * np.exp(rng.normal(0, 0.5, 3)) * blend


def _folds(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """A curtain or a flag: stripes of its own and the shading of its folds."""
    y, x = np.mgrid[:SIZE, :SIZE].astype(np.float32) / SIZE
    across = x + rng.normal(0, 0.15) * y + 0.03 * _noise(pool, rng)[..., 0]
    shade = sum(
        rng.uniform(0.1, 0.4) * np.sin(2 * np.pi * (rng.uniform(2, 22) * across + rng.random())) for _ in range(4)
    )
    cloth = np.broadcast_to(_colour(rng), (SIZE, SIZE, 3))
    if rng.random() < 0.4:
        along = y if rng.random() < 0.5 else across
        stripes = (np.sin(2 * np.pi * rng.uniform(3, 15) * (along + 0.02 * shade)) > rng.uniform(-0.5, 0.5))[..., None]
        cloth = np.where(stripes, cloth, _colour(rng))
    return cloth * np.exp(rng.uniform(0.4, 1.4) * shade)[..., None]


def _shelves(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Rows of upright things, of books or bottles, between boards."""
    image = np.full((SIZE, SIZE, 3), _colour(rng) * 0.3, np.float32)
    pitch = int(rng.integers(30, 120))
    for bottom in range(int(rng.integers(0, pitch)), SIZE + pitch, pitch):
        left = 0
        while left < SIZE:
            wide = int(rng.integers(3, 22))
            top = bottom - int(pitch * rng.uniform(0.5, 0.9))
            cv2.rectangle(image, (left, top), (left + wide - 1, bottom), _colour(rng).tolist(), -1)
            left += wide + int(rng.random() < 0.15) * wide
        cv2.rectangle(image, (0, bottom), (SIZE, bottom + 4), _colour(rng).tolist(), -1)
    return image * np.exp(0.1 * _noise(pool, rng))


def _panels(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """A wall with frames, doors, windows, tiles or bricks."""
    image = np.full((SIZE, SIZE, 3), _colour(rng), np.float32)
    if rng.random() < 0.4:
        wide, high = (int(v) for v in rng.integers(12, 70, 2))
        joint = (_colour(rng)).tolist()
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
            inside = np.broadcast_to(_colour(rng) * 2 ** rng.normal(0, 1), (high, wide, 3))
        _put(image, inside, x, y)
        cv2.rectangle(image, (x, y), (x + wide, y + high), _colour(rng).tolist(), int(rng.integers(1, 9)))
    return image * np.exp(0.08 * _noise(pool, rng))


def _leaves(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Foliage, at times with the sky in its gaps: what hair is most often taken for."""
    sky = rng.random() < 0.5
    image = np.full((SIZE, SIZE, 3), rng.uniform(0.5, 1.5, 3) if sky else _colour(rng) * 0.2, np.float32)
    tones = _GREENS * 2 ** rng.normal(0, 0.8) if rng.random() < 0.7 else np.stack([_colour(rng) for _ in range(4)])
    clumps = fractal_noise(rng, SIZE, 1.3)
    size = rng.uniform(2, 9)
    for x, y in rng.integers(0, SIZE, (int(rng.integers(600, 2200)), 2)):
        if sky and clumps[y, x] < -0.3:
            continue
        tone = tones[rng.integers(4)] * 2 ** (rng.normal(0, 0.6) + 0.5 * clumps[y, x])
        axes = (max(int(size * rng.uniform(0.5, 1.6)), 1), max(int(size * rng.uniform(0.15, 0.7)), 1))
        cv2.ellipse(image, (int(x), int(y)), axes, float(rng.uniform(0, 180)), 0, 360, tone.tolist(), -1)
    return image


def _horizon(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Sky over ground, with a skyline of houses, hills or hedges."""
    y = (np.arange(SIZE, dtype=np.float32) / SIZE)[:, None, None]
    sky = rng.uniform(0.3, 1.4) * (np.array([0.45, 0.65, 1.0]) * (1 - y) + y * rng.uniform(0.7, 1.1, 3))
    image = np.broadcast_to(sky, (SIZE, SIZE, 3)).astype(np.float32)
    image = image * (1 + 0.4 * np.clip(_noise(pool, rng), 0, 2) * (rng.random() < 0.5))
    line = SIZE * (rng.uniform(0.3, 0.9) + rng.uniform(0, 0.08) * fractal_noise(rng, SIZE, 1.0)[0])
    if rng.random() < 0.5:
        steps = rng.integers(8, 50)
        line = np.repeat(line[::steps], steps)[:SIZE] + rng.normal(0, 6)
    ground = _leaves(pool, rng) if rng.random() < 0.4 else _backdrop(pool, rng) * np.exp(0.4 * _noise(pool, rng))
    return np.where((np.arange(SIZE)[:, None] > line[None])[..., None], ground, image)


def _clutter(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Dead leaves: shapes of all sizes over each other, each shaded or of a stuff of its own."""
    image = _backdrop(pool, rng).astype(np.float32)
    for _ in range(int(rng.integers(40, 250))):
        image = _shape(image, 6 * (1 - rng.random()) ** -0.7, pool, rng)
    return image


def _bokeh(pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Lamps out of focus before the dark."""
    image = np.full((SIZE, SIZE, 3), _colour(rng) * 0.2, np.float32)
    radius = rng.uniform(3, 22)
    for x, y in rng.integers(0, SIZE, (int(rng.integers(15, 150)), 2)):
        disc = np.zeros_like(image)
        colour = np.exp(rng.normal(0, 0.5, 3)) * 10 ** rng.uniform(-1, 0.4)
        cv2.circle(disc, (int(x), int(y)), max(int(radius * rng.uniform(0.7, 1.2)), 1), colour.tolist(), -1)
        image += disc
    return image


def _with_trunks(image: np.ndarray, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Upright round things: trunks, columns, poles."""
    for _ in range(int(rng.integers(1, 4))):
        middle, half = rng.uniform(0, SIZE), rng.uniform(3, 60)
        y, x = np.mgrid[:SIZE, :SIZE].astype(np.float32)
        place = (x - middle - rng.normal(0, 0.15) * (y - SIZE / 2)) / half
        shade = np.clip(0.3 + 0.7 * np.cos(np.clip(place - rng.normal(0, 0.4), -1.5, 1.5)), 0.05, 1)
        bark = _colour(rng) * np.exp(rng.uniform(0, 0.6) * _noise(pool, rng))
        image = np.where((np.abs(place) < 1)[..., None], bark * shade[..., None], image)
    return image


def _with_things(image: np.ndarray, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """A few large things: furniture, cars, doors."""
    image = np.ascontiguousarray(image, np.float32)
    for _ in range(int(rng.integers(1, 9))):
        image = _shape(image, rng.uniform(15, 110), pool, rng)
    return image


def _with_sign(image: np.ndarray, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Letters and rings, as on posters and seals."""
    image = np.ascontiguousarray(image, np.float32)
    for _ in range(int(rng.integers(1, 5))):
        x, y = (int(v) for v in rng.integers(0, SIZE, 2))
        colour, thick = _colour(rng).tolist(), int(rng.integers(1, 12))
        if rng.random() < 0.4:
            cv2.circle(image, (x, y), int(rng.integers(15, 140)), colour, thick, cv2.LINE_AA)
        else:
            word = "".join(chr(c) for c in rng.integers(65, 91, int(rng.integers(2, 9))))
            cv2.putText(image, word, (x - 60, y), int(rng.integers(0, 8)), rng.uniform(0.5, 4), colour, thick)
    return image


def _shape(image: np.ndarray, radius: float, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """One ellipse, box or ragged blob, plain, shaded or of some stuff."""
    mask = np.zeros((SIZE, SIZE), np.uint8)
    x, y = (int(v) for v in rng.integers(0, SIZE, 2))
    axes = np.maximum(radius * rng.uniform(0.4, 1.6, 2), 1).astype(int)
    kind = rng.integers(3)
    if kind == 0:
        cv2.ellipse(mask, (x, y), axes.tolist(), float(rng.uniform(0, 180)), 0, 360, 1, -1)
    elif kind == 1:
        box = cv2.boxPoints(((x, y), tuple(2.0 * axes), float(rng.normal(0, 20))))
        cv2.fillPoly(mask, [box.astype(np.int32)], 1)
    else:
        angles = np.sort(rng.uniform(0, 2 * np.pi, int(rng.integers(3, 10))))
        reach = axes.max() * rng.uniform(0.4, 1.2, len(angles))
        corners = np.stack([x + reach * np.cos(angles), y + reach * np.sin(angles)], 1)
        cv2.fillPoly(mask, [corners.astype(np.int32)], 1)
    stuff = np.broadcast_to(_colour(rng), image.shape)
    if rng.random() < 0.3:
        stuff = cv2.resize(pool.picture(rng), (SIZE, SIZE)) * 2 ** rng.normal(0, 0.8)
    if rng.random() < 0.5:
        stuff = stuff * _falloff(SIZE, rng)
    return np.where(mask[..., None] > 0, stuff, image)


def _put(image: np.ndarray, part: np.ndarray, x: int, y: int) -> None:
    """Lay a picture over another in place, as far as it fits."""
    x0, y0 = max(x, 0), max(y, 0)
    cut = part[y0 - y : image.shape[0] - y, x0 - x : image.shape[1] - x]
    image[y0 : y0 + cut.shape[0], x0 : x0 + cut.shape[1]] = cut


_GROUNDS: tuple[Drawing, ...] = (_backdrop, _folds, _shelves, _panels, _leaves, _leaves, _horizon, _clutter, _bokeh)
_THINGS = (_with_trunks, _with_things, _with_sign)
