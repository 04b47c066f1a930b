"""The person's matte (alpha), and the mean colours of person and background about every place."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import cv2
import numpy as np

from relight_core.face.paste import Band, all_of
from relight_core.imaging.colour import luminance
from relight_core.imaging.photo import Photo
from relight_core.imaging.photo_frame import Inside, going_on, inside_frame, picture_cells, shrunk_inside, whole_inside
from relight_core.imaging.ramp import ramp
from relight_core.imaging.resampling import resize_area, shrunk_size
from relight_core.imaging.view_transform import apply_view
from relight_core.pipeline.per_photo.brush import BrushStroke, painted
from relight_core.pipeline.per_photo.exposing import exposed
from relight_core.pipeline.per_photo.first_matte import SeenPeople, first_matte, first_matte_within
from relight_core.pipeline.per_photo.out_of_focus import softened
from relight_core.pipeline.per_photo.strands import Strands, strands_of
from relight_core.pipeline.per_photo.turned_photo import filled_corners

WORKING_PX = 1024
"""Longer side of the copy in which mattes are made."""

_FUSION_PX = 512
"""Longer side of the maps of foreground and background colours."""
_NEAR_SHARE = 0.015
"""Standard deviation of the blur in `Matte.nearby`, as a share of its longer side."""
_CRISP_CELLS, _CRISP = 7, (0.7, 0.98)
"""By how much a matte changes within so many cells where its outline is perhaps, and surely, crisp."""
_EDGE_CODES = 3.0
"""Steps of the guide, in 255ths, from which on the guided filter sees an edge instead of noise."""
_EDGE_WINDOWS = 128
"""Longer side of a picture over the radius of the guided filter that moves edges."""


@dataclass(frozen=True, eq=False)
class Matte:
    """The matte and the foreground's colour at any resolution.

    It consists of small maps, from which both are computed for any pixel of the photo when they are needed, so that no
    full-size result has to be kept.

    Attributes:
        slope, level: (h, w): the matte is slope * guide + level, clipped to [0, 1], with the guide at the requested
            resolution (see `guide_of`).
        person, behind: (k, l, 3) linear, local mean colours of the foreground and the background.
        nearby: (k, l) the blurred matte.
        own_alpha: the photo's own alpha is the matte; then the maps are unused.
        exposure: the guide is that of the photo times this, see `exposure_about_faces`.
        inside: the part of the photo within its frame (see `photo_frame.inside_frame`), in cells of the copy with a
            longer side of at most WORKING_PX; None if there is no frame.
        ends: the same in pixels of the photo, if the photo is longer. Outside there is only what was painted there.
        beyond: (h, w) in [0, 1], the matte painted outside; None for nothing.
        crisp: (h, w) in [0, 1], how surely the outline is as narrow as that of a thing in focus; None for nowhere.
    """

    slope: np.ndarray
    level: np.ndarray
    person: np.ndarray
    behind: np.ndarray
    nearby: np.ndarray
    own_alpha: bool = False
    exposure: float | np.ndarray = 1.0
    inside: Inside | None = None
    ends: Inside | None = None
    beyond: np.ndarray | None = None
    crisp: np.ndarray | None = None


def guide_of(linear: np.ndarray) -> np.ndarray:
    """The guide, whose edges the matte follows: the square root of luminance, (..., 3) to (...), [0, 1]."""
    grey = np.clip(luminance(linear), 0.0, 1.0)
    return np.sqrt(grey, out=grey)


@dataclass(frozen=True, eq=False)
class DraftMatte:
    """The matte from networks and colours, before the user's strokes and the photo's edges refine it.

    Attributes:
        share: (h, w) in [0, 1], the matte.
        small: (h, w, 3) linear, a copy of the photo with a longer side of at most WORKING_PX.
        guide: (h, w, 3) the copy as it is displayed, sRGB.
        photo_size: (height, width).
        exposure: the guide is that of the photo times this, see `exposure_about_faces`.
        inside, ends: as of `Matte`; the share is 0 outside.
        strands: the matte along the outlines of hair; None if colours don't tell.
    """

    share: np.ndarray
    small: np.ndarray
    guide: np.ndarray
    photo_size: tuple[int, int]
    exposure: float | np.ndarray = 1.0
    inside: Inside | None = None
    strands: Strands | None = None
    ends: Inside | None = None


def draft_matte(
    photo: Photo,
    look: Callable[[], SeenPeople],
    small: np.ndarray | None = None,
    exposure: float | np.ndarray = 1.0,
) -> DraftMatte | None:
    """Make a first matte of the whole photo from the networks' looks, which takes some tenths of a second.

    1. The looks, a prior on bodies beyond them, and colours give a probability of person (`likely_person`). A frame
       around the picture is left out, so that its colours aren't learnt.
    2. In a small copy, closed-form matting (Levin, Lischinski and Weiss 2008) turns it into a soft matte. What isn't
       connected to anybody is removed, and gaps within a person are closed (`first_matte`).
    3. Strands of hair are separated from what is behind them (`strands`).

    Args:
        photo: to be matted.
        look: makes the networks' looks; not called if the photo is cut out.
        small: a copy of the photo with a longer side of at most WORKING_PX, (h, w, 3) linear, if there is one already.
        exposure: the guide is that of the photo times this, see `exposure_about_faces`.

    Returns:
        None if the photo is cut out, so that its own alpha is the matte.
    """
    if photo.is_cut_out:
        return None
    seen, linear, size = look(), photo.linear, photo.linear.shape[:2]
    small = resize_area(linear, shrunk_size(size, WORKING_PX)) if small is None else small
    guide = np.ascontiguousarray(apply_view(exposed(small, exposure, all_of(small.shape[:2], size))))
    inside = inside_frame(guide)
    if photo.picture == (0, 0, size[1], size[0]):
        share = first_matte(guide, seen, size)
    else:
        cells = picture_cells(photo.picture, size, guide.shape[:2])
        share = first_matte_within(cells, guide, seen, size)
        inside = cells if inside is None else inside
    ends = None if inside is None else _ends(linear, exposure, inside, guide.shape[:2])
    inside = None if ends is None else shrunk_inside(ends, size, guide.shape[:2])
    share = _within(inside, filled_corners(guide), share)
    strands = strands_of(guide, share, seen.hair, size, inside)
    return DraftMatte(share, small, guide, size, exposure, inside, strands, ends)


def _ends(linear: np.ndarray, exposure: float | np.ndarray, inside: Inside, small: tuple[int, int]) -> Inside:
    """The part of a photo (H, W, 3) within its frame, to the pixel, from its cells in a copy of the size `small`."""
    size = linear.shape[:2]

    def shown(part: Inside) -> np.ndarray:
        rows, columns = part
        band = Band(rows.start, rows.stop, size, size, (columns.start, columns.stop))
        return apply_view(exposed(linear[part], exposure, band))

    return whole_inside(inside, small, size, shown)


def _within(
    inside: Inside | None, corners: np.ndarray | None, share: np.ndarray, beyond: np.ndarray | None = None
) -> np.ndarray:
    """A matte (h, w) that is 0 in a frame, and in the filled corners (h, w) of a rotated photo.

    Args:
        inside: the cells within the frame, if there is one.
        corners: (h, w) bool, if there are any.
        share: (h, w) the matte.
        beyond: (h, w) the matte to use in the frame instead of 0.
    """
    if corners is not None:
        share = np.where(corners, np.float32(0), share)
    if inside is None:
        return share
    result = np.zeros_like(share) if beyond is None else beyond.copy()
    result[inside] = share[inside]
    return result


def finish_matte(draft: DraftMatte | None, strokes: Sequence[BrushStroke] = ()) -> Matte:
    """Correct a draft by brush strokes, and move its edges onto the photo's.

    The edges are moved by a guided filter (He, Sun and Tang 2013), so that a stroke need not follow an edge to the
    pixel. Strokes thinner than the filter's window, which would average them away, stay where they were painted.
    Strands of hair are inserted where nothing was painted, and outlines that are out of focus get as soft as in the
    photo.

    Args:
        draft: None if the photo's own alpha is the matte, which stays as it is.
        strokes: of the user.
    """
    if draft is None:
        nothing, black = np.zeros((1, 1), np.float32), np.zeros((1, 1, 3), np.float32)
        return Matte(nothing, nothing, black, black, nothing, True)
    small, guide = draft.small, draft.guide
    coarse = painted(draft.share, strokes, draft.photo_size)
    # The filters must not see a frame: a person as white as the frame would fade out across its edge.
    go_on = partial(_going_on, draft.inside)
    share = _on_edges(go_on(guide), go_on(coarse), strokes, draft.photo_size)
    share = _within(draft.inside, None, share, coarse)
    if draft.strands is not None:
        by_hand = [replace(stroke, adds=True) for stroke in strokes]
        share = draft.strands.put_into(share, painted(np.zeros_like(share), by_hand, draft.photo_size))
    seen = go_on(guide_of(exposed(small, draft.exposure, all_of(small.shape[:2], draft.photo_size))))
    soft, out_of_focus = softened(go_on(share), seen)
    share = _within(draft.inside, None, soft, share)
    slope, level, ends, beyond = np.zeros_like(share), share, None, None
    if guide.shape[:2] != draft.photo_size:
        going_on_share = go_on(share)
        slope, level = _guided_coefficients(seen, going_on_share)
        # Where the outline is out of focus, the photo has no finer edge to follow, only grain.
        slope, level = slope * (1 - out_of_focus), level + out_of_focus * (going_on_share - level)
        ends, beyond = draft.ends, _painted_beyond(draft.inside, share)
    fused = shrunk_size(draft.photo_size, _FUSION_PX)
    nearby = cv2.GaussianBlur(resize_area(share, fused), (0, 0), max(max(fused) * _NEAR_SHARE, 0.5))
    nearby = np.clip(nearby, 0.0, 1.0)
    found = slope, level, *_sides(small, share), nearby
    where = {"inside": draft.inside, "ends": ends, "beyond": beyond}
    return Matte(*found, exposure=draft.exposure, crisp=_crispness(share), **where)


def _crispness(share: np.ndarray) -> np.ndarray:
    """How surely a matte (h, w) goes from nothing to all within a few cells, [0, 1]."""
    window = np.ones((_CRISP_CELLS, _CRISP_CELLS), np.uint8)
    return ramp(cv2.dilate(share, window) - cv2.erode(share, window), *_CRISP)


def _painted_beyond(inside: Inside | None, share: np.ndarray) -> np.ndarray | None:
    """The part of a matte (h, w) that was painted into a frame, continued by one cell out of it; None for nothing."""
    if inside is None:
        return None
    beyond = share.copy()
    beyond[inside] = 0
    if not beyond.any():
        return None
    beyond[inside] = cv2.dilate(beyond, np.ones((3, 3), np.uint8))[inside]
    return beyond


def _on_edges(
    guide: np.ndarray, coarse: np.ndarray, strokes: Sequence[BrushStroke], photo_size: tuple[int, int]
) -> np.ndarray:
    """The painted matte (h, w) with its edges moved onto those of the guide (h, w, 3), except in thin strokes."""
    window = max(round(max(guide.shape) / _EDGE_WINDOWS), 2)
    share = np.clip((_guided(guide, coarse, window) - 0.2) / 0.6, 0.0, 1.0)
    window_px = window * max(photo_size) / max(guide.shape)
    covered = [replace(stroke, adds=stroke.radius_px < window_px) for stroke in strokes]
    if not any(stroke.adds for stroke in covered):
        return share
    return share + painted(np.zeros_like(share), covered, photo_size) * (coarse - share)


def _going_on(inside: Inside | None, image: np.ndarray) -> np.ndarray:
    """A picture (h, w) or (h, w, 3) in which a frame, if there is one, is replaced by a continuation of the inside."""
    return image if inside is None else going_on(image[inside], inside, image.shape[:2])


def _guided_coefficients(guide: np.ndarray, mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Slope and level of the fast guided filter (He and Sun 2015) in windows of 5 x 5."""

    def mean(image: np.ndarray) -> np.ndarray:
        return cv2.blur(image, (5, 5), borderType=cv2.BORDER_REFLECT)

    mean_guide, mean_mask = mean(guide), mean(mask)
    variance = np.maximum(mean(guide * guide) - mean_guide**2, 0.0)
    slope = (mean(guide * mask) - mean_guide * mean_mask) / (variance + (_EDGE_CODES / 255) ** 2)
    return mean(slope), mean(mean_mask - slope * mean_guide)


def _sides(image: np.ndarray, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Local mean colours of person and background, by blur fusion (Forte 2021, two passes)."""
    size = shrunk_size(share.shape, _FUSION_PX)
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
    """Local means of both sides' colours, weighted by the matte (h, w) and by one minus it."""
    window = (2 * radius + 1,) * 2
    means = []
    for colour, weight in ((foreground, share), (background, 1.0 - share)):
        total = cv2.blur(weight, window)[..., None]
        means.append(cv2.blur(colour * weight[..., None], window) / (total + 1e-5))
    return means[0], means[1]


def _guided(guide: np.ndarray, mask: np.ndarray, radius: int) -> np.ndarray:
    """Guided filter of a mask by an sRGB image. Both must be finite, since a NaN would spread over its window.

    The guide is scaled to codes up to 255: with colours up to 1 OpenCV takes the covariance of any smooth window to be
    singular, and blurs.
    """
    codes = np.ascontiguousarray(guide * np.float32(255.0))
    return cv2.ximgproc.guidedFilter(codes, np.ascontiguousarray(mask, np.float32), radius, _EDGE_CODES**2)
