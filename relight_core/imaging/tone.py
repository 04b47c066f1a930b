"""The tone of a toned picture: the colour that it has at each brightness.

Sepia leaves white paper white. Where another light dims what was white, it is of the tone that the picture has there,
as it would be had the print been toned after it was lit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from relight_core.imaging.colour import luminance

_STEPS = 1024
_LEVELS = 64
_FEWEST = 1e-4
"""Of all pixels: fewer say nothing of their level."""
_GREY = 2e-3
"""What is as near to grey has no tone."""
_DARK = 1e-6
_FAINT = 0.02
"""Of a grey's: next to a colour that is fainter no other's strength can be told from it, least of all in 8 bits."""


@dataclass(frozen=True, eq=False)
class Tone:
    """Colours, (1024, 3) float32 of luminance 1, at evenly spaced roots of luminance from 0 to `brightest`."""

    colours: np.ndarray
    brightest: float

    def exposed(self, exposure: float) -> Tone:
        """The tone of the picture times an exposure > 0."""
        return Tone(self.colours, self.brightest * exposure)

    def at(self, brightness: np.ndarray) -> np.ndarray:
        """The colour of luminances of any shape (...), as (..., 3) of luminance 1; beyond the brightest, its.

        NaN, which black is under a light without end, has that of black.
        """
        within = np.sqrt(np.fmin(np.fmax(brightness / np.float32(self.brightest), 0), 1))
        return self.colours[np.rint(within * (_STEPS - 1)).astype(np.int32)]

    def turned(self, before: np.ndarray, after: np.ndarray) -> np.ndarray:
        """What a place's colour is multiplied by where its luminance goes from `before` to `after`, (..., 3)."""
        return (self.at(after) + _FAINT) / (self.at(before) + _FAINT)


def tone_of(linear: np.ndarray) -> Tone | None:
    """The tone of a toned picture's pixels (N, 3), linear, >= 0; None for a black-and-white one.

    Means of the pixels of each of 64 levels and those beside it; straight between the levels that there are.
    """
    brightness = luminance(linear)
    brightest = float(brightness.max(initial=0))
    if brightest <= 0:
        return None
    level = np.minimum((np.sqrt(brightness / brightest) * _LEVELS).astype(int), _LEVELS - 1)
    counts, sums = (
        np.stack([np.bincount(level, weight, _LEVELS) for weight in weights], axis=-1)
        for weights in ([np.ones_like(brightness)], linear.T)
    )
    counts, sums = (part + _beside(part) for part in (counts, sums))
    total = luminance(sums)
    known = (counts[:, 0] > _FEWEST * len(linear)) & (total > _DARK * brightest)
    if not known.any():
        return None
    sums, total = sums[known], total[known]
    means = np.sqrt(total / (counts[known, 0] * brightest))
    steps = np.linspace(0, 1, _STEPS)
    colours = [np.interp(steps, means, sums[:, i] / total) for i in range(3)]
    colours = np.stack(colours, axis=-1).astype(np.float32)
    return None if np.abs(colours - 1).max() < _GREY else Tone(colours, brightest)


def _beside(levels: np.ndarray) -> np.ndarray:
    """Half of what the two levels beside each hold, (L, C)."""
    padded = np.pad(levels, ((1, 1), (0, 0)))
    return (padded[:-2] + padded[2:]) / 2
