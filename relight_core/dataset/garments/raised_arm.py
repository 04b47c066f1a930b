"""An arm raised to a head, as meshes: a hand at the cheek, a fist below the chin, fingers at the temple.

Hands are bones with flesh of a given thickness around them, melted into one surface.
"""

from __future__ import annotations

import numpy as np

from relight_core.dataset.garments.field_mesh import enclosed, grid_between, uv_in_place
from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_binding import HeadSurface
from relight_core.dataset.garments.garment_mesh import fractal, vertex_normals

_PLACES_CM = {
    "cheek": (6.0, -3.0, 7.0),
    "chin": (2.0, -9.5, 8.0),
    "temple": (7.0, 4.0, 5.0),
    "forehead": (2.5, 8.0, 9.0),
    "ear": (9.0, 3.0, 0.0),
    "mouth": (1.0, -5.0, 10.0),
    "crown": (4.0, 14.0, 2.0),
    "neck": (5.0, -12.0, 5.0),
}
"""Where hands like to be, of somebody's right side in the picture."""

_SHOULDER_CM = np.array([17.0, -24.0, -2.0])
_SLEEVED_SHARE, _FIST_SHARE, _BEHIND_HEAD_SHARE = 0.55, 0.25, 0.4
_PHALANGES_CM = np.array([4.3, 2.6, 2.2])
_FINGER_LENGTHS = (0.95, 1.05, 1.0, 0.8)
_KNUCKLES_CM = (2.9, 1.0, -1.0, -2.8)
_FINE_CM, _COARSE_CM = 0.3, 0.6
_PALM_CM = 1.6
_UNDER_SCALP = 0.3
"""Below this much of the skin's texture nobody is shaved (see `skin.paint`)."""

Bone = tuple[np.ndarray, np.ndarray, float, float]
"""From where to where, and how thick at both ends, in centimetres."""


def raise_arm(skin: HeadSurface, rng: np.random.Generator) -> list[Garment]:
    """A hand laid on a head whose surface is `skin`, or held before it, and the arm it belongs to."""
    side = rng.choice([-1.0, 1.0])
    place = str(rng.choice(list(_PLACES_CM)))
    wanted = np.array(_PLACES_CM[place]) * [side, 1, 1] + rng.normal(0, 1.2, 3)
    touched = skin.points[((skin.points - wanted) ** 2).sum(1).argmin()]
    outward = _unit(skin.height(touched[None])[1][0] + _unit(wanted * [1, 0.5, 1]))
    palm = touched + outward * (_PALM_CM + rng.uniform(-0.3, 2.5))
    elbow = _elbow(place, side, rng)
    along = _unit(palm - elbow) + rng.normal(0, 0.35, 3)
    along = _unit(along - (along @ outward) * outward)
    size = rng.uniform(0.88, 1.08)
    hand = _hand(rng, fist=rng.random() < _FIST_SHARE)
    across = np.cross(along, outward)
    # A thumb points up or toward the head's middle more often than away from it.
    axes = np.stack([across * np.sign(across[1] + 1e-6), along, outward]) * size
    flesh = [(start @ axes + palm, end @ axes + palm, size * a, size * b) for start, end, a, b in hand]
    wrist = palm - along * 4.5 * size
    forearm = (wrist, elbow, 2.5 * size, 3.9 * size)
    upper = (elbow, _SHOULDER_CM * [side, 1, 1] + rng.normal(0, 1.5, 3), 4.1 * size, 5.0 * size)
    return [_skin(flesh, _FINE_CM), *_sleeve_or_skin(forearm, upper, rng)]


def _elbow(place: str, side: float, rng: np.random.Generator) -> np.ndarray:
    """Below and before the shoulder; beside the head where the hand is high up, at times."""
    if place in ("crown", "ear", "temple", "forehead") and rng.random() < _BEHIND_HEAD_SHARE:
        return np.array([side * rng.uniform(20, 32), rng.uniform(-10, 12), rng.uniform(-6, 14)])
    return np.array([side * rng.uniform(6, 22), rng.uniform(-38, -20), rng.uniform(4, 22)])


def _hand(rng: np.random.Generator, *, fist: bool) -> list[Bone]:
    """Bones about the palm's middle: x toward the thumb, y along the fingers, z out of the back of the hand."""
    bent_deg = rng.uniform(60, 85) if fist else rng.uniform(2, 35)
    spread = 0.02 if fist else rng.uniform(0.0, 0.09)
    bones: list[Bone] = []
    for number, (x, length) in enumerate(zip(_KNUCKLES_CM, _FINGER_LENGTHS, strict=True)):
        root = np.array([x, 4.0 - 0.25 * (number - 1.2) ** 2, 0.3])
        bones.append((np.array([0.6 * x, -4.3, 0.0]), root, 1.25, 1.05))
        own_bend_deg = bent_deg + rng.normal(0, 7)
        bones += _finger(root, np.array([spread * x, 1.0, 0.0]), length * _PHALANGES_CM, own_bend_deg, 0.85)
    toward = np.array([0.75, 0.6, -0.35]) + rng.normal(0, 0.15, 3)
    bones += _finger(np.array([2.0, -2.6, -0.2]), toward, np.array([3.8, 3.0, 2.3]), rng.uniform(5, 30), 1.15)
    return bones


def _finger(root: np.ndarray, toward: np.ndarray, lengths_cm: np.ndarray, bent_deg: float, thick_cm: float) -> list:
    """Three bones, each bent toward the palm from the one before, and at most straight down from it.

    A fist's fingers do not curl back, then: they end in the head that the fist lies on, where nobody sees them.
    """
    bones, toward = [], _unit(toward)
    for number, length in enumerate(lengths_cm):
        angle = np.radians(bent_deg * (0.8 if number == 0 else 1.0))
        toward = _unit(np.cos(angle) * toward + np.sin(angle) * np.array([0, 0, -1.0]) * np.hypot(*toward[:2]))
        tip = root + length * toward
        bones.append((root, tip, thick_cm * (1 - 0.1 * number), thick_cm * (0.9 - 0.1 * number)))
        root = tip
    return bones


def _sleeve_or_skin(forearm: Bone, upper: Bone, rng: np.random.Generator) -> list[Garment]:
    """Arm and sleeve; a sleeve ends near the wrist, or above the elbow."""
    start, end, thin, thick = forearm
    cut = rng.uniform(0.02, 0.3)
    bare = (start, start + (cut + 0.1) * (end - start), thin, thin + (cut + 0.1) * (thick - thin))
    if rng.random() < _SLEEVED_SHARE:
        loose = rng.uniform(0.3, 1.2)
        covered = (start + cut * (end - start), end, thin + loose, thick + loose)
        above = (upper[0], upper[1], upper[2] + loose, upper[3] + loose)
        return [_skin([bare], _COARSE_CM), _cloth([covered, above], rng)]
    return [_skin([forearm, upper], _COARSE_CM)]


def _skin(bones: list[Bone], step_cm: float) -> Garment:
    vertices, faces, uv = _melted(bones, step_cm)
    return Garment(vertices, faces, uv * np.float32([1, _UNDER_SCALP]), "neck", name="arm")


def _cloth(bones: list[Bone], rng: np.random.Generator) -> Garment:
    vertices, faces, _ = _melted(bones, _COARSE_CM)
    folds = fractal(vertices, rng, rng.uniform(3, 8), 3) * rng.uniform(0.1, 0.4)
    vertices = (vertices + vertex_normals(vertices, faces) * folds[:, None]).astype(np.float32)
    return Garment(vertices, faces, uv_in_place(vertices), "cloth", name="sleeve")


def _melted(bones: list[Bone], step_cm: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The surface around bones, drawn together where they meet as flesh is: `field_mesh.enclosed`."""
    ends = np.concatenate([[start, end] for start, end, _, _ in bones])
    reach = max(max(a, b) for *_, a, b in bones) + 3 * step_cm
    low, high = ends.min(0) - reach, ends.max(0) + reach
    grid = grid_between(low, high, step_cm)
    nearness = sum(np.exp(-_distance(grid, bone) / (0.6 * step_cm)) for bone in bones)
    return enclosed(np.log(np.maximum(nearness, 1e-30)), low, step_cm)


def _distance(grid: np.ndarray, bone: Bone) -> np.ndarray:
    """How far points (..., 3) are from the flesh of a bone; below 0 within it."""
    start, end, first, last = bone
    along = (end - start).astype(np.float32)
    share = np.clip((grid - start.astype(np.float32)) @ along / max(float(along @ along), 1e-6), 0, 1)
    off = grid - start.astype(np.float32) - share[..., None] * along
    return np.sqrt(np.einsum("...c,...c->...", off, off)) - (first + (last - first) * share)


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / max(float(np.linalg.norm(vector)), 1e-9)
