"""From relit views to a finished picture: which view counts where, and what the rest of the person gets."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import torch

from relight_core.face.crop import Crop
from relight_core.face.paste import all_of, fade, places_of, seen_across, seen_from, spread_crop, whole_photo
from relight_core.imaging.colour import luminance
from relight_core.imaging.photo_frame import shrunk_inside
from relight_core.imaging.ramp import ramp
from relight_core.imaging.resampling import resize_area, resize_smooth, shrunk_size
from relight_core.imaging.tone import Tone
from relight_core.lighting.reflection import ReflectionTable
from relight_core.pipeline.per_light.catchlights import Catchlight
from relight_core.pipeline.per_light.rest_of_person import Body, body_gain, body_size, make_body
from relight_core.pipeline.per_photo.brush import BrushStroke, painted
from relight_core.pipeline.per_photo.matte import Matte
from relight_core.pipeline.per_photo.person import Canvas, shrunk, whole_person
from relight_core.pipeline.results.channels import ViewChange, at_level
from relight_core.pipeline.results.picture import PlacedCatchlight, PlacedChange

_EDGE_SHARE = 0.12
"""Share of a view's side over which it fades toward its edge."""
_WEIGHT_LONGEST = 512
"""Longer side of the maps that say over the whole photo which view counts where."""
_OUTLINE_SHARE, _UNSEEN_BLUR_SHARE = 0.02, 0.01
"""By how much of its side a person's mask is grown before what a brush added beside it counts as unseen, and the
deviation of the blur of that, as a share of its map's longer side."""
_UNSEEN_FROM, _UNSEEN_TO = 0.3, 0.7
"""What a brush added beyond the masks, in [0, 1], from which on it counts as unseen, in part and altogether."""


@dataclass(frozen=True)
class PhotoProperties:
    """What is known of a whole photo before any of its faces is relit.

    Attributes:
        exposure: of the portrait; of the photo times this, skin and cloth are as bright as their colours.
        tone: of the photo times the exposure, where it is toned; None for a photo in colours or without any.
        picture: x0, y0, x1, y1 of what of the photo no frame covers, in its pixels, toward whose borders views hardly
            fade; None is all of it.
    """

    exposure: float = 1.0
    tone: Tone | None = None
    picture: tuple[float, float, float, float] | None = None

    def picture_in(self, photo_size: tuple[int, int]) -> tuple[float, float, float, float]:
        """The window of the picture in a photo of (height, width), also where no frame is around it."""
        return whole_photo(photo_size) if self.picture is None else self.picture


@dataclass(frozen=True, eq=False)
class Placement:
    """Where every face's view counts, and the body around them; once per photo.

    Attributes:
        views: of the faces.
        people: who is who, for each view a mask (S, S) in [0, 1] and where it lies; none where that isn't known.
        small: (h, w, 1) for each, how much it counts over the whole photo, at the size of the body's photo; they sum
            to at most 1.
        body: what no view covers; its photo is the photo times the exposure.
        photo_size: (height, width).
        photo: what is known of the photo.
        unseen: (k, l) over the whole photo, in [0, 1]: people that no network takes for them; None for nobody.
    """

    views: tuple[Crop, ...]
    people: tuple[tuple[np.ndarray, Crop], ...]
    small: tuple[np.ndarray, ...]
    body: Body
    photo_size: tuple[int, int]
    photo: PhotoProperties
    unseen: np.ndarray | None = None


def place_views(
    canvas: Canvas,
    views: Sequence[Crop],
    matte: Matte,
    table: ReflectionTable,
    people: Sequence[tuple[np.ndarray, Crop]] = (),
    strokes: Sequence[BrushStroke] = (),
    photo: PhotoProperties = PhotoProperties(),
) -> Placement:
    """Decide how much each face's view counts at each place of the photo, and guess the body beyond the views.

    Where the brush added a part of a person that the networks took for background, they know no shape of it: no view
    counts there, and it is lit as the rest of the person is.

    Args:
        canvas: all of the photo, at any size.
        table: what open surfaces reflect, for the body.
        people: as `Placement` has them.
        strokes: of the brush, in the matte already.
        photo: what is known of it.
    """
    photo_size = canvas.photo_size
    places = places_of(shrunk_size(photo_size, _WEIGHT_LONGEST), photo_size)
    unseen = _unseen(strokes, people, places, photo_size)
    picture = photo.picture_in(photo_size)
    weights = _weights_at(views, people, _unseen_at(unseen, places, photo_size), places, picture)
    small = shrunk(canvas, max(body_size(photo_size)))
    known = resize_area(np.minimum(sum(weights), 1), small.size)
    share = whole_person(small, matte).share
    seen = np.where(share[..., None] > 0, small.linear, 0) if matte.own_alpha else small.linear
    cells = None if matte.inside is None else shrunk_inside(matte.inside, canvas.size, share.shape)
    body = make_body(seen * np.float32(photo.exposure), share, known, table, cells)
    of_views = tuple(resize_area(weight, body.photo.shape[:2])[..., None] for weight in weights)
    return Placement(tuple(views), tuple(people), of_views, body, photo_size, photo, unseen)


@dataclass(frozen=True, eq=False)
class ViewWeights:
    """How much each view counts at every place of one of them; (S, S, 1) each, None where it counts nowhere."""

    of_views: tuple[np.ndarray | None, ...]
    of_rest: np.ndarray | None


def weights_on_views(placement: Placement, size: int) -> tuple[ViewWeights, ...]:
    """For each view, the weights of all of them on its own maps of `size` pixels."""
    return less_where_unseen(placement, weights_if_all_are_seen(placement, size), size)


def weights_if_all_are_seen(placement: Placement, size: int) -> tuple[ViewWeights, ...]:
    """As `weights_on_views`, without what a brush has changed."""
    return tuple(_weights_on(placement, view, _places_on(view, size)) for view in placement.views)


def less_where_unseen(placement: Placement, weights: tuple[ViewWeights, ...], size: int) -> tuple[ViewWeights, ...]:
    """The weights of `weights_if_all_are_seen` where some people are unseen; only views that hold some of them change.

    Nothing changes where a placement has nobody unseen.
    """
    if placement.unseen is None:
        return weights

    def on(view: Crop, known: ViewWeights) -> ViewWeights:
        places = _places_on(view, size)
        unseen = _unseen_at(placement.unseen, places, placement.photo_size)
        return _weights_on(placement, view, places, unseen) if unseen.any() else known

    return tuple(map(on, placement.views, weights))


def placed(
    placement: Placement, weights: Sequence[ViewWeights], changes: Sequence[ViewChange], rest: np.ndarray
) -> tuple[PlacedChange, ...]:
    """The faces' changes at their places, mixed with each other's and with the rest's where they meet.

    Args:
        weights: of `weights_on_views`, at the size of the changes' maps.
        rest: (h, w, 3) gain over the whole photo.
    """
    if len(changes) == 1 and weights[0].of_rest is None:
        return (PlacedChange(changes[0].gain, changes[0].offset, placement.views[0]),)
    # Getting memory for what is gone in a moment takes longer than the arithmetic.
    room = np.empty((2, *changes[0].gain.shape), np.float32)
    return tuple(_mixed(placement, index, weights[index], changes, rest, room) for index in range(len(changes)))


def gain_of_rest(
    placement: Placement, changes: Sequence[ViewChange], light: torch.Tensor, in_photo: np.ndarray | None = None
) -> np.ndarray:
    """Gain (h, w, 3) over the whole photo for what no view covers, at the light's level.

    Args:
        light: (1, 16, 32, 3) normalised.
        in_photo: the body's shading in the photo, see `body_gain`.
    """
    body, exposure, level = placement.body, np.float32(placement.photo.exposure), max(changes[0].level, 1e-30)
    size = body.photo.shape[:2]
    if changes[0].level == 0:
        return np.zeros((*body.share.shape, 3), np.float32)
    relit, total = np.zeros_like(body.photo), np.zeros((*size, 1), np.float32)
    for change, view, share in zip(changes, placement.views, placement.small, strict=True):
        gain, offset = (_coarse(part, view, size, placement.photo_size) for part in (change.gain, change.offset))
        relit += share * (gain / exposure * body.photo + offset)
        total += share
    relit = relit / np.maximum(total, 1e-6) / np.float32(level)
    if placement.photo.tone is None:
        return at_level(exposure * body_gain(body, light, relit, in_photo), level)
    relit = body.photo * (luminance(relit) / np.maximum(luminance(body.photo), 1e-6))[..., None]
    gain = body_gain(body, light, relit, in_photo)
    before = luminance(resize_smooth(body.photo, gain.shape[:2]))
    turned = placement.photo.tone.turned(before, before * luminance(gain) * np.float32(level))
    return at_level(exposure * gain * turned, level)


def place_changes(
    placement: Placement,
    weights: Sequence[ViewWeights],
    changes: Sequence[ViewChange],
    light: torch.Tensor,
    in_photo: np.ndarray | None = None,
) -> tuple[np.ndarray, tuple[PlacedChange, ...]]:
    """`gain_of_rest` and `placed`."""
    rest = gain_of_rest(placement, changes, light, in_photo)
    return rest, placed(placement, weights, changes, rest)


def place_catchlights(
    catchlights: Sequence[Sequence[Catchlight]],
    changes: Sequence[PlacedChange],
    gloss: np.ndarray,
    monochrome: Sequence[bool],
) -> tuple[PlacedCatchlight, ...]:
    """The eyes of every face on top of its change; `gloss` and `monochrome` as `Catchlight.times` has them."""

    def place(one: Catchlight, change: PlacedChange, is_grey: bool) -> PlacedCatchlight:
        one, view = one.times(gloss, is_grey), one.cornea.view
        return PlacedCatchlight(one.change(seen_across(view, len(one.mirrored), change.gain, change.view)), view)

    faces = zip(catchlights, changes, monochrome, strict=True)
    return tuple(place(one, change, is_grey) for eyes, change, is_grey in faces for one in eyes)


def mean_gain(placement: Placement, rest: np.ndarray) -> np.ndarray:
    """(3,) by how much the person changes, as a geometric mean."""
    weight, exposure = placement.body.share[..., None] + 1e-6, np.float32(placement.photo.exposure)
    return exposure * np.exp((np.log(rest / exposure + 1e-6) * weight).sum((0, 1)) / weight.sum((0, 1)))


def _places_on(view: Crop, size: int) -> np.ndarray:
    """(size, size, 2) places in the photo of a view's own pixels."""
    return view.to_photo(places_of((size, size), (size, size)), size)


def _weights_on(placement: Placement, view: Crop, places: np.ndarray, unseen: np.ndarray | None = None) -> ViewWeights:
    """The weights at a view's own pixels, as of `_weights_at`: a small view's edge is finer than the photo's maps."""
    near = _near(placement, view)
    views = [placement.views[index] for index in near]
    people = [placement.people[index] for index in near] if placement.people else []
    weights = _weights_at(views, people, unseen, places, placement.photo.picture_in(placement.photo_size))
    of_rest = 1 - np.minimum(sum(weight[..., None] for weight in weights), 1)
    of_views = {index: weight[..., None] for index, weight in zip(near, weights, strict=True) if weight.any()}
    return ViewWeights(
        tuple(of_views.get(index) for index in range(len(placement.views))),
        of_rest if of_rest.max() > 1e-6 else None,
    )


def _near(placement: Placement, view: Crop) -> list[int]:
    """Which views count, or have a person, at any place of a view: in a crowd few do, and each asks all others."""
    people = placement.people or [()] * len(placement.views)
    return [
        index
        for index, (other, person) in enumerate(zip(placement.views, people, strict=True))
        if any(_may_meet(view, crop) for crop in (other, *person[1:]))
    ]


def _may_meet(one: Crop, other: Crop) -> bool:
    """Whether two squares can have a place in common, whichever way they are turned."""
    apart = math.hypot(one.centre_x - other.centre_x, one.centre_y - other.centre_y)
    return apart <= (one.side + other.side) / math.sqrt(2)


def _mixed(
    placement: Placement,
    index: int,
    weights: ViewWeights,
    changes: Sequence[ViewChange],
    rest: np.ndarray,
    room: np.ndarray,
) -> PlacedChange:
    """One view's change where others or the rest count too; `room` is (2, S, S, 3) float32 to work in."""
    view, size = placement.views[index], changes[index].gain.shape[0]
    gain, offset = np.zeros((2, size, size, 3), np.float32)
    seen, spread = room

    def add(total: np.ndarray, part: np.ndarray) -> None:
        total += cv2.multiply(part, spread, dst=seen)

    for other, (change, weight) in enumerate(zip(changes, weights.of_views, strict=True)):
        if weight is None:
            continue
        # NumPy multiplies by a weight of one channel three times as slowly.
        cv2.merge([weight] * 3, spread)
        for total, part in ((gain, change.gain), (offset, change.offset)):
            add(total, part if other == index else seen_across(view, size, part, placement.views[other], seen))
    if weights.of_rest is not None:
        cv2.merge([weights.of_rest] * 3, spread)
        add(gain, seen_from(view, size, rest, placement.photo_size, seen))
    return PlacedChange(gain, offset, view)


def _coarse(maps: np.ndarray, view: Crop, size: tuple[int, int], photo_size: tuple[int, int]) -> np.ndarray:
    """A view's maps on the body's grid, averaged as far as that is coarser. (h, w, 3)."""
    longest = max(size)
    shrunk = resize_area(maps, (min(len(maps), longest),) * 2)
    return spread_crop(shrunk, view, all_of(size, photo_size))


def _weights_at(
    views: Sequence[Crop],
    people: Sequence[tuple[np.ndarray, Crop]],
    unseen: np.ndarray | None,
    places: np.ndarray,
    picture: tuple[float, float, float, float],
) -> tuple[np.ndarray, ...]:
    """How much each view counts at places (k, l, 2) of the photo: (k, l) each, together at most 1.

    Args:
        unseen: (k, l) in [0, 1], people that no network takes for them.
    """
    fading, nearness = zip(*(_weight(view, places, picture) for view in views), strict=True)
    if unseen is not None:
        fading = [counts * (1 - unseen) for counts in fading]
    if len(views) == 1:
        return tuple(fading)
    if people:
        fading = _but_not_for_others(fading, [_mask_at(mask, crop, places) for mask, crop in people])
    total = np.maximum(sum(f * n for f, n in zip(fading, nearness, strict=True)), 1e-20)
    together = np.maximum.reduce(fading)
    return tuple((f * n / total * together).astype(np.float32) for f, n in zip(fading, nearness, strict=True))


def _but_not_for_others(fading: Sequence[np.ndarray], own: Sequence[np.ndarray]) -> list[np.ndarray]:
    """A view counts for nobody but its own person, where it is known whose place it is; all (k, l).

    To the networks a neighbour is background, of which they have learnt to say nothing.
    """
    result = []
    for index, (counts, mine) in enumerate(zip(fading, own, strict=True)):
        others = np.maximum.reduce([*own[:index], *own[index + 1 :]])
        result.append(counts * (1 - others * (1 - mine)))
    return result


def _unseen(
    strokes: Sequence[BrushStroke],
    people: Sequence[tuple[np.ndarray, Crop]],
    places: np.ndarray,
    photo_size: tuple[int, int],
) -> np.ndarray | None:
    """(k, l) as `Placement` has it, at places (k, l, 2) all over the photo."""
    if not any(stroke.adds for stroke in strokes):
        return None
    added = painted(np.zeros(places.shape[:2], np.float32), strokes, photo_size)
    seen = np.zeros_like(added)
    for mask, crop in people:
        reach = round(_OUTLINE_SHARE * len(mask))
        # Outlines are off by some pixels anyway.
        grown = cv2.dilate(np.asarray(mask, np.float32), np.ones((2 * reach + 1,) * 2, np.uint8))
        seen = np.maximum(seen, _mask_at(grown, crop, places))
    unseen = ramp(added * (1 - seen), _UNSEEN_FROM, _UNSEEN_TO)
    return cv2.GaussianBlur(unseen, (0, 0), max(_UNSEEN_BLUR_SHARE * max(unseen.shape), 0.5))


def _unseen_at(unseen: np.ndarray | None, places: np.ndarray, photo_size: tuple[int, int]) -> np.ndarray | None:
    """A placement's `unseen` at places (k, l, 2) of the photo, (k, l)."""
    if unseen is None:
        return None
    at = (places * (np.array(unseen.shape) / photo_size)[::-1] - 0.5).astype(np.float32)
    return cv2.remap(unseen, at, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def _mask_at(mask: np.ndarray, crop: Crop, places: np.ndarray) -> np.ndarray:
    """A person's mask at places (k, l, 2) of the photo, (k, l); 0 beyond it."""
    at = (crop.from_photo(places, len(mask)) - 0.5).astype(np.float32)
    return cv2.remap(np.asarray(mask, np.float32), at, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)


def _weight(
    view: Crop, places: np.ndarray, picture: tuple[float, float, float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """How far a view counts at all, and how near its middle each place is; (k, l) each.

    The less rest there is between a view and the picture's own border, the less of the view fades.
    """
    across, down = np.moveaxis(view.from_photo(places, 1), -1, 0)
    (x0, y0, x1, y1), (left, top, right, bottom) = view.window, picture
    beyond = [] if view.roll_deg else [gap / view.side for gap in (x0 - left, right - x1, y0 - top, bottom - y1)]
    fading = fade(across, _EDGE_SHARE, *beyond[:2]) * fade(down, _EDGE_SHARE, *beyond[2:])
    nearness = 1 / (0.05 + np.hypot(across - 0.5, down - 0.5))
    # Its fourth power: NumPy's own takes four times as long.
    return fading.astype(np.float32), np.square(np.square(nearness))
