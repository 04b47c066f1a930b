"""Shih et al. 2014, Style transfer for headshot portraits: local statistics of an example, scale by scale.

Both portraits are split into bands of growing scale; each band of the photo is scaled by the root of the
ratio of the local energies, clamped so that noise does not grow; the coarsest residual is the example's.
Their dense correspondence is left out: the example given here is the same head in the same pose.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import cv2
import numpy as np

from relight_core.evaluation.contest import Contender, Task
from relight_core.evaluation.peers.blurring import blurred_within
from relight_core.imaging.colour import srgb_decode, srgb_encode

_LEAST_ENERGY = 0.01**2
_LEAST_GAIN, _MOST_GAIN = 0.9, 2.8
_COARSEST_SHARE = 0.06
"""Standard deviation of the coarsest blur over the picture's side: six octaves on their portraits of 1,000
pixels."""


def transfer_statistics(photo_srgb: np.ndarray, example_srgb: np.ndarray, covered: np.ndarray) -> np.ndarray:
    """The photo with the example's local statistics.

    Args:
        photo_srgb, example_srgb: (S, S, 3) sRGB-encoded, [0, 1], in correspondence.
        covered: (S, S) bool, the head; nothing outside it counts.

    Returns:
        (S, S, 3) sRGB-encoded, [0, 1].
    """
    weight = covered.astype(np.float32)
    levels = max(round(math.log2(_COARSEST_SHARE * len(covered))), 1)
    photo, example = (_lab(image) for image in (photo_srgb, example_srgb))
    photo_bands, _ = _bands(photo, weight, levels)
    example_bands, residual = _bands(example, weight, levels)
    changed = residual
    for level, (band, wanted) in enumerate(zip(photo_bands, example_bands, strict=True)):
        energies = (blurred_within(part**2, weight, 2.0 ** (level + 1)) for part in (wanted, band))
        energy_wanted, energy = energies
        gain = np.sqrt(energy_wanted / (energy + _LEAST_ENERGY)).clip(_LEAST_GAIN, _MOST_GAIN)
        changed = changed + band * blurred_within(gain, weight, 3 * 2.0**level)
    scaled = (changed * 100).astype(np.float32)
    return np.clip(cv2.cvtColor(scaled, cv2.COLOR_Lab2RGB), 0, 1) * weight[..., None]


def _lab(image_srgb: np.ndarray) -> np.ndarray:
    return cv2.cvtColor(image_srgb.astype(np.float32), cv2.COLOR_RGB2Lab) / 100


def _bands(image: np.ndarray, weight: np.ndarray, levels: int) -> tuple[list[np.ndarray], np.ndarray]:
    """Differences of growing blurs, none of them smaller than the image, and what is left."""
    bands, finer = [], image
    for level in range(levels):
        coarser = blurred_within(image, weight, 2.0 ** (level + 1))
        bands.append(finer - coarser)
        finer = coarser
    return bands, finer


class Shih(Contender):
    """With the truth for an example, as a contender."""

    def relight(self, seen: np.ndarray, task: Task) -> Mapping[str, np.ndarray]:
        shown = transfer_statistics(srgb_encode(seen), srgb_encode(task.reference), task.covered)
        return {"composition": srgb_decode(shown) / np.float32(task.gain)}
