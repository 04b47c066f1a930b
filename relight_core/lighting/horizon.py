"""Horizons of a relief, direction by direction, for shadows with edges (horizon mapping: Max 1988).

`lighting.relief` answers for whole panoramas at once and is coarse. A lamp is small, and asks for the horizon in a
few directions of the image plane only; they are marched when first asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import cv2
import numpy as np

from relight_core.lighting.relief import BIAS, NOTHING, march_distances

_AZIMUTHS = 96
_STEPS, _LONG_STEP_PX = 40, 2.0
"""Steps of the march over a relief, that grow with distance, and from where on they are longer than what is looked at.
A brim would be stepped over from one pixel and met from the next, and its shadow be striped."""
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
        along = np.array([np.cos(angle), -np.sin(angle)])
        height = np.where(self.covered, self.relief, np.float32(NOTHING))
        highest = cv2.max(height, cv2.max(_seen_from(height, along), _seen_from(height, -along)))
        steepest = np.full_like(height, NOTHING)
        half_width_px, before = len(height) / 2, 0.0
        for distance in march_distances(len(height), _STEPS):
            looked_at = highest if (distance - before) * half_width_px > _LONG_STEP_PX else height
            seen = _seen_from(looked_at, distance * half_width_px * along)
            np.maximum(steepest, (seen - self.relief - np.float32(BIAS)) / np.float32(distance), out=steepest)
            before = distance
        return steepest


def _seen_from(height: np.ndarray, shift_px: np.ndarray) -> np.ndarray:
    """What lies so far to the right and down of every pixel of heights (S, S), nothing beyond their border."""
    return cv2.warpAffine(
        height,
        np.float32([[1, 0, shift_px[0]], [0, 1, shift_px[1]]]),
        height.shape[::-1],
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=NOTHING,
    )
