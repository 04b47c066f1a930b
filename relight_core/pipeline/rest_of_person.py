"""Shoulders, arms and hands beyond the networks' view: a coarse guess of what the light does to them.

A person's outline says roughly how the body bulges: surfaces turn away toward it. Light that falls on such
normals varies over the body as it does over a real one. What the networks did within their view corrects
the guess there, and the correction is continued outward, so that nothing changes abruptly at the view's edge.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import torch

from relight_core.imaging.colour import luminance
from relight_core.lighting.reflection import ReflectionTable

_LONGEST = 128
_DARK = 1e-3
_WELL_SEEN = 0.1
_FLOOR = 0.02
_LARGEST_GAIN = 16.0
_FILL = 0.15
_REACHES = (1.5, 4.0, 10.0, 25.0)


@dataclass(frozen=True, eq=False)
class Body:
    """What no light changes; maps over the whole photo, h and w at most 128.

    Attributes:
        photo: (h, w, 3) linear.
        share: (h, w) how much of each cell is person.
        known: (h, w) how much of it the networks' views cover, in [0, 1].
        normal: (1, 3, h, w) unit, camera space.
    """

    photo: np.ndarray
    share: np.ndarray
    known: np.ndarray
    normal: torch.Tensor


def body_size(photo_size: tuple[int, int]) -> tuple[int, int]:
    """Size of a body's maps for a photo."""
    scale = min(_LONGEST / max(photo_size), 1.0)
    return max(round(photo_size[0] * scale), 1), max(round(photo_size[1] * scale), 1)


def make_body(photo: np.ndarray, share: np.ndarray, known: np.ndarray) -> Body:
    """Guess a body from its outline.

    Args:
        photo: (h, w, 3) linear.
        share, known: as in `Body`.
    """
    return Body(photo, share, known, torch.from_numpy(_bulging(share)).permute(2, 0, 1)[None])


@torch.inference_mode()
def body_gain(body: Body, table: ReflectionTable, light: torch.Tensor, relit: np.ndarray) -> np.ndarray:
    """Gain of the photo over the whole photo, (h, w, 3), in units of the normalised light.

    Args:
        light: (1, 16, 32, 3), mean luminance 1.
        relit: (h, w, 3) linear, the photo as the networks relit it; only read where they saw it.
    """
    irradiance = table(light, body.normal)[0, :3].permute(1, 2, 0).cpu().numpy()
    guess = np.log(irradiance + _FILL * light.mean((0, 1, 2)).cpu().numpy() + _DARK)
    gain = np.log((relit + _DARK) / (body.photo + _DARK))
    trusted = np.clip(luminance(body.photo) / _WELL_SEEN, _FLOOR, 1.0)
    weight = body.known * np.maximum(body.share - 0.5, 0.0) * trusted
    correction = _continued(gain - guess, weight)
    return np.clip(np.exp(guess + correction), 0.0, _LARGEST_GAIN).astype(np.float32)


def _bulging(share: np.ndarray) -> np.ndarray:
    """Normals (h, w, 3) of a body that is as thick as it is wide: half an ellipse over every cross-section."""
    inside = (share > 0.5).astype(np.uint8)
    padded = cv2.copyMakeBorder(inside, 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    depth = np.minimum(cv2.distanceTransform(padded, cv2.DIST_L2, 5)[1:-1, 1:-1], max(share.shape) / 2)
    deepest = max(float(depth.max()), 1.0)
    height = np.sqrt(np.maximum(depth * (2 * deepest - depth), 0.0)).astype(np.float32)
    height = cv2.GaussianBlur(height, (0, 0), max(deepest / 4, 1.0))
    down, right = np.gradient(height) if min(height.shape) > 1 else (np.zeros_like(height),) * 2
    normal = np.stack([-right, down, np.ones_like(height)], axis=-1)
    return (normal / np.linalg.norm(normal, axis=-1, keepdims=True)).astype(np.float32)


def _continued(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Values where they are known, and means over ever wider surroundings where they are not."""
    total = float(weight.sum())
    if total < 1e-3:
        return np.zeros_like(values)
    result = np.broadcast_to((values * weight[..., None]).sum((0, 1)) / total, values.shape)
    weighted = np.ascontiguousarray(values * weight[..., None], np.float32)
    for reach in reversed(_REACHES):
        near = cv2.GaussianBlur(weight.astype(np.float32), (0, 0), reach)[..., None]
        mean = cv2.GaussianBlur(weighted, (0, 0), reach) / np.maximum(near, 1e-9)
        trust = np.clip(near / 0.02, 0.0, 1.0)
        result = result + (mean - result) * trust
    return result
