"""Scenes to put people before, drawn a few with every head and looked at in many ways.

A network that is to tell a person from what lies behind needs to have seen what lies behind. Photographs that may
be used are few, so layers of shapes are drawn instead, whose edges, sizes and colours are like those of real scenes
(the dead leaves model: Lee, Mumford and Huang 2001), beside views into panoramas where there are any.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import cv2
import numpy as np

from relight_core.dataset.cutouts.scenery.grounds import (
    backdrop,
    bokeh,
    clutter,
    folds,
    horizon,
    leaves,
    panels,
    shelves,
)
from relight_core.dataset.cutouts.scenery.panoramas import look_around
from relight_core.dataset.cutouts.scenery.places import park, room, with_crowns
from relight_core.dataset.cutouts.scenery.strokes import SIZE, falloff
from relight_core.dataset.cutouts.scenery.things import with_sign, with_things, with_trunks
from relight_core.dataset.painting.texture import TexturePool

_PANORAMA_SHARE, _PICTURE_SHARE = 0.3, 0.15

Drawing = Callable[[TexturePool, np.random.Generator], np.ndarray]


class SceneryPool:
    """Some scenes; views of them are drawn at random, turned over, recoloured, out of focus."""

    def __init__(
        self,
        pool: TexturePool,
        rng: np.random.Generator,
        count: int,
        panoramas: Sequence[np.ndarray] = (),
    ):
        self._pool = pool
        self._scenes = [_scene(pool, rng, panoramas) for _ in range(count)]

    def view(self, size: int, rng: np.random.Generator) -> np.ndarray:
        """(size, size, 3) float32 linear, about [0, 1]; where lights are seen, brighter."""
        scene = self._scenes[rng.integers(len(self._scenes))]
        if rng.random() < _PICTURE_SHARE:
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
        return (view * falloff(size, rng)).astype(np.float32)


def _scene(pool: TexturePool, rng: np.random.Generator, panoramas: Sequence[np.ndarray]) -> np.ndarray:
    """One scene, and at times things before it."""
    if len(panoramas) and rng.random() < _PANORAMA_SHARE:
        scene = look_around(panoramas[rng.integers(len(panoramas))], rng)
    else:
        scene = _GROUNDS[rng.integers(len(_GROUNDS))](pool, rng)
    for draw, share in _THINGS:
        if rng.random() < share:
            scene = draw(scene, pool, rng)
    return np.clip(scene, 0, 4).astype(np.float32)


_GROUNDS: tuple[Drawing, ...] = (
    *(backdrop, folds, shelves, panels, leaves, horizon, clutter, bokeh),
    *(room, room, room, room, park, park),
)
_THINGS = ((with_trunks, 0.2), (with_things, 0.25), (with_sign, 0.2), (with_crowns, 0.08))
