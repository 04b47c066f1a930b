"""Edges of small lamps' shadows at a higher resolution than the networks'.

A nose's shadow under a bare bulb ends within one or two millimetres. The networks' pixels cover three, and an edge
that is upsampled from them takes ten. But the horizon of the relief is smooth where a shadow ends, because the lamp
sets gradually behind the nose. So the horizon is upsampled instead and compared with the lamp's disc afterwards, and
the upsampled picture is brightened or darkened by the difference. Whether there is a shadow, and how deep it is, has
been decided before (see `hard_shadow`).
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
"""Smaller differences between neighbouring pixels are no edge, and shadows of less of the light can't be seen."""
_AROUND = np.ones((5, 5), np.uint8)
"""Window, in the networks' pixels, whose darkest and brightest values limit the result."""
_ALWAYS_LEFT = 0.03
"""Share of a surface's light that a shadow never takes: composition has learnt that some is reflected into it. Where
0.085 are left of the light, skin has a tenth of lit skin's brightness in the picture, and eyes an eighth."""
_MOST_TIMES = 4.0
"""Largest gain."""
_SOFT = 0.1
"""From this softness of shadows on, their edges are not drawn more finely than the networks' pixels."""


@dataclass(frozen=True, eq=False)
class LampEdge:
    """The edge of one lamp's shadow at the networks' size; maps (s, s) float32 in [0, 1].

    Attributes:
        lamp: in the view's camera space.
        counts: by how much the hidden share of all diffuse light grows from where none of the lamp is hidden to where
            all of it is, as far as geometry decides that.
        lost: the share of the lamp's light that is hidden.
    """

    lamp: Lamp
    counts: np.ndarray
    lost: np.ndarray


@dataclass(frozen=True, eq=False)
class ShadowEdges:
    """The edges of the shadows that a light's small lamps cast, at the networks' size.

    Attributes:
        horizon: of the relief.
        of_lamps: the edge of each lamp's shadow.
        hidden: (s, s) float32 in [0, 1], share of all diffuse light that is hidden.
        diffuse: (s, s) float32 >= 0, luminance of albedo times unoccluded irradiance.
    """

    horizon: Horizon
    of_lamps: Sequence[LampEdge]
    hidden: np.ndarray
    diffuse: np.ndarray


@dataclass(frozen=True, eq=False)
class FineEdges:
    """The hidden light at the picture's resolution.

    Attributes:
        coarse, fine: (S, S) float32 in [0, 1], share of all diffuse light that is hidden: upsampled, and with edges
            drawn at this size.
        diffuse: (s, s), as of `ShadowEdges`.
    """

    coarse: np.ndarray
    fine: np.ndarray
    diffuse: np.ndarray

    def gain(self, shadow_gain: float, softness: float) -> np.ndarray:
        """The gain that gives an upsampled picture the finer edges, (S, S, 3) in [0, 4].

        Args:
            shadow_gain, softness: the values of the shadow's sliders, [0, 2] and [0, 1]. A shadow that is removed has
                no edge, and a soft one no fine edge.
        """
        fine = self.coarse + np.float32(_sharp(softness)) * (self.fine - self.coarse)
        before, after = (light_left(hidden, shadow_gain) for hidden in (self.coarse, fine))
        gain = np.minimum((after + _ALWAYS_LEFT) / (before + _ALWAYS_LEFT), np.float32(_MOST_TIMES))
        return cv2.merge((gain,) * 3)

    def more_shadow(self) -> np.ndarray:
        """What the finer edges add to the shadow channel, (S, S) of either sign, in units of the normalised light."""
        return (self.fine - self.coarse) * resize_smooth(self.diffuse, self.coarse.shape)


def draw_finely(
    edges: ShadowEdges,
    upsample: Callable[[np.ndarray], np.ndarray],
    evened: Callable[[np.ndarray], np.ndarray] = np.asarray,
) -> FineEdges:
    """Upsample the hidden light, and draw the edges of shadows at that size.

    Args:
        edges: at the networks' size.
        upsample: upsamples maps (s, s, C) to (S, S, C) in the same way as the picture.
        evened: smooths a map (s, s) in the same way as the picture's gain.
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
    """Where a lamp's shadow ends visibly, (s, s) float32, 0 or 1; nothing is changed elsewhere."""
    window = np.ones((3, 3), np.uint8)
    brightest, darkest = np.minimum(edge.lost, evened), np.maximum(edge.lost, evened)
    differs = cv2.dilate(darkest, window) - cv2.erode(brightest, window)
    return np.float32((differs > _NO_EDGE) & (edge.counts > _NO_EDGE))


def _sharp(softness: float) -> float:
    """The weight of the fine edges, from 1 without softness to 0 at `_SOFT`."""
    return max(1.0 - softness / _SOFT, 0.0)
