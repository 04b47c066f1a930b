"""Things between a head and its light: a microphone, a hand, a branch, out of frame or in it.

Shadows of objects that are no part of the head are the paper's stated failure (section 5.4). Here they
darken the photo that de-lighting learns from and no target, so that it learns to take them for light, not
for albedo. They are as soft as the light that heads are baked for; `lighting.gobos` has sharp ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from relight_core.dataset.baking.bake import LIGHT_HEIGHT, LIGHT_WIDTH, BakedHead
from relight_core.lighting.sphere import directions

_SPREAD = 0.08
"""Half the angle of a texel of the light, about: edges soften by this much per unit of distance."""


@dataclass(frozen=True)
class Occluder:
    """A chain of balls that keeps light from a head.

    Attributes:
        centres: (N, 3) in half-widths of the crop: x right, y up, z toward the camera, 0 at the face.
        radii: (N,) in half-widths of the crop.
    """

    centres: np.ndarray
    radii: np.ndarray


def sample_occluder(rng: np.random.Generator) -> Occluder:
    """A bar, a ball or scattered leaves, somewhere in front of the face; three of four show in the picture."""
    toward = rng.standard_normal(3) * [1, 0.8, 0.4] + [0, 0.2, 0.7]
    toward /= np.linalg.norm(toward)
    middle = toward * rng.uniform(0.5, 2.5)
    chance = rng.random()
    if chance < 0.45:
        along = rng.standard_normal(3)
        along /= np.linalg.norm(along)
        radius = rng.uniform(0.06, 0.25)
        centres = middle + np.linspace(-1, 1, 6)[:, None] * along * radius * 4
        return Occluder(centres.astype(np.float32), np.full(6, radius, np.float32))
    if chance < 0.7:
        return Occluder(middle[None].astype(np.float32), np.array([rng.uniform(0.1, 0.5)], np.float32))
    centres = middle + rng.standard_normal((6, 3)) * rng.uniform(0.2, 0.7)
    return Occluder(centres.astype(np.float32), rng.uniform(0.05, 0.25, 6).astype(np.float32))


def positions(head: BakedHead) -> np.ndarray:
    """Points (P, 3) of a head's pixels in the occluder's units; the camera is far, its perspective left out."""
    axis = ((np.arange(head.size) + 0.5) / head.size * 2 - 1).astype(np.float32)
    x, y = np.meshgrid(axis, -axis)
    return np.stack([x[head.covered], y[head.covered], head.depth], 1)


def transmission(occluder: Occluder, points: np.ndarray) -> torch.Tensor:
    """How much of each texel of the light gets past the occluder to each point: (512, P) in [0, 1].

    Quickest for a thousand points at a time, whose numbers stay in the processor's cache.
    """
    toward = torch.from_numpy(directions(LIGHT_HEIGHT, LIGHT_WIDTH).reshape(-1, 3))
    points = torch.from_numpy(points)
    along_points = toward @ points.T
    free = torch.ones_like(along_points)
    for centre, radius in zip(torch.from_numpy(occluder.centres), occluder.radii.tolist(), strict=True):
        ahead = (toward @ centre)[:, None] - along_points
        facing = (ahead.amax(1) > 0).nonzero()[:, 0]
        ahead = ahead[facing]
        away = (points - centre).square().sum(1)[None]
        distance = torch.addcmul(away, ahead, ahead, value=-1).clamp_min_(0).sqrt_()
        softness = (2 * _SPREAD * ahead).clamp_min_(0.01)
        passed = distance.sub_(radius).div_(softness).add_(0.5).clamp_(0, 1)
        free[facing] *= passed.masked_fill_(ahead <= 0, 1.0)
    return free


def silhouette(occluder: Occluder, head: BakedHead) -> np.ndarray:
    """Pixels (S, S) bool at which the occluder itself stands before the head or its background."""
    axis = (np.arange(head.size) + 0.5) / head.size * 2 - 1
    x, y = np.meshgrid(axis, -axis)
    depth = head.scatter(head.depth, -np.inf)
    hidden = np.zeros(head.covered.shape, bool)
    for (cx, cy, cz), radius in zip(occluder.centres, occluder.radii, strict=True):
        hidden |= ((x - cx) ** 2 + (y - cy) ** 2 < radius**2) & (cz > depth)
    return hidden
