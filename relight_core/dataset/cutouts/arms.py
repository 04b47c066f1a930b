"""An arm before a person: a hand at the cheek, a fist below the chin, a sleeve across the chest."""

from __future__ import annotations

import cv2
import numpy as np

from relight_core.dataset.cutouts.around_face import axes_in_faces, coverage, laid_over, white_beside
from relight_core.dataset.painting.skin import skin_tone
from relight_core.dataset.painting.texture import TexturePool

_SLEEVED_SHARE = 0.5
_FINGERS = 4


def with_arm(
    person: np.ndarray, centre: np.ndarray, face_px: float, pool: TexturePool, rng: np.random.Generator
) -> np.ndarray:
    """A person with an arm raised: from beside the trunk by the elbow to a hand near the face.

    Args:
        person: (S, S, 4) premultiplied.
        centre: (x, y) of the face's middle, in pixels.
        face_px: the longer side of the face's bounding box.
    """
    size, side = len(person), rng.choice([-1.0, 1.0])
    shoulder = np.array([side * rng.uniform(0.7, 1.1), rng.uniform(1.2, 2.2)])
    elbow = np.array([side * rng.uniform(0.4, 1.6), rng.uniform(1.2, 2.4)])
    hand = np.array([side * rng.uniform(-0.3, 0.8), rng.uniform(-0.4, 1.1)])
    wrist = hand + (elbow - hand) * 0.22 / max(np.linalg.norm(elbow - hand), 0.3)
    wide = rng.uniform(0.13, 0.2)
    flesh = [(wrist, hand, wide, 1.3 * wide), *_fingers(wrist, hand, wide, rng)]
    forearm, upper = (elbow, wrist, 1.3 * wide, 0.9 * wide), (shoulder, elbow, 1.6 * wide, 1.3 * wide)
    level = white_beside(person)
    skin = level * skin_tone(rng.random() ** 1.3, rng.uniform(0, 0.5))
    sleeve = level * rng.beta(0.8, 1.2, 3) if rng.random() < _SLEEVED_SHARE else skin
    light = rng.normal(0, 0.5, 2)
    for part, colour in ((upper, sleeve), (forearm, sleeve), *((f, skin) for f in flesh)):
        person = _with_limb(person, part, colour, light, centre, face_px)
    folds = cv2.resize(pool.noise(rng), (size, size))[..., None]
    return np.dstack([person[..., :3] * np.exp(0.08 * folds), person[..., 3]])


def _fingers(wrist: np.ndarray, hand: np.ndarray, wide: float, rng: np.random.Generator) -> list[tuple]:
    """Fingers that go on from the hand, straight or bent to one side, spread or not."""
    along = (hand - wrist) / max(np.linalg.norm(hand - wrist), 1e-3)
    across = np.array([-along[1], along[0]])
    bend, spread, length = rng.normal(0, 0.6), rng.uniform(0.3, 0.6), rng.uniform(0.15, 0.4)
    made = []
    for finger in range(_FINGERS):
        aside = (finger / (_FINGERS - 1) - 0.5) * 2
        root = hand + across * aside * 0.9 * wide
        toward = along + across * (bend + spread * aside)
        tip = root + toward / np.linalg.norm(toward) * length * (1 - 0.15 * abs(aside))
        made.append((root, tip, 0.3 * wide, 0.22 * wide))
    return made


def _with_limb(
    person: np.ndarray, limb: tuple, colour: np.ndarray, light: np.ndarray, centre: np.ndarray, face_px: float
) -> np.ndarray:
    """A round limb between two places, given in faces from the face's middle, shaded across."""
    start, end, first, last = limb
    x, y = axes_in_faces(len(person), centre, face_px)
    along = end - start
    length = max(float(along @ along), 1e-6)
    share = np.clip(((x - start[0]) * along[0] + (y - start[1]) * along[1]) / length, 0, 1)
    off_x, off_y = x - start[0] - share * along[0], y - start[1] - share * along[1]
    radius = first + (last - first) * share
    far = np.hypot(off_x, off_y) / radius
    round_off = np.sqrt(np.clip(1 - far * far, 0.05, 1))
    shade = np.clip(0.8 * round_off + (light[0] * off_x + light[1] * off_y) / radius, 0.15, 2.0)[..., None]
    return laid_over(person, coverage((1 - far) * radius, face_px), colour * shade)
