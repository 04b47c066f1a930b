"""The person's matte (alpha), and the person's own colour (the foreground's, not premultiplied) where it is soft."""

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
from relight_core.imaging.resampling import resize_area, shrunk_size
from relight_core.imaging.view_transform import apply_view
from relight_core.pipeline.per_photo.brush import BrushStroke, painted
from relight_core.pipeline.per_photo.exposing import exposed
from relight_core.pipeline.per_photo.first_matte import SeenPeople, first_matte, first_matte_within
from relight_core.pipeline.per_photo.out_of_focus import softened
from relight_core.pipeline.per_photo.strands import Strands, strands_of
from relight_core.pipeline.per_photo.turned_photo import filled_corners

WORKING_PX = 1024
"""The longest side of the copy in which mattes are made."""

_FUSION_PX = 512
"""The longest side of the maps of both sides' mean colours."""
_NEAR_SHARE = 0.015
"""The deviation of the blur behind `Matte.nearby`, as a share of its longest side."""
_LEAST_OWN = 0.5
"""The share of the person's mean colour that each channel of their own colour has at the least."""
_EDGE_CODES = 3.0
"""Steps of the guide, in 255ths, that are an edge to the guided filter and no noise."""
_EDGE_WINDOWS = 128
"""The longest side of a picture over the radius of the guided filter that moves edges."""


@dataclass(frozen=True, eq=False)
class Matte:
    """How much of each pixel is person, and what colour that part has, at any resolution.

    Small maps from which the matte and the colour of any pixel of the photo are computed where they are needed, so
    that no full-size result has to be kept.

    Attributes:
        slope, level: (h, w): the matte is slope * guide + level, clipped to [0, 1], with the guide at the resolution
            that is asked for (see `guide_of`).
        person, behind: (k, l, 3) linear, mean colours of the foreground and the background around each place.
        nearby: (k, l) the matte averaged about each place.
        own_alpha: whether the photo's own alpha is the matte; then the maps say nothing.
        exposure: edges are looked for in the photo times this, see `exposure_about_faces`.
        inside: what of the photo, no longer than WORKING_PX, lies within a frame (see `photo_frame.inside_frame`);
            None where there is no frame.
        ends: the same in pixels of the photo, if that is longer; beyond it there is nobody but who is painted there.
        beyond: (h, w) in [0, 1], how much of a person is painted beyond it; None for nothing.
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


def guide_of(linear: np.ndarray) -> np.ndarray:
    """What the matte's edges follow: the square root of luminance, (..., 3) to (...), [0, 1]."""
    grey = np.clip(luminance(linear), 0.0, 1.0)
    return np.sqrt(grey, out=grey)


def own_colour(linear: np.ndarray, share: np.ndarray, person: np.ndarray, behind: np.ndarray) -> np.ndarray:
    """The person's own colour where the matte is soft (the foreground of the compositing equation).

    A pixel is a mix, by the matte, of the mean colours of both sides, plus a remainder; that is added to the person's
    mean colour in proportion to the matte. Two cases need more than that:

    - A pixel darker than both means is no mix of them, such as hair between skin and a wall where the matte is one
      half. Both means are dimmed first, until the darker one is as dark as the pixel; else clipping at 0 would leave
      the person nothing but the strongest channel.
    - Where a strand before a bright sky covers more of a pixel than the matte says, the remainder would take away all
      of the colour, or all but one channel. No channel falls below half of the person's mean, as far as the pixel
      holds so much.

    Args:
        linear: (h, w, 3), pixels of the photo.
        share: (h, w) the matte there, [0, 1].
        person, behind: (h, w, 3) linear, mean colours of the foreground and the background.

    Returns:
        (h, w, 3) linear, >= 0, not premultiplied; times the matte it is no brighter than the pixel. Where the matte is
        0 or 1, the pixels themselves.
    """
    soft = np.flatnonzero((share > 0.0) & (share < 1.0))
    if not soft.size:
        return linear
    alpha = share.ravel()[soft]
    mean, mixed, beside = (side.reshape(-1, 3)[soft] for side in (person, linear, behind))
    seen = np.maximum(luminance(mixed), np.finfo(np.float32).tiny)
    dimmed = seen / np.maximum(np.minimum(luminance(mean), luminance(beside)), seen)
    colour = linear.copy(order="C")
    # Channel by channel: numpy is slow at pixels times shares of pixels.
    for channel in range(3):
        at, of_person, of_behind = mixed[:, channel], dimmed * mean[:, channel], dimmed * beside[:, channel]
        remainder = at - alpha * of_person - (1.0 - alpha) * of_behind
        most = np.maximum(at, 0.0) / alpha
        own = np.clip(of_person + alpha * remainder, np.minimum(_LEAST_OWN * of_person, most), most)
        colour.reshape(-1, 3)[soft, channel] = own
    return colour


@dataclass(frozen=True, eq=False)
class DraftMatte:
    """What networks and colours say of a photo's people, before hands and edges do.

    Attributes:
        share: (h, w) in [0, 1].
        small: (h, w, 3) linear, the photo no longer than WORKING_PX.
        guide: (h, w, 3) the same as it is displayed, sRGB.
        photo_size: (height, width).
        exposure: the guide shows the photo times this, see `exposure_about_faces`.
        inside, ends: as of `Matte`; all of the share is there.
        strands: how much of it is hair about the outlines of hair; None where colours don't tell.
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
    """Carry coarse person masks to the whole photo; None where the photo's own alpha is the matte.

    The masks, a prior on bodies beyond their views, and colours say where a person probably is (`likely_person`);
    nothing is learnt from a frame's colours. Closed-form matting (Levin, Lischinski and Weiss 2008) makes a soft matte
    of that in a small copy; what is connected to nobody is taken out of it, and gaps within somebody are closed
    (`first_matte`). Strands of hair are separated from what is behind them (`strands`). Takes some tenths of a second,
    once per photo.

    Args:
        look: gives what networks see; not asked where the photo is cut out.
        small: the photo no longer than WORKING_PX, (h, w, 3) linear, where that is there already.
        exposure: edges are looked for in the photo times this, see `exposure_about_faces`.
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
    """What of a photo (H, W, 3) lies within a frame, of which cells of a `small` copy are `inside`."""
    size = linear.shape[:2]

    def shown(part: Inside) -> np.ndarray:
        rows, columns = part
        band = Band(rows.start, rows.stop, size, size, (columns.start, columns.stop))
        return apply_view(exposed(linear[part], exposure, band))

    return whole_inside(inside, small, size, shown)


def _within(
    inside: Inside | None, corners: np.ndarray | None, share: np.ndarray, beyond: np.ndarray | None = None
) -> np.ndarray:
    """A matte (h, w) that is 0 in a frame, and in the filled corners (h, w) of a turned photo.

    Args:
        beyond: (h, w) the matte in the frame, in place of 0.
    """
    if corners is not None:
        share = np.where(corners, np.float32(0), share)
    if inside is None:
        return share
    result = np.zeros_like(share) if beyond is None else beyond.copy()
    result[inside] = share[inside]
    return result


def finish_matte(draft: DraftMatte | None, strokes: Sequence[BrushStroke] = ()) -> Matte:
    """Let the strokes of a brush correct a draft, and move its edges onto the photo's.

    A guided filter (He, Sun and Tang 2013) does the latter, so that a stroke need not follow an edge to the pixel. A
    stroke thinner than the filter's window, which would average it away, stays where it was painted. Strands of hair
    are put in where nobody painted, and outlines that are out of focus end as softly as in the photo. The photo's own
    alpha, for which there is no draft, is left as it is.
    """
    if draft is None:
        nothing, black = np.zeros((1, 1), np.float32), np.zeros((1, 1, 3), np.float32)
        return Matte(nothing, nothing, black, black, nothing, True)
    small, guide = draft.small, draft.guide
    coarse = painted(draft.share, strokes, draft.photo_size)
    # Filters must not see a frame: somebody as white as it is would fade out across its edge.
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
        # Out of focus there is no finer edge to follow, but there is grain.
        slope, level = slope * (1 - out_of_focus), level + out_of_focus * (going_on_share - level)
        ends, beyond = draft.ends, _painted_beyond(draft.inside, share)
    fused = shrunk_size(draft.photo_size, _FUSION_PX)
    nearby = cv2.GaussianBlur(resize_area(share, fused), (0, 0), max(max(fused) * _NEAR_SHARE, 0.5))
    nearby = np.clip(nearby, 0.0, 1.0)
    found = slope, level, *_sides(small, share), nearby
    return Matte(*found, exposure=draft.exposure, inside=draft.inside, ends=ends, beyond=beyond)


def _painted_beyond(inside: Inside | None, share: np.ndarray) -> np.ndarray | None:
    """What of a matte (h, w) was painted into a frame, continued by one cell out of it; None for nothing."""
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
    """The painted matte (h, w), its edges moved onto those of the guide (h, w, 3), but for thin strokes."""
    window = max(round(max(guide.shape) / _EDGE_WINDOWS), 2)
    share = np.clip((_guided(guide, coarse, window) - 0.2) / 0.6, 0.0, 1.0)
    window_px = window * max(photo_size) / max(guide.shape)
    covered = [replace(stroke, adds=stroke.radius_px < window_px) for stroke in strokes]
    if not any(stroke.adds for stroke in covered):
        return share
    return share + painted(np.zeros_like(share), covered, photo_size) * (coarse - share)


def _going_on(inside: Inside | None, image: np.ndarray) -> np.ndarray:
    """A picture (h, w) or (h, w, 3) as if it went on beyond what lies within a frame, if there is one."""
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
    """Mean colours of person and background about each place, by blur fusion (Forte 2021, two passes)."""
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
    """Local means of either side, weighted by how much of each pixel it has."""
    window = (2 * radius + 1,) * 2
    means = []
    for colour, weight in ((foreground, share), (background, 1.0 - share)):
        total = cv2.blur(weight, window)[..., None]
        means.append(cv2.blur(colour * weight[..., None], window) / (total + 1e-5))
    return means[0], means[1]


def _guided(guide: np.ndarray, mask: np.ndarray, radius: int) -> np.ndarray:
    """Guided filter of a mask by an sRGB image. Both are finite: one NaN would spread over its window.

    The guide goes in as codes up to 255: with colours up to 1 OpenCV takes the covariance of any calm
    window for singular, and blurs.
    """
    codes = np.ascontiguousarray(guide * np.float32(255.0))
    return cv2.ximgproc.guidedFilter(codes, np.ascontiguousarray(mask, np.float32), radius, _EDGE_CODES**2)
