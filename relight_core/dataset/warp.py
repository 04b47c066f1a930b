"""Random affine warps of samples in the image plane: rotation, scale, shift and a slight stretch.

A baked head has one pose in one crop, and a network that sees the same thousand heads for days overfits to them.
Rotation about the camera's axis, with the light, and scaling keep shading exact; a stretch of a few percent makes
another head, whose normals are off by a few degrees.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.dataset.samples import ON_THE_HEAD
from relight_core.lighting.environment import NETWORK_HEIGHT
from relight_core.lighting.roll import roll_light

_TURN_DEG, _WIDEST_TURN_DEG = 8.0, 25.0
_LEAST_COVERED = 0.5
_ZOOM, _STRETCH, _SHIFT = 0.1, 0.035, 0.04


@dataclass(frozen=True)
class Warp:
    """A change of the image plane.

    Attributes:
        turn_deg: counterclockwise.
        linear: (2, 2) matrix on positions relative to the image's centre, x to the right and y upward.
        shift: (2,) translation after that, in half-widths of the image.
    """

    turn_deg: float
    linear: np.ndarray
    shift: np.ndarray

    @property
    def scale(self) -> float:
        """Factor on lengths: the geometric mean over both axes."""
        return float(np.sqrt(np.linalg.det(self.linear)))


def sample_warp(rng: np.random.Generator) -> Warp:
    """A small random warp."""
    turn_deg = float(np.clip(rng.normal(0, _TURN_DEG), -_WIDEST_TURN_DEG, _WIDEST_TURN_DEG))
    angle = np.radians(turn_deg)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    stretch = np.clip(rng.normal(0, _STRETCH), -2 * _STRETCH, 2 * _STRETCH)
    zoom = np.exp(np.clip(rng.normal(0, _ZOOM), -2 * _ZOOM, 2 * _ZOOM))
    return Warp(turn_deg, turn @ np.diag([zoom * np.exp(stretch), zoom * np.exp(-stretch)]), rng.normal(0, _SHIFT, 2))


def warped(sample: dict[str, np.ndarray], warp: Warp) -> dict[str, np.ndarray]:
    """A sample of `dataset.samples` seen through a warp; its light, of any size, becomes (16, 32, 3).

    What comes into view from beyond the border repeats the border and counts as not covered. Channels of the head
    (`ON_THE_HEAD`) are un-premultiplied: divided by the head's coverage of each pixel, which counts as at least a half.
    "radiance" stays premultiplied by "silhouette".
    """
    size = sample["covered"].shape[0]
    changed = {name: _image(value, warp, size) for name, value in sample.items() if name not in ("light", "label")}
    changed["light"] = roll_light(sample["light"], -warp.turn_deg, NETWORK_HEIGHT)
    changed["label"] = _moved(sample["label"], warp, cv2.INTER_NEAREST, cv2.BORDER_REPLICATE)
    share = np.clip(_image(sample.get("silhouette", sample["covered"]), warp, size), _LEAST_COVERED, 1)
    for name in changed.keys() & set(ON_THE_HEAD):
        changed[name] = changed[name] / share.reshape(size, size, *(1,) * (changed[name].ndim - 2))
    inside = _moved(np.ones((size, size), np.float32), warp, cv2.INTER_LINEAR, cv2.BORDER_CONSTANT)
    changed["covered"] = ((changed["covered"] > _LEAST_COVERED) & (inside > 0.99)).astype(np.float32)
    changed["normal"] = _normals(changed["normal"], warp)
    changed["relief"] = changed["relief"] * np.float32(warp.scale)
    return changed


def _image(value: np.ndarray, warp: Warp, size: int) -> np.ndarray:
    return _moved(value, warp, cv2.INTER_LINEAR, cv2.BORDER_REPLICATE).reshape(size, size, *value.shape[2:])


def _normals(normal: np.ndarray, warp: Warp) -> np.ndarray:
    """Normals (S, S, 3) of the warped surface: slopes change by the inverse of the matrix without its scale.

    Heights are scaled as the image is, so that a similarity transform leaves slopes as they are, but for their
    direction.
    """
    across = normal[..., :2] @ (warp.scale * np.linalg.inv(warp.linear)).astype(np.float32)
    turned = np.concatenate([across, normal[..., 2:]], -1)
    return turned / np.maximum(np.linalg.norm(turned, axis=-1, keepdims=True), 1e-6)


def _moved(image: np.ndarray, warp: Warp, interpolation: int, border: int) -> np.ndarray:
    """An image seen through a warp; rows count downward, so the matrix's y is flipped on both sides."""
    size = image.shape[0]
    flip_y = np.diag([1.0, -1.0])
    linear, middle = flip_y @ warp.linear @ flip_y, np.full(2, (size - 1) / 2)
    offset = middle - linear @ middle + flip_y @ warp.shift * size / 2
    matrix = np.column_stack([linear, offset])
    return cv2.warpAffine(np.ascontiguousarray(image), matrix, (size, size), flags=interpolation, borderMode=border)
