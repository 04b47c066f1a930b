"""Strands of hair and the gaps between them, separated by the colours on both sides of a head's outline.

To the networks hair is solid, and in the small copy in which the matte is made a strand is less than a pixel. So a
bright wall between two strands would be relit as a patch beside the cheek, and strands that stand off would not be
relit. Along the outline of hair that is clearly darker than what lies behind it, each pixel's colour determines how
much of it is hair.

Lengths are in sides of the head's square, `Hair.head_px`, unless stated otherwise. Colours are displayed values, and a
pixel is described by its position on the line from the colour behind to the hair's.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.paste import Band, spread_crop, window_of
from relight_core.imaging.masks import disc, distance_to
from relight_core.imaging.photo_frame import Inside
from relight_core.imaging.ramp import ramp
from relight_core.imaging.resampling import resize_area, resize_smooth

_ABOUT, _ABOUT_PX = 0.045, 8.0
"""Standard deviation of the blur over which colours are learnt, and its size in pixels of the small copy."""
_SURELY_WITHIN = 0.014
"""Colours are learnt so far inside and outside of the outline."""
_LEAST_HEAD_PX = 64
"""Smallest side of a head's square, in pixels of the guide, for which strands are searched."""
_ROUNDS = 2
"""Rounds in which the hair's colour is learnt again without the pixels that look like what lies behind."""

_SPREAD_BEHIND, _SPREAD_OF_HAIR, _CODES = 1.0, 2.5, 0.02
"""A pixel is wholly behind, or wholly hair, within so many standard deviations of that side's colour, plus the last
number."""
_ALL_BEHIND, _ALL_HAIR = 0.4, 0.5
"""Limits of that, as shares of the way from behind to hair: a pixel beyond the first has some hair in it, however
uneven the surroundings, and a pixel before the second has something else in it. Where dark hair is in front of
something bright, half and half in linear light is a third of the way."""

_DISTINCT, _PLAIN = (2.0, 3.5), (0.2, 0.35)
"""Ramps of the distance between both colours over which it becomes sufficient: in standard deviations, and absolute."""
_SEEN = (0.02, 0.1)
"""Ramp of the share of the surroundings from which a side's colour was learnt, over which it becomes sufficient."""
_DARKER = 0.15
"""From this difference in brightness on, hair is clearly darker than what lies behind. Otherwise bright hair in shadow
could be taken for a dark wall."""
_OTHER_COLOUR = (0.1, 0.3)
"""Ramp of a colour's distance from the line between both, as a share of their distance, over which it becomes a third
colour. A lamp's glint on black hair doesn't look like an orange wall, nor does a wall that is grey and darker."""

_DEEP, _FAR_OUT = (0.036, 0.06), (0.024, 0.048)
"""Ramps of the distance inside the outline within which gaps are searched, and of that outside within which strands
are.
"""
_GAP, _SURELY_BETWEEN = 0.7, 0.95
"""A gap has a share of hair below the first, and a colour whose certainty of lying between both sides' is above the
second."""
_BY_A_GAP = (0.006, 0.014)
"""Ramp of the distance from a gap over which colours may no longer reduce hair. A gap is visible in the small copy too,
and connected to the outside, unlike glints and grey hairs."""
_BESIDE, _BRIGHT = 0.025, 0.75
"""A gap needn't be connected to the outside if it is at most this far from the outline, and if what lies behind has at
least the second as its displayed value, which hardly any glint has."""
_HAIR, _OTHERS = (0.3, 0.6), (0.2, 0.5)
"""Ramps of the probability of hair over which colours begin to count, and of other parts of a person over which they
cease to."""


@dataclass(frozen=True, eq=False)
class Hair:
    """Where the parsing sees the hair of a head.

    Attributes:
        hair, others: (S, S) float32 in [0, 1], probabilities of hair and of other parts of a person.
        view: where in the photo they lie.
        head_px: side of the paper's square around the face (section 3.2), in pixels of the photo.
    """

    hair: np.ndarray
    others: np.ndarray
    view: Crop
    head_px: float


@dataclass(frozen=True, eq=False)
class Strands:
    """A matte along the outlines of hair.

    Attributes:
        share: (h, w) in [0, 1], the share of each pixel that is hair.
        trust: (h, w) in [0, 1], the weight of that.
    """

    share: np.ndarray
    trust: np.ndarray

    def put_into(self, share: np.ndarray, kept: np.ndarray | None = None) -> np.ndarray:
        """A matte (h, w) with the strands inserted, except where `kept`, (h, w) in [0, 1], is 1."""
        trust = self.trust if kept is None else self.trust * (1 - kept)
        return share + trust * (self.share - share)


def strands_of(
    guide: np.ndarray,
    share: np.ndarray,
    heads: Iterable[Hair],
    photo_size: tuple[int, int],
    inside: Inside | None = None,
) -> Strands | None:
    """The strands along the outlines of people's hair.

    Args:
        guide: (h, w, 3) the photo or a copy of it as displayed, sRGB, [0, 1].
        share: (h, w) in [0, 1], the matte so far.
        heads: of the people.
        photo_size: (height, width).
        inside: the part of the guide within a frame; None for all of it.

    Returns:
        None if no hair is clearly darker than what lies behind it.
    """
    combined, trust = share.copy(), np.zeros_like(share)
    for head in heads:
        rows, columns = window = _intersection(window_of(head.view, photo_size, share.shape), inside)
        head_px = head.head_px * max(share.shape) / max(photo_size)
        if head_px < _LEAST_HEAD_PX or 0 in share[window].shape:
            continue
        band = Band(rows.start, rows.stop, share.shape, photo_size, (columns.start, columns.stop))
        masks = (spread_crop(_zero_outside(mask), head.view, band) for mask in (head.hair, head.others))
        found, surely = _separated(guide[window], share[window], *masks, head_px)
        surer = surely > trust[window]
        combined[window][surer], trust[window][surer] = found[surer], surely[surer]
    return Strands(combined, trust) if trust.any() else None


def _intersection(window: Inside, inside: Inside | None) -> Inside:
    """The intersection of two windows, empty if they don't overlap."""
    parts = zip(window, window if inside is None else inside, strict=True)
    ends = [(max(one.start, other.start), min(one.stop, other.stop)) for one, other in parts]
    return tuple(slice(start, max(start, stop)) for start, stop in ends)


def _zero_outside(mask: np.ndarray) -> np.ndarray:
    """A mask (S, S) with a border of 0, which resampling then repeats outside the view."""
    return np.pad(mask[1:-1, 1:-1], 1)


def _separated(
    guide: np.ndarray, share: np.ndarray, hair: np.ndarray, others: np.ndarray, head_px: float
) -> tuple[np.ndarray, np.ndarray]:
    """`Strands.share` and `Strands.trust` of one head; the arguments are parts, (h, w) or (h, w, 3), around it."""
    scale = min(_ABOUT_PX / (_ABOUT * head_px), 1.0)
    few = max(1, round(share.shape[0] * scale)), max(1, round(share.shape[1] * scale))
    small = [resize_area(image, few) for image in (guide, share, hair, others)]
    sides = _sides_about(*small[:3], head_px * scale)
    trust = resize_smooth(_trust(sides, *small, head_px * scale), share.shape)
    at = trust > 0
    behind, toward, far, low, high = (
        resize_smooth(np.ascontiguousarray(one, np.float32), share.shape)[at]
        for one in (sides.behind, sides.toward, sides.distance, sides.low, sides.high)
    )
    toward /= np.maximum(np.linalg.norm(toward, axis=-1, keepdims=True), 1e-3)
    position, aside = _along(guide[at] - behind, toward)
    found = share.copy()
    found[at] = ramp(position, low, high)
    trust[at] *= _between(position, aside, low, far)
    return found, trust


@dataclass(frozen=True, eq=False)
class _Sides:
    """The colours on both sides of an outline, around each place of a small copy (k, l).

    Attributes:
        behind: (k, l, 3) mean colour of what lies behind the hair.
        toward: (k, l, 3) unit vector from there to the hair's mean colour.
        distance: (k, l) between both colours.
        low, high: (k, l) positions along `toward` up to which a pixel contains no hair, and from which on nothing else.
        certainty: (k, l) in [0, 1] that both colours are distinct and the hair is the darker one.
    """

    behind: np.ndarray
    toward: np.ndarray
    distance: np.ndarray
    low: np.ndarray
    high: np.ndarray
    certainty: np.ndarray


def _sides_about(guide: np.ndarray, share: np.ndarray, hair: np.ndarray, head_px: float) -> _Sides:
    """Learn the hair's colour well inside the outline, and the one behind well outside.

    Round by round, pixels inside that look like what lies behind are excluded.
    """
    inner, outer = cv2.erode(share, disc(_SURELY_WITHIN * head_px)), cv2.dilate(share, disc(_SURELY_WITHIN * head_px))
    of_hair, of_behind = ramp(inner, 0.8, 1.0) * ramp(hair, 0.5, 0.9), 1 - ramp(outer, 0.0, 0.2)
    reach = _ABOUT * head_px
    behind, behind_seen = _mean(guide, of_behind, reach)
    for again in range(_ROUNDS + 1):
        colour, hair_seen = _mean(guide, of_hair, reach)
        distance = np.maximum(np.linalg.norm(colour - behind, axis=-1), 1e-3)
        toward = (colour - behind) / distance[..., None]
        position, _ = _along(guide - behind, toward)
        if again < _ROUNDS:
            of_hair = of_hair * ramp(position / distance, 0.3, 0.6)
    spread = np.sqrt(_mean(np.square(position - distance), of_hair, reach)[0])
    spread_behind = np.sqrt(_mean(np.square(position), of_behind, reach)[0])
    low = np.minimum(_SPREAD_BEHIND * spread_behind + _CODES, _ALL_BEHIND * distance)
    high = np.maximum(distance - _SPREAD_OF_HAIR * spread - _CODES, _ALL_HAIR * distance)
    certainty = ramp(distance / (spread + spread_behind + _CODES), *_DISTINCT) * ramp(distance, *_PLAIN)
    certainty *= ramp(-toward.mean(-1) * distance, 0.0, _DARKER)
    return _Sides(behind, toward, distance, low, high, certainty * ramp(hair_seen, *_SEEN) * ramp(behind_seen, *_SEEN))


def _trust(
    sides: _Sides, guide: np.ndarray, share: np.ndarray, hair: np.ndarray, others: np.ndarray, head_px: float
) -> np.ndarray:
    """The weight of colours, (k, l) in [0, 1]: near the outline, and inside of it only at gaps."""
    position, aside = _along(guide - sides.behind, sides.toward)
    outside = share <= 0.5
    reach = 1 - ramp(distance_to(outside) / head_px, *_DEEP)
    between = _between(position, aside, sides.low, sides.distance)
    see_through = (sides.certainty * reach > 0.5) & (between > _SURELY_BETWEEN)
    gaps = see_through & (ramp(position, sides.low, sides.high) < _GAP)
    enclosed = gaps & (sides.behind.mean(-1) > _BRIGHT) & (distance_to(outside) < _BESIDE * head_px)
    gaps = _connected(outside, gaps) | enclosed
    near = reach * (1 - ramp(distance_to(gaps) / head_px, *_BY_A_GAP))
    near *= 1 - ramp(distance_to(~outside) / head_px, *_FAR_OUT)
    hairy = ramp(cv2.dilate(hair, disc(0.01 * head_px)), *_HAIR)
    hairy = cv2.GaussianBlur(hairy, (0, 0), max(0.006 * head_px, 0.5))
    not_others = 1 - ramp(cv2.GaussianBlur(others, (0, 0), max(0.003 * head_px, 0.5)), *_OTHERS)
    return (sides.certainty * near * hairy * not_others).astype(np.float32)


def _between(position: np.ndarray, aside: np.ndarray, low: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """Certainty in [0, 1] that a colour is a mix of both sides': 0 beside the line between them or beyond `behind`.

    Args:
        position, aside: of the colour, see `_along`.
        low, distance: as of `_Sides`.
    """
    return 1 - ramp((aside + np.maximum(-position - low, 0)) / distance, *_OTHER_COLOUR)


def _connected(outside: np.ndarray, gaps: np.ndarray) -> np.ndarray:
    """The outside together with the gaps that are connected to it, (k, l) bool."""
    _, pieces = cv2.connectedComponents((outside | gaps).astype(np.uint8))
    return (pieces > 0) & np.isin(pieces, pieces[outside])


def _along(colour: np.ndarray, toward: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The component of colours (..., 3) along a unit vector (..., 3), and their distance from its line, (...) each."""
    position = (colour * toward).sum(-1)
    return position, np.linalg.norm(colour - position[..., None] * toward, axis=-1)


def _mean(image: np.ndarray, weight: np.ndarray, reach_px: float) -> tuple[np.ndarray, np.ndarray]:
    """Local means of an image (k, l) or (k, l, 3), weighted by `weight` (k, l), and of the weight itself, (k, l)."""
    weight = weight.astype(np.float32)
    seen = cv2.GaussianBlur(weight, (0, 0), reach_px)
    spread = (slice(None), slice(None), *[None] * (image.ndim - 2))
    total = cv2.GaussianBlur(np.ascontiguousarray(image * weight[spread], np.float32), (0, 0), reach_px)
    return total / np.maximum(seen, 1e-6)[spread], seen
