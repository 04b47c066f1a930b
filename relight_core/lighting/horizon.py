"""Horizons of a relief in single directions, for the sharp shadows of small lamps (horizon mapping: Max 1988).

`lighting.relief` covers whole panoramas at once, at low resolution. A small lamp needs the horizon in only a few
directions of the image plane; each is marched when it is first needed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import cv2
import numpy as np

from relight_core.lighting.relief import BIAS, NOTHING, REACH

_AZIMUTHS = 96
"""Directions of the image plane, evenly spaced, whose horizons are marched; others are interpolated."""
_LEAST_ASIDE = 0.05
"""Near the camera's axis a disc would cover all azimuths: its distance from that axis counts as no less."""
_HALF_STRIP = 0.2
_STRIPS = (-0.8, -0.4, 0.0, 0.4, 0.8)
"""Centres of upright strips that a lamp's disc is cut into, in radii, each 0.2 to both sides. An upright edge, such as
a jaw beside the neck, hides them one by one; taken as a whole the disc would vanish at once."""


@dataclass(eq=False)
class Horizon:
    """Which small lamps each point of a height field can see.

    Attributes:
        relief: (S, S) float32 height toward the camera, in half-widths of the image.
        covered: (S, S) bool, where there is a surface; elsewhere nothing casts a shadow.
    """

    relief: np.ndarray
    covered: np.ndarray
    _elevations: dict[int, np.ndarray] = field(default_factory=dict, init=False, repr=False)

    def visibility(
        self,
        toward: tuple[float, float, float],
        radius_deg: float,
        seen_at: Callable[[np.ndarray], np.ndarray] = np.asarray,
    ) -> np.ndarray:
        """The share of a lamp's disc that each point sees, (S, S) float32 in [0, 1].

        Args:
            toward: unit vector to the lamp, camera space.
            radius_deg: of the disc, positive.
            seen_at: resamples a map of horizons (S, S), for example to a finer lattice. The result has the shape that
                it returns.
        """
        x, y, z = toward
        aside = np.hypot(x, y)
        elevation = np.arctan2(z, aside)
        half_width = radius_deg / max(aside, _LEAST_ASIDE) / 360 * _AZIMUTHS
        azimuth = np.arctan2(y, x) / (2 * np.pi) * _AZIMUTHS
        right = seen_at(self._between(azimuth - half_width))
        seen, whole = np.zeros(right.shape, np.float32), 0.0
        for offset in _STRIPS:
            left, right = right, seen_at(self._between(azimuth + (offset + _HALF_STRIP) * half_width))
            height = 2 * np.radians(radius_deg) * np.sqrt(1 - offset * offset)
            above = elevation - (left + right) / 2
            seen += height * np.clip(above / (height + np.abs(left - right)) + 0.5, 0, 1)
            whole += height
        return seen / np.float32(whole)

    def _between(self, azimuth: float) -> np.ndarray:
        """(S, S) elevation of the horizon in radians, interpolated between marched azimuths (see `_elevation`)."""
        first = int(np.floor(azimuth))
        before, after = (self._elevation((first + step) % _AZIMUTHS) for step in (0, 1))
        return before + (after - before) * np.float32(azimuth - first)

    def _elevation(self, azimuth: int) -> np.ndarray:
        """(S, S) elevation of the horizon in radians, above the image plane, at one of the 96 azimuths.

        Azimuth 0 is +x, 24 is +y.
        """
        if azimuth not in self._elevations:
            self._elevations[azimuth] = np.arctan(self._steepest(2 * np.pi * azimuth / _AZIMUTHS))
        return self._elevations[azimuth]

    def _steepest(self, angle: float) -> np.ndarray:
        """(S, S) slope over the image plane up to which the sky is hidden in a direction, in radians from +x to +y."""
        right, down = np.cos(angle), -np.sin(angle)
        # Transposed and mirrored until the march goes to the right and down, and rather to the right.
        turned = abs(down) > abs(right)
        along, across = (down, right) if turned else (right, down)
        sides = slice(None, None, -1 if across < 0 else 1), slice(None, None, -1 if along < 0 else 1)
        height = np.where(self.covered, self.relief, np.float32(NOTHING))
        facing = [np.ascontiguousarray((plane.T if turned else plane)[sides]) for plane in (height, self.relief)]
        steepest = _march_right(*facing, abs(across / along))[sides]
        return steepest.T if turned else steepest


def _march_right(height: np.ndarray, relief: np.ndarray, down: float) -> np.ndarray:
    """Steepest slope from every point (S, S) of a relief to the heights (S, S) on its right.

    The ray is sampled where it crosses each column. With longer steps some rays would miss a brim, which is a pixel
    wide, and its shadow would be striped.

    Args:
        height: of what casts shadows, `NOTHING` beside the surface.
        relief: of the points that receive them.
        down: rows that the ray descends from one column to the next, in [0, 1].
    """
    size = len(height)
    steepest, from_here = np.full_like(height, NOTHING), relief + np.float32(BIAS)
    column = np.hypot(1, down) * 2 / size
    below = np.vstack([height[1:], np.full_like(height[:1], NOTHING)])
    for columns in range(1, min(math.ceil(REACH / column), size - 1) + 1):
        rows, between = divmod(columns * down, 1)
        there, here = np.s_[int(rows) :, columns:], np.s_[: size - int(rows), : size - columns]
        seen = cv2.addWeighted(height[there], 1 - between, below[there], between, 0)
        slope = cv2.subtract(seen, from_here[here]) * np.float32(1 / (columns * column))
        np.maximum(steepest[here], slope, out=steepest[here])
    return steepest
