"""Horizons of a relief, direction by direction, for shadows with edges (horizon mapping: Max 1988).

`lighting.relief` answers for whole panoramas at once and is coarse. A lamp is small, and asks for the horizon in a
few directions of the image plane only; they are marched when first asked for.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import cv2
import numpy as np

from relight_core.lighting.relief import BIAS, NOTHING, REACH

_AZIMUTHS = 96
_LEAST_ASIDE = 0.05
_HALF_STRIP = 0.2
_STRIPS = (-0.8, -0.4, 0.0, 0.4, 0.8)
"""Middles of upright strips of a lamp's disc, in its radius: what stands beside a point hides them one by one."""


@dataclass(eq=False)
class Horizon:
    """What a height field hides from small lamps.

    Attributes:
        relief: (S, S) float32 height toward the camera, in half-widths of the image.
        covered: (S, S) bool: where there is a surface; elsewhere nothing casts a shadow.
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
        """How much of a lamp's disc each point sees, (S, S) float32 in [0, 1].

        Args:
            toward: unit vector to the lamp, camera space.
            radius_deg: of the disc, positive.
            seen_at: what to ask of the horizons (S, S): all, or those of other points between them. The result is of
                the shape that it gives.
        """
        x, y, z = toward
        aside = np.hypot(x, y)
        elevation = np.arctan2(z, aside)
        reach = radius_deg / max(aside, _LEAST_ASIDE) / 360 * _AZIMUTHS
        turn = np.arctan2(y, x) / (2 * np.pi) * _AZIMUTHS
        right = seen_at(self._between(turn - reach))
        seen, whole = np.zeros(right.shape, np.float32), 0.0
        for offset in _STRIPS:
            left, right = right, seen_at(self._between(turn + (offset + _HALF_STRIP) * reach))
            height = 2 * np.radians(radius_deg) * np.sqrt(1 - offset * offset)
            above = elevation - (left + right) / 2
            seen += height * np.clip(above / (height + np.abs(left - right)) + 0.5, 0, 1)
            whole += height
        return seen / np.float32(whole)

    def _between(self, turn: float) -> np.ndarray:
        """(S, S) radians of the horizon in any direction, `turn` counting azimuths."""
        first = int(np.floor(turn))
        before, after = (self._elevation((first + step) % _AZIMUTHS) for step in (0, 1))
        return before + (after - before) * np.float32(turn - first)

    def _elevation(self, azimuth: int) -> np.ndarray:
        """(S, S) radians of the horizon in a direction of the image plane; azimuth 0 is +x, a quarter of them +y."""
        if azimuth not in self._elevations:
            self._elevations[azimuth] = np.arctan(self._steepest(2 * np.pi * azimuth / _AZIMUTHS))
        return self._elevations[azimuth]

    def _steepest(self, angle: float) -> np.ndarray:
        """(S, S) slope over the image plane up to which the sky is hidden in a direction."""
        right, down = np.cos(angle), -np.sin(angle)
        turned = abs(down) > abs(right)
        along, across = (down, right) if turned else (right, down)
        sides = slice(None, None, -1 if across < 0 else 1), slice(None, None, -1 if along < 0 else 1)
        height = np.where(self.covered, self.relief, np.float32(NOTHING))
        facing = [np.ascontiguousarray((plane.T if turned else plane)[sides]) for plane in (height, self.relief)]
        steepest = _march_right(*facing, abs(across / along))[sides]
        return steepest.T if turned else steepest


def _march_right(height: np.ndarray, relief: np.ndarray, down: float) -> np.ndarray:
    """Steepest slope from every point (S, S) of a relief to the heights (S, S) on its right.

    Every column is looked at where the ray crosses it: a brim is a pixel wide, and its shadow would be striped if some
    rays stepped over it.

    Args:
        down: rows that the ray goes down from a column to the next, in [0, 1].
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
