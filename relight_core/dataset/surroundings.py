"""What portraits contain beside the head that no target has: a light on a part of the head, other people."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.dataset.painting.texture import TexturePool


@dataclass(frozen=True)
class LocalLight:
    """A second light on a part of a head: a spot, or sun through a window or leaves.

    Attributes:
        reach: (S, S, 1) in [0, 1], the part of the light that reaches each pixel.
        colour: (3,) factors on the light's radiance.
    """

    reach: np.ndarray
    colour: np.ndarray


@dataclass(frozen=True)
class Neighbour:
    """Another person in the picture.

    Attributes:
        radiance: (S, S, 3) linear, premultiplied by the coverage.
        coverage: (S, S, 1) in [0, 1], how much of each pixel is that person.
    """

    radiance: np.ndarray
    coverage: np.ndarray


def sample_local_light(size: int, pool: TexturePool, rng: np.random.Generator) -> LocalLight:
    """A random half-plane, disc or dapples with soft edges, strongly coloured half of the time."""
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
    """Another lit head beside and behind the one in front, mostly out of focus.

    Its clothes and hair are drawn like those in front, so that a network can tell only from its place that it is not
    the subject.

    Args:
        radiance: (S, S, 3) linear, 0 outside the head.
        covered: (S, S) bool, the head.
    """
    size = len(covered)
    scale = rng.uniform(0.6, 1.2)
    aside = rng.choice([-1, 1]) * rng.uniform(0.45, 0.85) * size
    mirror = rng.choice([-1, 1])
    middle = (size - 1) / 2
    shift_x = middle + aside - scale * mirror * middle
    shift_y = middle + rng.normal(0, 0.15) * size - scale * middle
    matrix = np.array([[scale * mirror, 0, shift_x], [0, scale, shift_y]])
    # The border is repeated, so that a bust that ends at the picture's lower edge goes on below it; what that repeats
    # at the other edges is cleared.
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
    """A head's radiance with that of a second light on a part of it, (S, S, 3) linear.

    Args:
        radiance, other: the head under the first light, and under the second one alone.
    """
    return radiance + other * local.reach * local.colour


def with_neighbour(background: np.ndarray, neighbour: Neighbour | None, gain: np.ndarray) -> np.ndarray:
    """A neighbour in front of a background, (S, S, 3) linear.

    Args:
        background: (S, S, 3) linear, already exposed.
        gain: (3,) the camera's, by which the neighbour's radiance is exposed.
    """
    if neighbour is None:
        return background
    return background * (1 - neighbour.coverage) + neighbour.radiance * gain
