"""What else is in a portrait and belongs to no target: a light that reaches a part of the head, people behind."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.dataset.painting.texture import TexturePool


@dataclass(frozen=True)
class LocalLight:
    """A second light that does not reach all of a head: a spot, sun through a window or through leaves.

    Attributes:
        reach: (S, S, 1) in [0, 1], how much of it reaches each pixel.
        colour: (3,) factors on its radiance.
    """

    reach: np.ndarray
    colour: np.ndarray


@dataclass(frozen=True)
class Neighbour:
    """Somebody else in the picture.

    Attributes:
        radiance: (S, S, 3) linear.
        coverage: (S, S, 1) in [0, 1].
    """

    radiance: np.ndarray
    coverage: np.ndarray


def sample_local_light(size: int, pool: TexturePool, rng: np.random.Generator) -> LocalLight:
    """A half-plane, a disc or dapples with soft edges; coloured by half."""
    chance = rng.random()
    if chance < 0.6:
        axis = (np.arange(size) + 0.5) / size * 2 - 1
        x, y = np.meshgrid(axis, axis)
        angle, place = rng.uniform(0, 2 * np.pi), rng.uniform(-0.4, 0.7)
        distance = x * np.cos(angle) + y * np.sin(angle) - place
        if chance < 0.25:
            cx, cy = rng.uniform(-0.7, 0.7, 2)
            distance = rng.uniform(0.15, 0.6) - np.hypot(x - cx, y - cy)
        softness = 10 ** rng.uniform(-1.5, -0.2)
    else:
        leaves = cv2.GaussianBlur(cv2.resize(pool.noise(rng), (size, size)), (0, 0), size * rng.uniform(0.02, 0.06))
        distance = leaves / max(float(leaves.std()), 1e-6) - rng.uniform(0.2, 1.2)
        softness = 10 ** rng.uniform(-0.8, 0)
    reach = np.clip(distance / softness + 0.5, 0, 1).astype(np.float32)[..., None]
    colour = np.exp(rng.normal(0, 0.7 if rng.random() < 0.5 else 0.1, 3))
    return LocalLight(reach, (colour / colour.mean() * 10 ** rng.uniform(-0.7, 0.3)).astype(np.float32))


def sample_neighbour(radiance: np.ndarray, covered: np.ndarray, rng: np.random.Generator) -> Neighbour:
    """Another lit head (S, S, 3), moved aside until half of it or less is behind the one in front, and out of focus.

    Its clothes and hair look like those in front, so that only its place tells that it is not meant.
    """
    size = len(covered)
    scale = rng.uniform(0.6, 1.2)
    aside = rng.choice([-1, 1]) * rng.uniform(0.45, 0.85) * size
    mirror = rng.choice([-1, 1])
    middle = (size - 1) / 2
    shift_x = middle + aside - scale * mirror * middle
    shift_y = middle + rng.normal(0, 0.15) * size - scale * middle
    matrix = np.array([[scale * mirror, 0, shift_x], [0, scale, shift_y]])
    # Over the border goes what is there already: a bust ends at the picture's lower edge, wherever that lies.
    both = np.dstack([radiance, covered.astype(np.float32)])
    moved = cv2.warpAffine(both, matrix, (size, size), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    left, right = sorted((shift_x, shift_x + scale * mirror * (size - 1)))
    moved[:, : max(0, int(np.ceil(left)))] = 0
    moved[:, int(max(right, -1)) + 1 :] = 0
    moved[: max(0, int(np.ceil(shift_y)))] = 0
    if rng.random() < 0.7:
        moved = cv2.GaussianBlur(moved, (0, 0), size * 10 ** rng.uniform(-2.5, -1.3))
    gain = np.float32(2 ** rng.normal(0, 0.6))
    return Neighbour(moved[..., :3] * gain, moved[..., 3:])


def with_local_light(radiance: np.ndarray, other: np.ndarray, local: LocalLight) -> np.ndarray:
    """Radiance (S, S, 3) under one light, and under another as far as that reaches."""
    return radiance + other * local.reach * local.colour


def behind(background: np.ndarray, neighbour: Neighbour | None, gain: np.ndarray) -> np.ndarray:
    """A background (S, S, 3) as the camera exposed it, and somebody before it, times the camera's gain (3,)."""
    if neighbour is None:
        return background
    return background * (1 - neighbour.coverage) + neighbour.radiance * gain
