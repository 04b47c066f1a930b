"""The person's matte at the photo's resolution, and another background behind the person."""

from __future__ import annotations

import cv2
import numpy as np

from relight_core.face.crop import Crop
from relight_core.imaging.colour import luminance, srgb_encode
from relight_core.imaging.resampling import resample_window, resize_area, resize_smooth
from relight_core.imaging.view_transform import apply_view

_WORKING_PX = 1024
_SEGMENT_PX = 320
_FUSION_PX = 512
_SURE = 0.9
_EDGE_CODES = 3.0


def refine_matte(
    linear: np.ndarray, person: np.ndarray, crop: Crop, alpha: np.ndarray | None = None
) -> np.ndarray:
    """Carry a coarse person mask to the photo's resolution, its edges moved onto the photo's.

    Beyond the crop the mask is continued by colour (GrabCut: Rother, Kolmogorov and Blake 2004), from
    where the crop is sure and from where a body must be; a guided filter (He, Sun and Tang 2013) then
    fits the edges. Costs some tenths of a second: once per photo.

    Args:
        linear: (H, W, 3) linear, the photo.
        person: (S, S) probability in [0, 1] that the crop's pixels are person, hair and clothes included.
        crop: where `person` lies.
        alpha: (H, W) the photo's own alpha. Where given and not opaque throughout, it is the matte.

    Returns:
        (H, W) float32 in [0, 1].
    """
    if alpha is not None and float(alpha.min()) < 1.0:
        return np.clip(np.nan_to_num(np.asarray(alpha, np.float32)), 0.0, 1.0)
    person = np.clip(np.nan_to_num(np.asarray(person, np.float32)), 0.0, 1.0)
    size = linear.shape[:2]
    guide = np.ascontiguousarray(apply_view(resize_area(linear, _at_most(size, _WORKING_PX))))
    mask = resize_smooth(_whole_person(guide, person, crop, size), guide.shape[:2])
    radius = max(round(max(guide.shape) / 50), 2)
    edges = _guided(guide, mask, radius)
    matte = np.clip((edges - 0.1) / 0.8, 0.0, 1.0)
    if guide.shape[:2] != size:
        full_guide = srgb_encode(np.clip(luminance(linear), 0.0, 1.0))
        factor = size[0] / guide.shape[0]
        matte = _guided(full_guide, resize_smooth(matte, size), max(round(1.5 * factor), 1))
    return np.ascontiguousarray(np.clip(matte, 0.0, 1.0))


def replace_background(linear: np.ndarray, matte: np.ndarray, background: np.ndarray) -> np.ndarray:
    """The person over another background, without a rim of the old one.

    Args:
        linear: (H, W, 3) linear.
        matte: (H, W) in [0, 1].
        background: (H, W, 3) or (3,) linear.

    Returns:
        (H, W, 3) float32 linear.
    """
    share = np.asarray(matte, np.float32)[..., None]
    behind = np.asarray(background, np.float32)
    return share * foreground_colour(linear, matte) + (1.0 - share) * behind


def foreground_colour(linear: np.ndarray, matte: np.ndarray) -> np.ndarray:
    """The person's own colour where the matte is soft, by blur fusion (Forte 2021, two passes).

    What lies around is averaged at no more than 512 pixels; the pixels' own share is exact.

    Args:
        linear: (H, W, 3) linear.
        matte: (H, W) in [0, 1].

    Returns:
        (H, W, 3) float32 linear, >= 0; the image itself where the matte is 1.
    """
    image = np.asarray(linear, np.float32)
    share = np.ascontiguousarray(matte, np.float32)
    soft = (share > 0.0) & (share < 1.0)
    if not soft.any():
        return image
    size = _at_most(share.shape, _FUSION_PX)
    small, small_share = resize_area(image, size), np.clip(resize_area(share, size), 0.0, 1.0)
    wide = max(round(max(size) / 24), 12)
    foreground, background = _side_means(small, small, small_share, wide)
    remainder = _remainder(small, small_share, foreground, background)
    foreground = np.maximum(foreground + small_share[..., None] * remainder, 0.0)
    foreground, background = _side_means(foreground, background, small_share, max(wide // 12, 2))
    foreground, background = (resize_smooth(mean, share.shape) for mean in (foreground, background))
    own = foreground + share[..., None] * _remainder(image, share, foreground, background)
    return np.where(soft[..., None], np.maximum(own, 0.0), image)


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


def _remainder(
    image: np.ndarray, share: np.ndarray, foreground: np.ndarray, background: np.ndarray
) -> np.ndarray:
    """What the mix of both sides leaves of the image."""
    alpha = share[..., None]
    return image - alpha * foreground - (1.0 - alpha) * background


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


def _whole_person(
    guide: np.ndarray, person: np.ndarray, crop: Crop, photo_size: tuple[int, int]
) -> np.ndarray:
    """(h, w) coarse mask of the whole photo, h and w at most 320."""
    size = _at_most(photo_size, _SEGMENT_PX)
    corners = crop.from_photo(np.array([[0, 0], photo_size[::-1]]), person.shape[0])
    placed = np.clip(resample_window(person, tuple(corners.ravel()), size), 0.0, 1.0)
    x = (np.arange(size[1]) + 0.5) * photo_size[1] / size[1]
    y = (np.arange(size[0]) + 0.5) * photo_size[0] / size[0]
    x0, y0, x1, y1 = crop.window
    inside = ((y >= y0) & (y < y1))[:, None] & ((x >= x0) & (x < x1))[None, :]
    if inside.mean() > 0.98:
        return placed
    grown = _continued(guide, placed, inside, _body_guess(x, y, crop, placed))
    return np.where(inside, np.where(np.abs(placed - 0.5) > _SURE - 0.5, placed, grown), grown)


def _body_guess(x: np.ndarray, y: np.ndarray, crop: Crop, placed: np.ndarray) -> np.ndarray:
    """(h, w) GrabCut labels outside the crop: shoulders widen below it, hair and hats go on above it,
    nobody is far above or beside."""
    across = np.abs(x - crop.centre_x)[None, :] / crop.side
    below = (y - crop.window[3])[:, None] / crop.side
    guess = np.full((len(y), len(x)), cv2.GC_PR_BGD, np.uint8)
    guess[(below < -1.0) & (placed > 0.5)] = cv2.GC_PR_FGD
    guess[(across < 0.45 + np.clip(below + 0.15, 0.0, 0.6)) & (below > -0.15)] = cv2.GC_PR_FGD
    guess[(across < 0.2) & (below > 0.0) & (below < 1.0)] = cv2.GC_FGD
    guess[(across > 2.0) | (below < -1.35)] = cv2.GC_BGD
    return guess


def _continued(guide: np.ndarray, placed: np.ndarray, inside: np.ndarray, guess: np.ndarray) -> np.ndarray:
    """The mask after GrabCut, where colours allow it; else the crop's mask continued outward."""
    labels = np.where(placed > 0.5, cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
    labels[placed > _SURE] = cv2.GC_FGD
    labels[placed < 1.0 - _SURE] = cv2.GC_BGD
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
