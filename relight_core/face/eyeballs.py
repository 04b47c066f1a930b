"""Eyes bulge: the normals of an eye are those of a ball, whatever a network made of its few pixels.

Networks see an eye in some ten pixels and take the dark socket for a hollow. Its normals turn away from the
cheekbone, and a lamp exactly from the side leaves a black patch. In fact such light reaches the eye, since the
eyeball protrudes beyond the outer rim of its socket (by 16 to 20 mm in adults: Hertel's exophthalmometry). An open eye
shows about 30 mm of a ball of 12 mm radius, lids included.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.face.parsing import EYES, INDEX
from relight_core.imaging.masks import bounds, largest_part

_RADIUS_IN_HALF_WIDTHS = 1.4
"""The ball's radius in half-widths of the eye in the parsing."""
_STEEPEST = 0.85
"""The largest sine of the angle between the ball's normals and the camera's axis."""
_FEWEST_PIXELS = 4
"""An eye has at least so many pixels."""
_LID_REACH = 0.35
"""Standard deviation of the blur by which the ball fades out over the lids, in half-widths of the eye."""
_BLUR_DEVIATIONS = 4
"""Radius of OpenCV's Gaussian kernels for floats, in standard deviations."""
_SOCKET_REACH = 0.3
"""Standard deviation of the blur that widens eyes to sockets, in diameters of a disc of both eyes' area."""


@dataclass(frozen=True)
class EyePlace:
    """An eye in a view: its probability (S, S), the column and row of its centre, and half its width in pixels."""

    share: np.ndarray
    middle_x: float
    middle_y: float
    half_width: float


def with_eyeballs(normal: np.ndarray, parsing: np.ndarray) -> np.ndarray:
    """Replace the normals of each eye by those of a ball, which fades out over the lids.

    A ball faces halfway between the mean normal of its eye and that of both eyes. So eyes follow a turned head, and
    the errors of two hollows, whose normals turn toward each other, cancel out.

    Args:
        normal: (3, S, S) unit vectors, camera space.
        parsing: (classes, S, S) probabilities.

    Returns:
        (3, S, S) float32 unit vectors; the normals themselves if no eye has enough pixels.
    """
    found = (eye_place(parsing[INDEX[name]]) for name in EYES)
    eyes = [eye for eye in found if eye is not None]
    if not eyes:
        return normal
    facing = [_unit((normal * eye.share).sum((1, 2))) for eye in eyes]
    together = _unit(np.sum(facing, axis=0))
    for eye, alone in zip(eyes, facing, strict=True):
        normal = _with_ball(normal, eye, _unit(together + alone))
    return normal.astype(np.float32)


def eye_sockets(parsing: np.ndarray) -> np.ndarray:
    """The share of each pixel that lies in an eye socket, (S, S) float32 in [0, 1], from a parsing (classes, S, S)."""
    eyes = parsing[[INDEX[name] for name in EYES]].sum(0).astype(np.float32)
    across = 2 * np.sqrt(max(float((eyes > 0.5).sum()), 1.0) / np.pi)
    return np.clip(2.5 * cv2.GaussianBlur(eyes, (0, 0), max(_SOCKET_REACH * across, 0.5)), 0, 1)


def eye_place(share: np.ndarray) -> EyePlace | None:
    """The largest connected part of an eye's probability (S, S); None if it has too few pixels."""
    largest = largest_part(share > 0.5, _FEWEST_PIXELS)
    if largest is None:
        return None
    share = (share * cv2.dilate(largest, np.ones((3, 3), np.uint8))).astype(np.float32)
    total, place = float(share.sum()), np.arange(len(share), dtype=np.float32)
    across, down = share.sum(0) / total, share.sum(1) / total
    middle_x, middle_y = float(across @ place), float(down @ place)
    # The half-width of a filled ellipse is twice the standard deviation of its pixels.
    half_width = max(2 * np.sqrt(float(across @ (place - middle_x) ** 2)), 1.0)
    return EyePlace(share, middle_x, middle_y, half_width)


def _with_ball(normal: np.ndarray, eye: EyePlace, facing: np.ndarray) -> np.ndarray:
    """Normals (3, S, S) with a ball over one eye, which faces a direction (3,)."""
    lid_px, radius = max(_LID_REACH * eye.half_width, 0.5), _RADIUS_IN_HALF_WIDTHS * eye.half_width
    rows, columns = _around(eye.share, lid_px)
    share, bare = eye.share[rows, columns], normal[:, rows, columns]
    place = np.arange(len(eye.share), dtype=np.float32)
    x = np.broadcast_to((place[columns] - eye.middle_x)[None] / radius + facing[0], share.shape)
    y = np.broadcast_to((eye.middle_y - place[rows])[:, None] / radius + facing[1], share.shape)
    shrunk = np.minimum(1, _STEEPEST / np.maximum(np.hypot(x, y), 1e-6))
    x, y = x * shrunk, y * shrunk
    ball = np.stack([x, y, np.sqrt(1 - x * x - y * y)])
    lids = cv2.GaussianBlur(share, (0, 0), lid_px)
    changed = normal.copy()
    changed[:, rows, columns] = _unit(bare + (ball - bare) * np.clip(share + lids, 0, 1))
    return changed


def _around(share: np.ndarray, lid_px: float) -> tuple[slice, slice]:
    """Rows and columns of an eye and its lids."""
    reach = int(np.ceil(_BLUR_DEVIATIONS * lid_px)) + 1
    return tuple(slice(max(seen.start - reach, 0), seen.stop + reach) for seen in bounds(share))


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=0, keepdims=True), 1e-6)
