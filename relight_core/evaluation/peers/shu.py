"""Shu et al. 2017, Portrait lighting transfer using a mass transport approach.

Every pixel is a point of colour, position and normal. The photo's cloud of points is carried onto the
example's, which gives each pixel the colours that the example has at such places facing so; what changed is
then smoothed, for transport knows no neighbours. Theirs fits a face model for position and normal; here the
true ones are given, of the same head: its best case, as in the paper's Table 3.

The transport is the sliced one: along random axes, points are matched in order (Pitie et al. 2005).
"""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np

from relight_core.evaluation.contest import Contender, Task
from relight_core.evaluation.peers.blurring import blurred_within
from relight_core.imaging.colour import srgb_decode, srgb_encode

_COLOUR, _POSITION, _NORMAL = 1.0, 1.0, 1.0
"""Weights of the parts of a point, each brought to unit variance first."""

_ROUNDS = 24
_SMOOTHNESS = 0.012
"""Standard deviation of the smoothing over the picture's side."""


def transfer_by_transport(
    photo_srgb: np.ndarray,
    example_srgb: np.ndarray,
    normal: np.ndarray,
    relief: np.ndarray,
    covered: np.ndarray,
    seed: int = 0,
) -> np.ndarray:
    """The photo in the example's colours.

    Args:
        photo_srgb, example_srgb: (S, S, 3) sRGB-encoded, [0, 1].
        normal, relief: (S, S, 3) and (S, S), of both portraits.
        covered: (S, S) bool, the head; nothing outside it counts.
        seed: of the axes.

    Returns:
        (S, S, 3) sRGB-encoded, [0, 1].
    """
    geometry = _geometry(normal, relief, covered)
    photo, example = (_lab(image)[covered] for image in (photo_srgb, example_srgb))
    centre, spread = example.mean(0), np.maximum(example.std(0), 1e-3)
    clouds = [np.concatenate([_COLOUR * (cloud - centre) / spread, geometry], 1) for cloud in (photo, example)]
    moved = _sliced_transport(*clouds, np.random.default_rng(seed))
    change = np.zeros_like(photo_srgb, np.float32)
    change[covered] = moved[:, :3] / _COLOUR * spread + centre - photo
    smooth = blurred_within(change, covered.astype(np.float32), max(_SMOOTHNESS * len(covered), 0.5))
    lab = _lab(photo_srgb) + smooth
    return np.clip(cv2.cvtColor(lab.astype(np.float32), cv2.COLOR_Lab2RGB), 0, 1) * covered[..., None]


def _geometry(normal: np.ndarray, relief: np.ndarray, covered: np.ndarray) -> np.ndarray:
    size = len(covered)
    axis = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(axis, -axis)
    position = np.stack([x[covered], y[covered], relief[covered]], 1)
    position = (position - position.mean(0)) / np.maximum(position.std(0), 1e-3)
    facing = normal[covered]
    facing = (facing - facing.mean(0)) / np.maximum(facing.std(0), 1e-3)
    return np.concatenate([_POSITION * position, _NORMAL * facing], 1)


def _sliced_transport(points: np.ndarray, targets: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Points (N, D) moved until their projections on random axes are spread like the targets' (N, D)."""
    moved = points.astype(np.float64)
    for _ in range(_ROUNDS):
        axes, _ = np.linalg.qr(rng.standard_normal((points.shape[1],) * 2))
        ours, theirs = moved @ axes, np.sort(targets @ axes, axis=0)
        order = np.argsort(ours, axis=0, kind="stable")
        matched = np.empty_like(ours)
        np.put_along_axis(matched, order, theirs, axis=0)
        moved += (matched - ours) @ axes.T
    return moved


def _lab(image_srgb: np.ndarray) -> np.ndarray:
    return cv2.cvtColor(image_srgb.astype(np.float32), cv2.COLOR_RGB2Lab)


class Shu(Contender):
    """With the truth for an example and the true geometry, as a contender."""

    def relight(self, seen: np.ndarray, task: Task) -> Mapping[str, np.ndarray]:
        pictures = (srgb_encode(seen), srgb_encode(task.reference))
        shown = transfer_by_transport(*pictures, task.surface["normal"], task.surface["relief"], task.covered)
        return {"composition": srgb_decode(shown) / np.float32(task.gain)}
