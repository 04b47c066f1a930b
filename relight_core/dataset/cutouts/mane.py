"""Hair in a great mass around a head: curls that stand off it, or strands that hang beside it.

Baked hair is a shell near the skull. An outline network that knows no other takes an afro for a tree behind a head.
"""

from __future__ import annotations

import cv2
import numpy as np

from relight_core.dataset.cutouts.around_face import axes_in_faces, noise_over, white_beside
from relight_core.dataset.painting.skin import hair_colour
from relight_core.dataset.painting.texture import TexturePool

_BELOW_FACE_SHARE = 0.4
_CURLED_SHARE = 0.6
_ANGLES = 64


def with_mane(
    person: np.ndarray, centre: np.ndarray, face_px: float, pool: TexturePool, rng: np.random.Generator
) -> np.ndarray:
    """A person with a mane; before the shoulders at times, and before the face never.

    Args:
        person: (S, S, 4) premultiplied.
        centre: (x, y) of the face's middle, in pixels.
        face_px: the longer side of the face's bounding box.
    """
    x, y = np.broadcast_arrays(*axes_in_faces(len(person), centre, face_px))
    alpha = _outline(x, y, face_px, pool, rng)[..., None]
    hair = np.dstack([_strands(person, x, y, face_px, pool, rng), np.ones_like(x)]) * alpha
    front = _before_the_person(x, y, pool, rng)[..., None]
    behind = person + (1 - person[..., 3:]) * hair
    return behind + front * (hair + (1 - alpha) * person - behind)


def _before_the_person(x: np.ndarray, y: np.ndarray, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Where hair lies before the person, (S, S) in [0, 1]: not on the face, and below the chin not always."""
    wide, tall = rng.uniform(0.36, 0.5), rng.uniform(0.5, 0.6)
    off_face = _rise(np.hypot(x / wide, y / tall) + 0.08 * noise_over(pool, len(x), rng), 1.0, 0.08)
    if rng.random() < _BELOW_FACE_SHARE:
        return off_face
    return off_face * (1 - _rise(y, rng.uniform(0.2, 0.5), 0.2))


def _outline(x: np.ndarray, y: np.ndarray, face_px: float, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """The mane's coverage (S, S): a ragged round around the skull, its lower end cut off where it likes to end."""
    reach = 0.65 + rng.uniform(0, 0.9) ** 1.5
    knots = rng.normal(0, 0.12, 9)
    angles = np.linspace(-np.pi, np.pi, _ANGLES)
    wobble = np.interp(angles, np.linspace(-np.pi, np.pi, 10), np.append(knots, knots[0]))
    around = np.arctan2(x, -(y + 0.2))
    radius = reach * rng.uniform(0.8, 1.1) * np.exp(np.interp(around, angles, wobble)).astype(np.float32)
    far = np.hypot(x * rng.uniform(0.85, 1.15), y + 0.2) / radius
    ragged = rng.uniform(0.02, 0.12) * noise_over(pool, len(x), rng, 3) + rng.uniform(0, 0.1) * noise_over(
        pool, len(x), rng, 8
    )
    inside = 1 - _rise(far + ragged, 1.0, rng.uniform(0.5, 3.0) / (reach * face_px) + rng.uniform(0, 0.12))
    return inside * (1 - _rise(y + ragged, rng.uniform(0.3, 1.6), 0.1))


def _strands(
    person: np.ndarray, x: np.ndarray, y: np.ndarray, face_px: float, pool: TexturePool, rng: np.random.Generator
) -> np.ndarray:
    """The hair's radiance (S, S, 3): curls or strands, brighter on the side of the light, as bright as the person."""
    size = len(x)
    curl = max(face_px * 10 ** rng.uniform(-1.9, -1.2), 0.7)
    grain = rng.standard_normal((size, size)).astype(np.float32)
    if rng.random() < _CURLED_SHARE:
        grain = cv2.GaussianBlur(grain, (0, 0), curl)
    else:
        grain = cv2.GaussianBlur(grain, (0, 0), sigmaX=max(0.2 * curl, 0.5), sigmaY=5 * curl)
    fine = np.abs(grain / max(float(grain.std()), 1e-6)) - 0.8
    toward = rng.normal(0, 0.35, 2)
    shade = rng.uniform(0.2, 0.6) * fine + 0.3 * noise_over(pool, size, rng) + toward[0] * x + toward[1] * y
    return (white_beside(person) * hair_colour(rng) * np.exp(np.clip(shade, -2, 1.5))[..., None]).astype(np.float32)


def _rise(value: np.ndarray, middle: float, width: float) -> np.ndarray:
    """From 0 to 1 within a width around a value."""
    return np.clip((value - middle) / width + 0.5, 0, 1).astype(np.float32)
