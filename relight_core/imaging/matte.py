"""The person's matte, and the person's own colour where the matte is soft."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.paste import Band, spread_crop
from relight_core.imaging.colour import luminance
from relight_core.imaging.resampling import resize_area, resize_smooth
from relight_core.imaging.view_transform import apply_view

_WORKING_PX = 1024
_SEGMENT_PX = 320
_FUSION_PX = 512
_BAND_SHARE = 0.05
_NEAR_SHARE = 0.015
_EDGE_CODES = 3.0


@dataclass(frozen=True, eq=False)
class Matte:
    """How much of each pixel is person, and what colour that part has, at any resolution.

    Small maps that any pixel of the photo is put into, so that no full-size result needs to be kept.

    Attributes:
        slope, level: (h, w): the matte is slope * guide + level, limited to [0, 1] (see `guide_of`).
        person, behind: (k, l, 3) linear, mean colours of both sides about each place.
        nearby: (k, l) the matte averaged about each place.
        own_alpha: whether the photo's own alpha is the matte; then the maps say nothing.
    """

    slope: np.ndarray
    level: np.ndarray
    person: np.ndarray
    behind: np.ndarray
    nearby: np.ndarray
    own_alpha: bool = False


def guide_of(linear: np.ndarray) -> np.ndarray:
    """What the matte's edges follow: the square root of luminance, (..., 3) to (...), [0, 1]."""
    grey = np.clip(luminance(linear), 0.0, 1.0)
    return np.sqrt(grey, out=grey)


def own_colour(linear: np.ndarray, share: np.ndarray, person: np.ndarray, behind: np.ndarray) -> np.ndarray:
    """The person's own colour where the matte is soft: what the mix of both sides leaves goes to the person.

    Args:
        linear: (h, w, 3), pixels of the photo.
        share: (h, w) the matte there.
        person, behind: (h, w, 3) mean colours of both sides.

    Returns:
        (h, w, 3) linear, >= 0, its share no brighter than the pixel; the pixels themselves where the matte is
        0 or 1.
    """
    soft = (share > 0.0) & (share < 1.0)
    if not soft.any():
        return linear
    alpha = share[soft][:, None]
    mean = person[soft]
    mixed = linear[soft]
    remainder = mixed - alpha * mean - (1.0 - alpha) * behind[soft]
    colour = linear.copy()
    colour[soft] = np.clip(mean + alpha * remainder, 0.0, np.maximum(mixed, 0.0) / alpha)
    return colour


def make_matte(linear: np.ndarray, masks: list[tuple[np.ndarray, Crop]], alpha: np.ndarray | None = None) -> Matte:
    """Carry coarse person masks to the whole photo, their edges moved onto the photo's.

    Beyond the crops the mask is continued by colour (GrabCut: Rother, Kolmogorov and Blake 2004), from
    where a crop is sure and from where a body must be; a guided filter (He, Sun and Tang 2013) then fits the
    edges. Costs some tenths of a second: once per photo.

    Args:
        linear: (H, W, 3) linear, the photo.
        masks: for each person (S, S) probability in [0, 1] that the crop's pixels are person, hair and
            clothes included, and where the crop lies.
        alpha: (H, W) the photo's own alpha. Where given and not opaque throughout, it is the matte.
    """
    size = linear.shape[:2]
    if alpha is not None and float(alpha.min()) < 1.0:
        nothing, black = np.zeros((1, 1), np.float32), np.zeros((1, 1, 3), np.float32)
        return Matte(nothing, nothing, black, black, nothing, True)
    small = resize_area(linear, _at_most(size, _WORKING_PX))
    guide = np.ascontiguousarray(apply_view(small))
    coarse = np.zeros(_at_most(size, _SEGMENT_PX), np.float32)
    for person, crop in masks:
        person = np.clip(np.nan_to_num(np.asarray(person, np.float32)), 0.0, 1.0)
        coarse = np.maximum(coarse, _whole_person(guide, person, crop, size))
    edges = _guided(guide, resize_smooth(coarse, guide.shape[:2]), max(round(max(guide.shape) / 50), 2))
    share = np.clip((edges - 0.1) / 0.8, 0.0, 1.0)
    slope, level = np.zeros_like(share), share
    if guide.shape[:2] != size:
        slope, level = _guided_coefficients(guide_of(small), share)
    fused = _at_most(size, _FUSION_PX)
    nearby = cv2.GaussianBlur(resize_area(share, fused), (0, 0), max(max(fused) * _NEAR_SHARE, 0.5))
    return Matte(slope, level, *_sides(small, share), np.clip(nearby, 0.0, 1.0))


def _guided_coefficients(guide: np.ndarray, mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Slope and level of the fast guided filter (He and Sun 2015) in windows of 5 x 5."""

    def mean(image: np.ndarray) -> np.ndarray:
        return cv2.blur(image, (5, 5), borderType=cv2.BORDER_REFLECT)

    mean_guide, mean_mask = mean(guide), mean(mask)
    variance = np.maximum(mean(guide * guide) - mean_guide**2, 0.0)
    slope = (mean(guide * mask) - mean_guide * mean_mask) / (variance + (_EDGE_CODES / 255) ** 2)
    return mean(slope), mean(mean_mask - slope * mean_guide)


def _sides(image: np.ndarray, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean colours of person and background about each place, by blur fusion (Forte 2021, two passes)."""
    size = _at_most(share.shape, _FUSION_PX)
    small, small_share = resize_area(image, size), np.clip(resize_area(share, size), 0.0, 1.0)
    wide = max(round(max(size) / 24), 12)
    person, behind = _side_means(small, small, small_share, wide)
    alpha = small_share[..., None]
    remainder = small - alpha * person - (1.0 - alpha) * behind
    person = np.maximum(person + alpha * remainder, 0.0)
    return _side_means(person, behind, small_share, max(wide // 12, 2))


def _side_means(
    foreground: np.ndarray, background: np.ndarray, share: np.ndarray, radius: int
) -> tuple[np.ndarray, np.ndarray]:
    """Local means of either side, weighted by how much of each pixel it has."""
    window = (2 * radius + 1,) * 2
    means = []
    for colour, weight in ((foreground, share), (background, 1.0 - share)):
        total = cv2.blur(weight, window)[..., None]
        means.append(cv2.blur(colour * weight[..., None], window) / (total + 1e-5))
    return means[0], means[1]


def _at_most(size: tuple[int, int], longest: int) -> tuple[int, int]:
    scale = min(longest / max(size), 1.0)
    return max(round(size[0] * scale), 1), max(round(size[1] * scale), 1)


def _guided(guide: np.ndarray, mask: np.ndarray, radius: int) -> np.ndarray:
    """Guided filter of a mask by an sRGB image. Both are finite: one NaN would spread over its window.

    The guide goes in as codes up to 255: with colours up to 1 OpenCV takes the covariance of any calm
    window for singular, and blurs.
    """
    codes = np.ascontiguousarray(guide * np.float32(255.0))
    return cv2.ximgproc.guidedFilter(codes, np.ascontiguousarray(mask, np.float32), radius, _EDGE_CODES**2)


def _whole_person(guide: np.ndarray, person: np.ndarray, crop: Crop, photo_size: tuple[int, int]) -> np.ndarray:
    """(h, w) coarse mask of the whole photo, h and w at most 320."""
    size = _at_most(photo_size, _SEGMENT_PX)
    placed = spread_crop(person, crop, Band(0, size[0], size, photo_size))
    x = (np.arange(size[1]) + 0.5) * photo_size[1] / size[1]
    y = (np.arange(size[0]) + 0.5) * photo_size[0] / size[0]
    within = crop.from_photo(np.stack(np.meshgrid(x, y), axis=-1), 1)
    inside = ((within >= 0) & (within < 1)).all(-1)
    reach = max(round(_BAND_SHARE * crop.side * size[0] / photo_size[0]), 1)
    return _continued(guide, placed, inside, _body_guess(x, y, crop, placed), reach)


def _body_guess(x: np.ndarray, y: np.ndarray, crop: Crop, placed: np.ndarray) -> np.ndarray:
    """(h, w) GrabCut labels outside the crop: shoulders widen below it, hair and hats go on above it,
    nobody is far above or beside."""
    across = np.abs(x - crop.centre_x)[None, :] / crop.side
    below = (y - crop.window[3])[:, None] / crop.side
    guess = np.full((len(y), len(x)), cv2.GC_PR_BGD, np.uint8)
    guess[(below < -1.0) & (placed > 0.5)] = cv2.GC_PR_FGD
    guess[(across < 0.45 + np.clip(below + 0.15, 0.0, 0.6)) & (below > -0.2)] = cv2.GC_PR_FGD
    guess[(across < 0.2) & (below > 0.0) & (below < 1.0)] = cv2.GC_FGD
    guess[(across > 2.0) | (below < -1.35)] = cv2.GC_BGD
    return guess


def _continued(guide: np.ndarray, placed: np.ndarray, inside: np.ndarray, guess: np.ndarray, reach: int) -> np.ndarray:
    """The mask after GrabCut, where colours allow it; else the crop's mask continued outward.

    Colours decide also within the crop near the mask's edge, up to `reach` pixels outside it.
    """
    narrow, wide = (np.ones((2 * r + 1,) * 2, np.uint8) for r in (max(reach // 3, 1), reach))
    coarse = (placed > 0.5).astype(np.uint8)
    labels = np.where(coarse, cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
    labels[cv2.erode(coarse, narrow) > 0] = cv2.GC_FGD
    labels[(cv2.dilate(coarse, wide) == 0) & (guess != cv2.GC_PR_FGD)] = cv2.GC_BGD
    labels = np.where(inside, labels, guess).astype(np.uint8)
    likely_person = (labels & 1) == 1
    if likely_person.sum() < 20 or (~likely_person).sum() < 20:
        return placed
    colours = np.rint(resize_area(guide, placed.shape) * 255.0).astype(np.uint8)
    cv2.setRNGSeed(0)
    cv2.grabCut(colours, labels, None, np.zeros((1, 65)), np.zeros((1, 65)), 4, cv2.GC_INIT_WITH_MASK)
    mask = ((labels & 1) == 1).astype(np.uint8)
    mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    return _joined_to(mask, (placed > 0.5) & inside).astype(np.float32)


def _joined_to(mask: np.ndarray, seed: np.ndarray) -> np.ndarray:
    """The connected parts of a mask that touch the seed, holes of less than 1 % filled."""
    _, parts = cv2.connectedComponents(mask)
    touched = np.unique(parts[seed & (mask > 0)])
    joined = np.isin(parts, touched[touched > 0])
    _, holes, stats, _ = cv2.connectedComponentsWithStats((~joined).astype(np.uint8))
    small = np.flatnonzero(stats[:, cv2.CC_STAT_AREA] < 0.01 * mask.size)
    return joined | np.isin(holes, small[small > 0])
