"""Edges of small lamps' shadows, finer than the networks see a face.

A nose's shadow under a bare bulb ends within a millimetre or two, a pixel of the networks within three, and what is
enlarged from such pixels ends within ten. The horizon of the relief is smooth where a shadow ends, as the lamp goes
down behind the nose little by little: so it is enlarged instead, compared with the lamp's disc afterwards, and what
is lit differently by that is brightened or darkened in the enlarged picture. How deep a shadow is, and whether there
is one, has been decided before (see `hard_shadow`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.imaging.resampling import resize_smooth
from relight_core.lighting.horizon import Horizon
from relight_core.lighting.lamps import Lamp
from relight_core.pipeline.per_light.hints import light_left

_NO_EDGE = 0.02
"""Differences of what a lamp's shadow hides, from pixel to pixel, that are none, and shares too small to be seen."""
_AROUND = np.ones((5, 5), np.uint8)
"""A shadow is nowhere deeper, and light nowhere brighter, than so many of the networks' pixels around."""
_ALWAYS_LEFT = 0.03
"""Share of a surface's light that is never quite hidden: composition has learnt that it is thrown back. Where 0.085
are left by the shadow, pictures of skin have a tenth of the lit skin's brightness, and eyes an eighth."""
_MOST_TIMES = 4.0
_SOFT = 0.1
"""Softness of shadows from which on their edges are as soft as the networks' pixels."""


@dataclass(frozen=True, eq=False)
class LampEdge:
    """The edge of one lamp's shadow, at the networks' size; maps (s, s) float32 in [0, 1].

    Attributes:
        lamp: as the view is turned.
        counts: share of all diffuse light that is hidden where all of the lamp is and not where none of it is, as far
            as geometry has a say.
        lost: of the lamp's light, the share that is hidden.
    """

    lamp: Lamp
    counts: np.ndarray
    lost: np.ndarray


@dataclass(frozen=True, eq=False)
class ShadowEdges:
    """The edges of the shadows that a light's small lamps cast, at the networks' size.

    Attributes:
        horizon: of the relief.
        of_lamps: each lamp's.
        hidden: (s, s) float32 in [0, 1], share of all diffuse light that is hidden.
        diffuse: (s, s) float32 >= 0, grey: albedo times irradiance where nothing is hidden.
    """

    horizon: Horizon
    of_lamps: Sequence[LampEdge]
    hidden: np.ndarray
    diffuse: np.ndarray


@dataclass(frozen=True, eq=False)
class FineEdges:
    """What shadows hide, enlarged.

    Attributes:
        coarse, fine: (S, S) float32 in [0, 1], share of all diffuse light that is hidden, with edges as enlarging
            makes them, and finer.
        diffuse: (s, s), as of `ShadowEdges`.
    """

    coarse: np.ndarray
    fine: np.ndarray
    diffuse: np.ndarray

    def gain(self, shadow_gain: float, softness: float) -> np.ndarray:
        """By what to multiply an enlarged picture for it to have the finer edges, (S, S, 3) in [0, 4].

        Args:
            shadow_gain, softness: where the shadow's sliders stand, [0, 2] and [0, 1]. A shadow that is taken away
                has no edge, and a soft one no fine edge.
        """
        fine = self.coarse + np.float32(_sharp(softness)) * (self.fine - self.coarse)
        before, after = (light_left(hidden, shadow_gain) for hidden in (self.coarse, fine))
        gain = np.minimum((after + _ALWAYS_LEFT) / (before + _ALWAYS_LEFT), np.float32(_MOST_TIMES))
        return cv2.merge((gain,) * 3)

    def more_shadow(self) -> np.ndarray:
        """What the finer edges add to the shadow channel or take from it, (S, S), in units of the normalised light."""
        return (self.fine - self.coarse) * resize_smooth(self.diffuse, self.coarse.shape)


def draw_finely(
    edges: ShadowEdges,
    upsample: Callable[[np.ndarray], np.ndarray],
    evened: Callable[[np.ndarray], np.ndarray] = np.asarray,
) -> FineEdges:
    """Enlarge what shadows hide, and draw their edges at that size.

    Args:
        upsample: enlarges maps (s, s, C) as the picture is enlarged, to (S, S, C).
        evened: a map (s, s) as even as the picture's gain is made.
    """
    lost_before = [evened(edge.lost) for edge in edges.of_lamps]
    coarse, *lost_enlarged = cv2.split(upsample(np.dstack([evened(edges.hidden), *lost_before])))
    size = coarse.shape
    change = np.zeros(coarse.size, np.float32)
    for edge, before, enlarged in zip(edges.of_lamps, lost_before, lost_enlarged, strict=True):
        there = np.flatnonzero(resize_smooth(_ending(edge, before), size) > 0)
        take = lambda image: resize_smooth(image, size).ravel()[there]  # noqa: E731, B023
        lost = 1 - edges.horizon.visibility(edge.lamp.toward, edge.lamp.radius_deg, take)
        change[there] += take(edge.counts) * (lost - enlarged.ravel()[there])
    least, most = (resize_smooth(around(edges.hidden, _AROUND), size) for around in (cv2.erode, cv2.dilate))
    fine = np.clip(coarse + change.reshape(size), np.minimum(coarse, least), np.maximum(coarse, most))
    return FineEdges(coarse, fine, edges.diffuse)


def _ending(edge: LampEdge, evened: np.ndarray) -> np.ndarray:
    """Where a lamp's shadow ends and that can be seen, (s, s) float32, 0 or 1; all else is left as it is."""
    window = np.ones((3, 3), np.uint8)
    brightest, darkest = np.minimum(edge.lost, evened), np.maximum(edge.lost, evened)
    differs = cv2.dilate(darkest, window) - cv2.erode(brightest, window)
    return np.float32((differs > _NO_EDGE) & (edge.counts > _NO_EDGE))


def _sharp(softness: float) -> float:
    return max(1.0 - softness / _SOFT, 0.0)
