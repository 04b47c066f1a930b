"""Shoulders, arms and hands beyond the networks' view: a coarse estimate of how the light changes them.

A person's outline gives a rough shape of the body, whose surface turns away toward the outline. Irradiance on the
normals of this shape varies over the body much as on the real one. The photo already contains the effect of its own
light, so the estimate under a new light is divided by the one under the photo's (Liu, Shan and Zhang 2001): under its
own light the rest of the person stays as it is. Within the networks' view their result corrects the estimate, and the
correction is continued outward, so that nothing changes abruptly at the view's edge.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import torch

from relight_core.imaging.colour import luminance
from relight_core.imaging.light_change import share_in_reach
from relight_core.imaging.photo_frame import Inside, going_on
from relight_core.imaging.ramp import ramp
from relight_core.imaging.resampling import resize_area, shrunk_size
from relight_core.imaging.tensor_images import as_tensor
from relight_core.lighting.reflection import NormalLookup, ReflectionTable
from relight_core.lighting.sphere import solid_angles

_LONGEST, _LONGEST_KNOWN = 128, 64
"""The longer side of the body's own maps, and of the maps in which corrections are continued."""
_DARK, _LEAST = 1e-3, 1e-9
"""Added to radiances before a division, and the smallest argument of a logarithm."""

_WELL_SEEN, _HEADROOM = 0.1, 0.1
"""Below this luminance of the photo, and within this distance from clipping, a correction has less weight, down to
`_FLOOR`."""
_FLOOR = 0.02
"""Smallest such weight."""
_HARDLY, _UNSEEN = (0.02, 0.1), 1e-3
"""Ramp of a channel's value over the brightest channel's, from the weight `_UNSEEN` to full weight: the gain of a dark
channel says little. For example, gloss on red cloth is twenty times its green, and would turn white cloth beside it
green."""
_BARELY, _MOSTLY = 0.2, 0.6
"""Ramp of the share of a cell that views cover, over which corrections there are continued. Below it they aren't, since
a neighbour's view may reach a little over somebody's shirt and take it for background."""

_REFLECTS = 0.9
"""The largest plausible albedo."""
_BRIGHT_WITHIN = 5
"""Side of the window, in cells, whose brightest cell is compared with that albedo, so that patterns keep their
contrast."""
_FILL = 0.15
"""Light that reaches any part of a body from all sides, as a share of the mean radiance."""
_REACHES = (0.0125, 0.03, 0.08, 0.2)
"""Standard deviations of the blurs by which values are continued, in longer sides of the map. The narrowest that
reaches enough known values counts."""


@dataclass(frozen=True, eq=False)
class Body:
    """What doesn't depend on the light; maps over the whole photo.

    Attributes:
        share: (h, w) the matte; h and w at most 128.
        light_of: the irradiance on the body's normals under a light.
        photo: (k, l, 3) linear; k and l at most 64.
        onward: continues (k, l, C) values from where views cover the body.
        evidence: (k, l, 3), in (0, 1], how much each channel says about its own gain.
        by_colour: as `onward`, with each channel also weighted by `evidence`.
    """

    share: np.ndarray
    light_of: NormalLookup
    photo: np.ndarray
    onward: Continuation
    evidence: np.ndarray
    by_colour: Continuation

    def continued(self, lit: np.ndarray, expected: np.ndarray) -> np.ndarray:
        """The log ratio (k, l, 3) of the views' result over the estimate, continued beyond the views.

        Colours are continued as means of logs, but luminance as a ratio of means. For a chest half in a lamp's light
        the mean of logs is nearly that of the shadow, and the body would become dark abruptly below the lit half. Far
        from anything known, where chairs and tables may be taken for a body, luminance has the mean of logs too.

        Args:
            lit, expected: (k, l, 3) linear, > 0, from the views and from the estimate; only used where views cover the
                body.
        """
        known = np.log(lit / expected)
        around = self.by_colour(known)
        # A channel that says little deviates from its surroundings by as much as the other channels there.
        off = (self.evidence * (known - around)).sum(-1, keepdims=True) / self.evidence.sum(-1, keepdims=True)
        colours = around + off + self.evidence * (known - around - off)
        light, due = luminance(lit), luminance(expected)
        continued = self.onward(np.dstack([colours, light, due, np.log(light / due)]))
        colours, (light, due, logs) = continued[..., :3], np.moveaxis(continued[..., 3:], -1, 0)
        brighter = np.log(np.maximum(light, _LEAST) / np.maximum(due, _LEAST)) - logs
        return colours + brighter[..., None] * self.onward.within_reach


def body_size(photo_size: tuple[int, int]) -> tuple[int, int]:
    """(height, width) of a body's maps for a photo of (height, width)."""
    return shrunk_size(photo_size, _LONGEST)


def make_body(
    photo: np.ndarray, share: np.ndarray, known: np.ndarray, table: ReflectionTable, inside: Inside | None = None
) -> Body:
    """Estimate a body from its outline.

    Args:
        photo: (h, w, 3) linear, of `body_size`.
        share: (h, w) in [0, 1], the matte.
        known: (h, w) in [0, 1], the share of each cell that the networks' views cover.
        table: for the irradiance.
        inside: the cells within the photo's frame; None if it has no frame. A body that the frame cuts off is taken to
            continue behind it, as beyond the photo's border.
    """
    outline = share if inside is None else going_on(share[inside], inside, share.shape)
    normal = as_tensor(_bulging(outline), table.transport.device)
    small = shrunk_size(share.shape, _LONGEST_KNOWN)
    photo, body, known = (resize_area(image, small) for image in (photo, share, known))
    lit, unclipped = luminance(photo) / _WELL_SEEN, (1 - photo.max(-1)) / _HEADROOM
    trusted = np.clip(np.minimum(lit, unclipped), _FLOOR, 1.0)
    weight = known * ramp(known, _BARELY, _MOSTLY) * np.maximum(body - 0.5, 0.0) * trusted
    evidence = ramp(photo / np.maximum(photo.max(-1, keepdims=True), _DARK), *_HARDLY).clip(_UNSEEN, 1.0)
    light_of = NormalLookup(table, normal, gloss=False)
    return Body(share, light_of, photo, Continuation(weight), evidence, Continuation(weight[..., None] * evidence))


@torch.inference_mode()
def body_shading(body: Body, light: torch.Tensor) -> np.ndarray:
    """Irradiance over pi on the body, with some fill, (h, w, 3) > 0, which is the radiance of a white matte body.

    Args:
        light: (1, 16, 32, 3), mean luminance 1.
    """
    irradiance = body.light_of(light)[0].permute(1, 2, 0).cpu().numpy()
    areas = solid_angles(*light.shape[1:3])
    around = np.tensordot(areas, light[0].cpu().numpy(), 2) / areas.sum()
    return irradiance + (_FILL * around + _DARK)


def body_gain(body: Body, light: torch.Tensor, relit: np.ndarray, in_photo: np.ndarray | None = None) -> np.ndarray:
    """The gain (h, w, 3) that turns the photo into the body under a normalised light, over the whole photo.

    Args:
        body: of the photo.
        light: (1, 16, 32, 3), mean luminance 1.
        relit: (k, l, 3) linear, the networks' relit picture, only used where they saw the photo; negative values count
            as black.
        in_photo: (h, w, 3) `body_shading` under the photo's own light; None if that isn't known, and the photo counts
            as evenly lit.
    """
    guess = body_shading(body, light)
    if in_photo is not None:
        guess = guess / in_photo
    small = guess if guess.shape == relit.shape else resize_area(guess, relit.shape[:2])
    correction = body.continued(np.maximum(relit, 0.0) + _DARK, (body.photo + _DARK) * small)
    if in_photo is not None:
        correction = _in_bounds(correction, body, small, resize_area(in_photo, relit.shape[:2]))
    correction = cv2.resize(np.exp(correction), guess.shape[1::-1], interpolation=cv2.INTER_LINEAR).reshape(guess.shape)
    gain = np.maximum(guess * correction, 0.0).astype(np.float32)
    return gain * share_in_reach(gain)


def _in_bounds(correction: np.ndarray, body: Body, guess: np.ndarray, in_photo: np.ndarray) -> np.ndarray:
    """A log correction (k, l, 3), lowered where the body would reflect more light than falls on it.

    It is not lowered below its mean over the known body. Under the photo's own light it is the same everywhere, and
    must not change.

    Args:
        correction: of the gain.
        body: of the photo.
        guess: (k, l, 3) the gain that is corrected.
        in_photo: (k, l, 3) as of `body_gain`.
    """
    relit = body.photo * guess * np.exp(correction)
    apparent_albedo = relit.max(-1) / (guess * in_photo).max(-1)
    window = np.ones((_BRIGHT_WITHIN,) * 2, np.uint8)
    apparent_albedo = cv2.blur(cv2.dilate(apparent_albedo.astype(np.float32), window), window.shape)
    too_much = np.log(np.maximum(apparent_albedo, 1e-6) / _REFLECTS)[..., None]
    above_mean = (correction - body.onward.mean(correction)).mean(-1, keepdims=True)
    return correction - np.clip(too_much, 0.0, np.maximum(above_mean, 0.0))


def _bulging(share: np.ndarray) -> np.ndarray:
    """Normals (h, w, 3) of a body that is as thick as it is wide, with elliptical cross-sections."""
    inside = (share > 0.5).astype(np.uint8)
    padded = cv2.copyMakeBorder(inside, 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    depth = np.minimum(cv2.distanceTransform(padded, cv2.DIST_L2, 5)[1:-1, 1:-1], max(share.shape) / 2)
    deepest = max(float(depth.max()), 1.0)
    height = np.sqrt(np.maximum(depth * (2 * deepest - depth), 0.0)).astype(np.float32)
    height = cv2.GaussianBlur(height, (0, 0), max(deepest / 4, 1.0))
    down, right = np.gradient(height) if min(height.shape) > 1 else (np.zeros_like(height),) * 2
    normal = np.stack([-right, down, np.ones_like(height)], axis=-1)
    return (normal / np.linalg.norm(normal, axis=-1, keepdims=True)).astype(np.float32)


class Continuation:
    """Continues values from where they are known, by means over surroundings that are as wide as necessary.

    Attributes:
        within_reach: (k, l, 1 or C) in [0, 1], whether the widest surroundings contain enough known values.
    """

    def __init__(self, weight: np.ndarray):
        """Compute what depends only on where values are known.

        Args:
            weight: (k, l) >= 0, of all channels of a value, or (k, l, C), of each of them.
        """
        self._weight = weight.astype(np.float32).reshape(*weight.shape[:2], -1)
        self._total = self._weight.sum((0, 1))
        reaches = [reach * max(weight.shape[:2]) for reach in reversed(_REACHES)]
        self._down, self._across = (np.stack([_blur(side, reach) for reach in reaches]) for side in weight.shape[:2])
        near = self._blurred(self._weight)
        self._nearness = 1 / np.maximum(near, 1e-9)
        self._trust = np.clip(near / 0.02, 0.0, 1.0)
        self.within_reach = self._trust[0]

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """The values (k, l, C), continued to all cells; 0 if nothing is known."""
        if self._total.max() < 1e-3:
            return np.zeros_like(values)
        weighted = values * self._weight
        result = np.broadcast_to(weighted.sum((0, 1)) / np.maximum(self._total, 1e-9), values.shape)
        for mean, trust in zip(self._blurred(weighted) * self._nearness, self._trust, strict=True):
            result = result + (mean - result) * trust
        return result.astype(np.float32)

    def mean(self, values: np.ndarray) -> np.ndarray:
        """The weighted mean (C,) of values (k, l, C)."""
        return (values * self._weight).sum((0, 1)) / np.maximum(self._total, 1e-9)

    def _blurred(self, image: np.ndarray) -> np.ndarray:
        """An image (k, l, C) blurred by every reach, the widest first, (reaches, k, l, C)."""
        height, width, channels = image.shape
        rows = (self._down.reshape(-1, height) @ image.reshape(height, -1)).reshape(-1, height, width, channels)
        return self._across[:, None] @ rows


def _blur(side: int, deviation: float) -> np.ndarray:
    """The matrix (side, side) of OpenCV's Gaussian blur along an axis; products with it are faster than blurring."""
    return cv2.GaussianBlur(np.eye(side, dtype=np.float32), (1, 2 * round(4 * deviation) + 1), 0, sigmaY=deviation)
