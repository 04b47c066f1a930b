"""Enlarging small maps along the edges of a picture: joint bilateral upsampling (Kopf et al. 2007).

Where an edge is soft, as a shadow's is, a pixel within it is like neither side, and whichever it is likest gave it the
wrong light: a dark or bright line ran along the edge. There the maps are taken for a straight function of what light
divides by, 1 / luminance, fitted to the neighbours (He, Sun and Tang 2013): of a shadow that is taken out it is one.
On skin, which is of one colour, any steep step of luminance is light's, and the fit is exact.

The weights follow from the picture alone, so they are computed once per photo and then serve every light.
"""

from __future__ import annotations

import cv2
import numpy as np
import torch
import torch.nn.functional as F

from relight_core.imaging.colour import luminance
from relight_core.imaging.shadow_steps import ShadowSteps, reciprocal, steepness, without_holes, without_specks

_COLOUR_DEVIATION = 0.05
_FAR = 1e-6
_TAPS = 9
_NO_VARIANCE = 0.005
"""Of 1 / luminance beside its squared mean: where it varies less, it tells nothing."""
_STEEPEST, _STRIDE, _ROUNDS = 40.0, 8.0, 8
"""The exponent over the range of values at the most, what of it one round may change, and how many there are."""


class JointUpsampler:
    """Each new pixel is a mean of the 3 x 3 small ones around it, weighted by nearness and by likeness.

    Likeness is that of the picture's colours, square roots of linear light, after what the picture's own slope from
    the neighbour to the pixel explains: across a shaded cheek likeness alone would make steps of a slope. The less a
    pixel is like the likest of its neighbours, the more of it follows its luminance between theirs. All weights are
    positive or 0 and sum to 1: where maps are higher, nothing gets lower.

    Attributes:
        size, factor: of the small maps, and how many times that the large ones are.
        steps: where shadows end on skin; None where none do or nothing is enlarged.
    """

    def __init__(self, small: np.ndarray, large: np.ndarray, skin: np.ndarray | None = None):
        """Compute the weights.

        Args:
            small: (s, s, 3) linear, the picture at the maps' size.
            large: (f s, f s, 3) linear, the same picture; f is a whole number.
            skin: (s, s) in [0, 1], how surely each small pixel is of the one colour of bare skin; None for nowhere.

        Raises:
            ValueError: sizes that are no whole multiple.
        """
        size, factor = small.shape[0], large.shape[0] // small.shape[0]
        if large.shape[:2] != (factor * size, factor * size) or small.shape[:2] != (size, size):
            raise ValueError(f"{large.shape[:2]} is no whole multiple of {small.shape[:2]}")
        self.size, self.factor = size, factor
        self._weights = self.steps = None
        if factor > 1:
            skin = np.zeros((size, size), np.float32) if skin is None else skin
            steep = steepness(without_holes(reciprocal(small)))
            plain = without_specks(reciprocal(large), factor)
            self._weights = self._likeness(small, large, plain, torch.from_numpy(skin * steep))
            self.steps = ShadowSteps.find(skin, steep, plain, large)

    def __call__(self, maps: np.ndarray) -> np.ndarray:
        """Enlarge maps (s, s, C) to (f s, f s, C) float32."""
        maps = np.ascontiguousarray(maps, np.float32)
        if self._weights is None:
            return maps
        size, factor, channels = self.size, self.factor, maps.shape[2]
        around = F.pad(torch.from_numpy(maps).permute(2, 0, 1)[None], (1, 1, 1, 1), mode="replicate")[0]
        taps = [around[:, y : y + size, x : x + size].contiguous() for y in range(3) for x in range(3)]
        # Plane by plane: whole rows at a time keep the processor busier than one small product per pixel.
        cells = torch.empty(factor, factor, channels, size, size)
        for cell, weights in zip(cells.flatten(0, 1), self._weights, strict=True):
            torch.mul(taps[0], weights[0], out=cell)
            for tap, weight in zip(taps[1:], weights[1:], strict=True):
                cell.addcmul_(tap, weight)
        return _interleaved(cells.numpy())

    def change(
        self, gain: np.ndarray, offset: np.ndarray, of_light: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Enlarge what a light changes the picture by: no line is left where it takes a shadow out of skin.

        Args:
            gain, offset: (s, s, 3) linear.
            of_light: (s, s, 3) the gain before sliders moved it; None where none did.

        Returns:
            Gain and offset (f s, f s, 3) float32.
        """
        enlarged = self(gain), self(offset)
        if self.steps is None:
            return enlarged
        undoing = None if of_light is None else self(luminance(of_light)[..., None])[..., 0]
        return self.steps.taken_out(*enlarged, undoing)

    def _likeness(self, small: np.ndarray, large: np.ndarray, plain: np.ndarray, at_step: torch.Tensor) -> torch.Tensor:
        """(f * f, 9, s, s) weights of the neighbours of every new pixel.

        Args:
            small, large: of `__init__`.
            plain: (f s, f s) `reciprocal` of the large picture, without specks.
            at_step: (s, s) in [0, 1], how surely skin lies at the edge of a shadow.
        """
        size, factor = self.size, self.factor
        around = _neighbours(_as_seen(small))
        slopes = _slopes(around)
        cells = _cells(_as_seen(large), factor) - _along(slopes, _places(_within(factor)))
        around = around - _along(slopes, _places(torch.tensor([-1.0, 0.0, 1.0])))
        there = _neighbours(_plane(reciprocal(small)))[:, 0]
        own, unspecked = (_cells(_plane(each), factor)[:, 0] for each in (reciprocal(large), plain))
        weights = torch.empty(factor * factor, _TAPS, size, size)
        for cell, grey, step, near, weight in zip(cells, own, unspecked, _nearness(factor), weights, strict=True):
            near = near[:, None, None]
            likeness = torch.exp((cell - around).square().sum(1) / (-2 * _COLOUR_DEVIATION**2))
            alike, unlike = (likeness + _FAR) * near, 1 - likeness.amax(0)
            alike /= alike.sum(0)
            torch.lerp(alike, _by_luminance(there, grey, near), unlike, out=weight)
            _follow_steps(weight, torch.lerp(alike, near.expand_as(alike), unlike), there, step, at_step)
        return weights


def _follow_steps(
    weights: torch.Tensor, likely: torch.Tensor, there: torch.Tensor, own: torch.Tensor, share: torch.Tensor
) -> None:
    """Change weights (9, s, s), by a share (s, s), to those next to `likely` (9, s, s) that follow luminance exactly.

    Args:
        there, own: of `_by_luminance`.
    """
    where = share > 0
    exactly = _with_mean(likely[:, where], there[:, where], own[where])
    weights[:, where] = torch.lerp(weights[:, where], exactly, share[where])


def _with_mean(weights: torch.Tensor, values: torch.Tensor, mean: torch.Tensor) -> torch.Tensor:
    """(9, N) the weights, of relative entropy nearest to given ones, under which values (9, N) have a mean (N,).

    They are the given ones times an exponential of the values (Hainmueller 2012), so none is negative. Means beyond
    the values become the nearest that those can have.
    """
    least = values.amin(0)
    width = (values.amax(0) - least).clamp_min(1e-6)
    along, wanted = (values - least) / width, _odds((mean - least) / width)
    slope = torch.zeros_like(mean)
    # Newton's method on log odds, which between two values are straight in the slope.
    for _ in range(_ROUNDS):
        tilted = _tilted(weights, slope * along)
        reached = (tilted * along).sum(0)
        spread = (tilted * (along - reached).square()).sum(0).clamp_min(1e-6)
        step = (wanted - _odds(reached)) * reached * (1 - reached) / spread
        slope = (slope + step.clamp(-_STRIDE, _STRIDE)).clamp(-_STEEPEST, _STEEPEST)
    return _tilted(weights, slope * along)


def _odds(share: torch.Tensor) -> torch.Tensor:
    return torch.logit(share, eps=1e-5)


def _tilted(weights: torch.Tensor, exponent: torch.Tensor) -> torch.Tensor:
    tilted = weights * torch.exp(exponent - exponent.amax(0))
    return tilted / tilted.sum(0)


def _by_luminance(there: torch.Tensor, own: torch.Tensor, near: torch.Tensor) -> torch.Tensor:
    """(9, s, s) weights that give new pixels about what a line over 1 / luminance has at their own.

    Those that the line would make negative are 0.

    Args:
        there: (9, s, s) 1 / luminance of the neighbours.
        own: (s, s) of the new pixels at one place within the small ones.
        near: (9, 1, 1) how much each neighbour counts in fitting the line.
    """
    own = own.clamp(there.amin(0), there.amax(0))
    mean = (near * there).sum(0)
    apart = there - mean
    variance = (near * apart.square()).sum(0)
    weights = near * (1 + apart / (variance + _NO_VARIANCE * mean.square()) * (own - mean)).clamp_min(0)
    return weights / weights.sum(0)


def _plane(values: np.ndarray) -> torch.Tensor:
    return torch.from_numpy(values)[..., None]


def _cells(image: torch.Tensor, factor: int) -> torch.Tensor:
    """(f s, f s, C) to (f * f, C, s, s): what lies at each place within the small pixels, rows first."""
    size, channels = image.shape[0] // factor, image.shape[2]
    cells = image.reshape(size, factor, size, factor, channels).permute(1, 3, 4, 0, 2)
    return cells.reshape(factor * factor, channels, size, size)


def _interleaved(cells: np.ndarray) -> np.ndarray:
    """What every small pixel becomes, (f, f, C, s, s), as one picture (f s, f s, C).

    OpenCV interleaves planes six times as fast as a permuted array is copied.
    """
    factor, _, channels, size, _ = cells.shape
    planes = np.empty((channels, size, factor, size * factor), np.float32)
    for channel, plane in enumerate(planes):
        for row in range(factor):
            plane[:, row] = cv2.merge(list(cells[row, :, channel])).reshape(size, -1)
    side = size * factor
    return cv2.merge(list(planes.reshape(channels, side, side))).reshape(side, side, channels)


def _as_seen(linear: np.ndarray) -> torch.Tensor:
    return torch.from_numpy(np.sqrt(np.clip(np.nan_to_num(linear, nan=0.0), 0, 1), dtype=np.float32))


def _neighbours(image: torch.Tensor) -> torch.Tensor:
    """(s, s, C) to (9, C, s, s), rows first; the border repeats."""
    (height, width), padded = image.shape[:2], F.pad(image.permute(2, 0, 1)[None], (1, 1, 1, 1), mode="replicate")[0]
    return torch.stack([padded[:, y : y + height, x : x + width] for y in range(3) for x in range(3)])


def _slopes(around: torch.Tensor) -> torch.Tensor:
    """(2, C, s, s), down and to the right, per small pixel; 0 at edges, where the two sides' slopes differ.

    Args:
        around: of `_neighbours`.
    """
    above, left, here, right, below = (around[tap] for tap in (1, 3, 4, 5, 7))
    return torch.stack([_lesser(here - above, below - here), _lesser(here - left, right - here)])


def _lesser(one: torch.Tensor, other: torch.Tensor) -> torch.Tensor:
    """The smaller in magnitude, 0 where they have different signs."""
    smaller = torch.minimum(one.abs(), other.abs())
    return torch.where(one * other > 0, smaller * one.sign(), torch.zeros(()))


def _along(slopes: torch.Tensor, places: torch.Tensor) -> torch.Tensor:
    """How much slopes (2, C, s, s) rise up to each of some places (N, 2): (N, C, s, s)."""
    down, right = places.T[..., None, None, None]
    return down * slopes[0] + right * slopes[1]


def _within(factor: int) -> torch.Tensor:
    """(f,) where new pixels lie within a small one, from its middle."""
    return (torch.arange(factor) + 0.5) / factor - 0.5


def _places(along: torch.Tensor) -> torch.Tensor:
    """(n * n, 2) places down and to the right, rows first."""
    return torch.cartesian_prod(along, along)


def _nearness(factor: int) -> torch.Tensor:
    """(f * f, 9) weights of neighbours by distance: the quadratic B-spline, which keeps slopes straight."""
    within = _within(factor)
    along = torch.stack([(0.5 - within).square() / 2, 0.75 - within.square(), (0.5 + within).square() / 2], -1)
    return torch.einsum("ai,bj->abij", along, along).reshape(factor * factor, _TAPS)
