"""Numbers as colours: a scale from nothing to much, and one from less through equal to more."""

from __future__ import annotations

import numpy as np

COLOURS = 256

_SCALE = (
    (0, 0, 4),
    (40, 11, 84),
    (101, 21, 110),
    (159, 42, 99),
    (212, 72, 66),
    (245, 125, 21),
    (250, 193, 39),
    (252, 255, 164),
)
_DIFFERENCE = (
    (94, 176, 255),
    (32, 92, 190),
    (34, 58, 104),
    (44, 44, 44),
    (86, 48, 16),
    (206, 104, 20),
    (255, 206, 110),
)


def scale_colours() -> np.ndarray:
    """(1, 256, 3) uint8 sRGB: black over violet and orange to pale yellow, ever lighter."""
    return _through(_SCALE)


def difference_colours() -> np.ndarray:
    """(1, 256, 3) uint8 sRGB: blue for less, dark grey for equal, orange for more; lighter away from equal."""
    return _through(_DIFFERENCE)


def _through(colours: tuple[tuple[int, int, int], ...]) -> np.ndarray:
    stops = np.linspace(0.0, 1.0, len(colours))
    along = np.linspace(0.0, 1.0, COLOURS)
    mixed = [np.interp(along, stops, channel) for channel in np.array(colours, np.float64).T]
    return np.ascontiguousarray(np.rint(np.stack(mixed, axis=-1)).astype(np.uint8)[None])
