"""The probability that a pixel of a photo belongs to a person, from three sources.

Within the views that networks looked at, it is what they say. Beyond, a prior on where bodies go on below and beside
a head takes their place. Both are then corrected by colour: by how common a pixel's colour is among what is surely a
person and among what is surely not.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import cv2
import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.paste import across_and_down, all_of, spread_crop
from relight_core.face.person_view import upright
from relight_core.imaging.colour_counts import bins_of, log_odds, shares_of
from relight_core.imaging.masks import largest_part
from relight_core.imaging.ramp import ramp

_SURELY_BODY, _PROBABLY_BODY, _PERHAPS_BODY, _NOBODY = 0.97, 0.6, 0.2, 0.02
"""Prior probabilities of person beyond the nearest look (see `_around`)."""
_BESIDE_LEGS = 0.05
"""The largest prior beside the legs."""
_LEGS_HALF_WIDTH = (0.1, 0.45)
"""How far from the view's middle, in its sides, legs surely are, and surely end."""
_HIPS, _KNEES, _BELOW_FEET = 0.5, 1.2, 2.4
"""Heights below the view's lower edge, in its sides."""

_LEAST, _TINY = 0.01, 1e-20
"""The least probability, so that log odds stay finite, and what is added to a divisor that may be 0."""
_SURE_FROM = 0.7
"""The probability from which on a mask is sure, of person or of background."""
_NO_GAP_FROM = 0.5
"""The mask's probability from which on a gap in the matte may be closed; from `_SURE_FROM` on it is."""

_ENCLOSED, _HALF_ENCLOSED = 0.3, 0.15
"""Alphas of the matte without its holes above which a place lies within a person, and within a soft outline."""
_WHOLE = 0.9
"""The alpha below which a place within a person counts as a gap."""
_LEAST_GAP_PX = 12
"""Pixels of the smallest gap that is looked at."""
_DEEP, _DEEP_SHARE = 0.05, 0.16
"""By how much a pixel of a gap is below what encloses it, and the share of the gap's pixels of which that must hold."""
_RIM = np.ones((5, 5), np.uint8)
"""The soft edge of an outline, which is no gap."""
_ABOUT, _LEAST_ABOUT_PX = 2.0, 12
"""How far around a gap the person's colours are learnt, in roots of its area, and in pixels at the least."""
_PERHAPS_ALIKE, _SURELY_ALIKE = 2.0, 3.0
"""Mean log odds of a gap's colours, of the person around it over the background, from which on it is partly closed,
and wholly."""

_MOST_COLOURS_SAY, _MOST_FROM_AFAR = 2.0, 4.0
"""By how much colours may change log odds within the nearest looks, and, against the person, beyond them."""
_NOBODYS = (3.5, 5.0)
"""Log odds against the person from which on a colour is rare on them, and next to absent."""
_DOUBTFUL = (3.0, 3.5)
"""Log odds of a mask up to which it is in doubt, and from which on it is not."""
_MOST_OF_NOBODYS = 6.0
"""By how much colours that are absent from the person may change log odds where the mask is in doubt. To networks hair
is solid: a blown-out wall between two curls would be relit as a grey haze. They are less sure of it than of a white
collar before that wall."""
_LEFT_BY_COLOURS = (0.05, 0.2)
"""Probabilities of person after colours were heard up to which a gap stays open whatever the mask says, and from which
on the mask decides."""
_ROUNDS = 2
"""How often colours are learnt anew from what they have decided."""
_GROWN_AT_ONCE = 8
"""Steps of a reconstruction between two looks whether it still grows."""
_PERHAPS_FACE, _SURELY_FACE = 0.5, 0.9

_DOUBTED, _DENIED, _SUREST = 1.0, 2.0, 0.002
"""Log odds for a person, and against one, that a wider look must exceed to count, and the least probability it may say.
Faces are smaller there than those the person network was trained on: it knows bodies and what lies behind them, but
doubts what people hold."""
_AT_MOST_BESIDE = 0.35
"""The largest probability that a wider look may give to what lies beside a head or above it: there the network takes
things along, and colours decide."""
_MIDDLE, _NEARNESS_POWER = 0.05, 4
"""A claim to a place weakens with this power of its distance from the middle of a look plus the first, in the look's
sides."""

Look = tuple[np.ndarray, Crop]
"""(S, S) probability in [0, 1] that the pixels of a view are a person, and where in the photo the view lies."""


def place_masks(
    people: Sequence[list[Look]],
    size: tuple[int, int],
    photo_size: tuple[int, int],
    others: Sequence[list[Look]] = (),
) -> list[np.ndarray]:
    """Each person's probability over the whole photo: what the looks at them say, and a prior on bodies beyond.

    Two rules hold between neighbours. Where a person has only the weak prior, and another person's nearest look sees
    the place, it is nobody's: else a lamp between two heads would stay in doubt as a part of everyone whose looks end
    before it. And where `others` are as likely, a place belongs to whoever's look has it nearer its middle: to the
    person network an arm or a shirt that a neighbour rests against may belong to both.

    Args:
        people: looks at each, from the nearest to the widest; what is not finite or out of range is brought into it.
            Beyond the nearest the prior holds, corrected by the wider ones.
        size: (h, w) of the result.
        photo_size: (height, width).
        others: looks at people who are not to be relit.

    Returns:
        (h, w) float32 in [0, 1] for each of the people.
    """
    placed = [_placed(looks, size, photo_size) for looks in people]
    if len(people) + len(others) > 1:
        near = near_views([*people, *others], size, photo_size)
        for mask, looks in zip(placed, people, strict=True):
            _leave_to_others(mask, looks, near, photo_size)
    if not others:
        return placed
    theirs = sum(_placed(looks, size, photo_size) * _nearness(looks, size, photo_size) for looks in others)
    own = [_nearness(looks, size, photo_size) for looks in people]
    return [mask * (mask * mine / (mask * mine + theirs + _TINY)) for mask, mine in zip(placed, own, strict=True)]


def place_faces(faces: Iterable[Look], size: tuple[int, int], photo_size: tuple[int, int]) -> np.ndarray:
    """Probability (h, w) in [0, 1] that a place of a photo is somebody's face; sizes as for `place_masks`."""
    whole, result = all_of(size, photo_size), np.zeros(size, np.float32)
    for face, view in faces:
        seen = spread_crop(_in_range(face), view, whole)
        result = np.maximum(result, np.where(_inside(view, size, photo_size), seen, 0))
    return result


def near_views(people: Sequence[list[Look]], size: tuple[int, int], photo_size: tuple[int, int]) -> np.ndarray:
    """Which places (h, w) of a photo, true or false, lie in somebody's nearest look; arguments as of `place_masks`."""
    seen = (_inside(looks[0][1], size, photo_size) for looks in people)
    return np.logical_or.reduce([np.zeros(size, bool), *seen])


def likely_person(
    guide: np.ndarray, placed: list[np.ndarray], face: np.ndarray | None = None, near: np.ndarray | None = None
) -> np.ndarray:
    """Probability of person over a whole photo: the masks, corrected by colour.

    How much colours may say differs. In a face, which networks know by its shape, they say nothing against the person:
    a nose before a wall of the colour of skin stays a nose. Beyond the nearest looks they say more than within: a wall
    that a wider look takes for a lap has the colours of the wall behind the shoulders. Within, they say most where the
    masks are in doubt and hardly anything on the person has such a colour.

    Args:
        guide: (h, w, 3) sRGB in [0, 1], a small copy of the photo.
        placed: masks of that size (see `place_masks`).
        face: (h, w) probability of a face, of that size (see `place_faces`); None where nobody's is known.
        near: (h, w) in [0, 1], of that size: what is seen in the nearest looks (see `near_views`). Colours are learnt
            there alone. None where all of it is.

    Returns:
        (h, w) float32 in (0, 1).
    """
    likely = np.maximum.reduce([np.full(guide.shape[:2], _LEAST, np.float32), *placed])
    likely = np.clip(cv2.GaussianBlur(likely, (0, 0), 1.0), _LEAST, 1 - _LEAST)
    known = ramp(np.zeros_like(likely) if face is None else face, _PERHAPS_FACE, _SURELY_FACE)
    return _as_colours_say(guide, np.log(likely / (1 - likely)), known, np.ones_like(likely) if near is None else near)


def attached(matte: np.ndarray, placed: list[np.ndarray]) -> np.ndarray:
    """A matte without what is connected to no person: no place is above the least alpha on the best path to a person.

    Things with a person's colours lie about in photos. Flying hair and hands are connected by something.

    Args:
        matte: (h, w) in [0, 1], over the whole photo.
        placed: as for `likely_person`; the largest part of each mask in which it is sure is a person.

    Returns:
        (h, w) float32, nowhere above the matte; the matte itself where no mask shows anybody.
    """
    surely = np.zeros_like(matte)
    for seen in placed:
        largest = largest_part(seen > _SURE_FROM)
        if largest is not None:
            surely = np.maximum(surely, largest * matte)
    return _spread_within(surely, matte) if surely.any() else matte


def without_holes(matte: np.ndarray, placed: list[np.ndarray], likely: np.ndarray) -> np.ndarray:
    """A matte without the gaps that a person encloses and their mask does not have: skin of the colour of the wall.

    A gap that the mask has too, or that colours plainly see, is a real one, as between an arm and the body, or a curl
    and the neck.

    Args:
        matte, placed: as for `attached`.
        likely: (h, w) as `likely_person` has it.

    Returns:
        (h, w) float32, nowhere below the matte.
    """
    person = np.maximum.reduce([np.zeros_like(matte), *placed])
    known = ramp(person, _NO_GAP_FROM, _SURE_FROM) * ramp(likely, *_LEFT_BY_COLOURS)
    return matte + known * (closed(matte) - matte)


def without_lookalikes(matte: np.ndarray, guide: np.ndarray, undecided: np.ndarray) -> np.ndarray:
    """A matte without the gaps whose colours are those of the person around them and not of the background.

    Through a real gap one sees the background that is also seen beside the person. A black brim, or hair in deep
    shadow, which the masks miss, has other colours than that.

    Args:
        matte: (h, w) in [0, 1].
        guide: (h, w, 3) sRGB in [0, 1].
        undecided: (h, w) the matte before even areas near one half were decided; a strand around a gap may be
            unbroken only there.

    Returns:
        (h, w) float32, nowhere below the matte.
    """
    inside = cv2.erode((closed(matte) > _ENCLOSED).astype(np.uint8), _RIM) > 0
    inside |= _half_enclosed(np.maximum(matte, undecided))
    return matte + _like_what_is_about(matte, inside & (matte < _WHOLE), guide) * (1 - matte)


def closed(matte: np.ndarray) -> np.ndarray:
    """A matte (h, w) with its holes filled: what is background but not connected to the border by background."""
    border = np.ones_like(matte)
    border[1:-1, 1:-1] = 0
    return 1 - _spread_within(np.minimum(border, 1 - matte), 1 - matte)


def _half_enclosed(matte: np.ndarray) -> np.ndarray:
    """(h, w) bool, the gaps that a soft outline of a matte (h, w) encloses, with their soft edges.

    Soft edges enclose specks by chance; of a gap, a good part of the pixels is enclosed.
    """
    around = closed(matte)
    within = cv2.erode((around > _HALF_ENCLOSED).astype(np.uint8), _RIM)
    _, parts = cv2.connectedComponents(within * (matte < _WHOLE))
    pixels, shut_in = (
        np.bincount(parts[where], minlength=parts.max() + 1) for where in (parts > 0, around - matte > _DEEP)
    )
    deep = shut_in > np.maximum(_DEEP_SHARE * pixels, _LEAST_GAP_PX - 1)
    deep[0] = False
    return deep[parts]


def _like_what_is_about(matte: np.ndarray, gaps: np.ndarray, guide: np.ndarray) -> np.ndarray:
    """(h, w) in [0, 1], how surely each gap in a bool mask (h, w) has the colours of the person around it."""
    surely = np.zeros_like(matte)
    _, parts, boxes, _ = cv2.connectedComponentsWithStats(gaps.astype(np.uint8))
    bins = bins_of(guide)
    behind = shares_of(bins, _sure(1 - matte) * ~gaps)
    for part, (left, top, width, height, area) in enumerate(boxes[1:], 1):
        if area < _LEAST_GAP_PX:
            continue
        reach = max(round(_ABOUT * area**0.5), _LEAST_ABOUT_PX)
        about = slice(max(top - reach, 0), top + height + reach), slice(max(left - reach, 0), left + width + reach)
        gap = parts[about] == part
        person = shares_of(bins[about], _sure(matte[about]))
        likeness = np.average(log_odds(bins[about][gap], person, behind), weights=1 - matte[about][gap])
        surely[about][gap] = ramp(likeness, _PERHAPS_ALIKE, _SURELY_ALIKE)
    return cv2.dilate(surely, _RIM)


def _spread_within(seed: np.ndarray, limit: np.ndarray) -> np.ndarray:
    """Grey-scale reconstruction (Vincent 1993): the seed grows over its neighbours, nowhere above the limit."""
    kernel = np.ones((3, 3), np.uint8)
    while True:
        grown = seed
        # To see that nothing grows any more takes longer than to grow.
        for _ in range(_GROWN_AT_ONCE):
            grown = np.minimum(cv2.dilate(grown, kernel), limit)
        if np.array_equal(grown, seed):
            return seed
        seed = grown


def _placed(looks: list[Look], size: tuple[int, int], photo_size: tuple[int, int]) -> np.ndarray:
    """A person's nearest mask at its place, (h, w); beyond it the prior on bodies, corrected by wider looks."""
    whole = all_of(size, photo_size)
    (person, view), *wider = looks
    seen = spread_crop(_in_range(person), view, whole)
    across, down = across_and_down(upright(view), size, photo_size)
    beyond, below = _around(np.abs(across - 0.5), down - 1, seen), down > 1
    for person_wider, wider_view in wider:
        told = _heeding(beyond, spread_crop(_in_range(person_wider), wider_view, whole))
        told = np.where(below, told, np.minimum(told, np.maximum(beyond, _AT_MOST_BESIDE)))
        beyond = np.where(_inside(wider_view, size, photo_size), told, beyond)
    return np.where(_inside(view, size, photo_size), seen, beyond).astype(np.float32)


def _leave_to_others(mask: np.ndarray, looks: list[Look], near: np.ndarray, photo_size: tuple[int, int]) -> None:
    """Lower a person's mask, in place, to `_NOBODY` where it is only the weak prior and another's nearest look reaches.

    Args:
        near: (h, w) see `near_views`, of everybody.
    """
    perhaps = near & (mask <= _PERHAPS_BODY)
    for _, view in looks:
        perhaps &= ~_inside(view, mask.shape, photo_size)
    mask[perhaps] = np.minimum(mask[perhaps], _NOBODY)


def _nearness(looks: list[Look], size: tuple[int, int], photo_size: tuple[int, int]) -> np.ndarray:
    """How near the middle of somebody's nearest look the places of a photo are, (h, w) above 0."""
    across, down = across_and_down(looks[0][1], size, photo_size)
    return ((_MIDDLE + np.hypot(across - 0.5, down - 0.5)) ** -_NEARNESS_POWER).astype(np.float32)


def _inside(view: Crop, size: tuple[int, int], photo_size: tuple[int, int]) -> np.ndarray:
    across, down = across_and_down(view, size, photo_size)
    return (across >= 0) & (across < 1) & (down >= 0) & (down < 1)


def _heeding(guess: np.ndarray, told: np.ndarray) -> np.ndarray:
    """A prior probability corrected by what a wider look says, as far as its log odds are beyond doubt."""
    told = np.clip(told, _SUREST, 1 - _SUREST)
    odds = np.log(told / (1 - told))
    beyond_doubt = np.maximum(odds - _DOUBTED, 0) + np.minimum(odds + _DENIED, 0)
    return 1 / (1 + (1 - guess) / guess * np.exp(-beyond_doubt))


def _in_range(mask: np.ndarray) -> np.ndarray:
    return np.clip(np.nan_to_num(np.asarray(mask, np.float32)), 0.0, 1.0)


def _around(across: np.ndarray, below: np.ndarray, placed: np.ndarray) -> np.ndarray:
    """(h, w) the prior probability of person beyond a view.

    Shoulders widen below a view, hair and hats go on above it, and nobody is far above or beside it, or below their
    feet. A view is 3.4 faces wide and ends two faces below the face's middle (see `face.person_view`), so that a person
    who stands ends about two views further down. From the knees on, what lies beside legs is floor more often than a
    gown, and of any colour.

    Args:
        across, below: (h, w) how far each place lies beside the view's middle and below its lower edge, in its sides.
        placed: (h, w) the view's mask.
    """
    guess = np.full(placed.shape, _PERHAPS_BODY, np.float32)
    guess[(across < 0.5) & (below < -1.0) & (placed > 0.5)] = _PROBABLY_BODY
    guess[(across < 0.45 + np.clip(below + 0.15, 0.0, 0.6)) & (below > -0.2)] = _PROBABLY_BODY
    beside_legs = ramp(below, _HIPS, _KNEES) * ramp(across, *_LEGS_HALF_WIDTH)
    guess += beside_legs * (np.minimum(guess, _BESIDE_LEGS) - guess)
    guess[(across < 0.2) & (below > 0.0) & (below < 1.0)] = _SURELY_BODY
    guess[(across > 2.0) | (below < -1.35) | (below > _BELOW_FEET)] = _NOBODY
    return guess


def _as_colours_say(guide: np.ndarray, prior: np.ndarray, face: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Probability (h, w) from prior log odds plus the limited log odds of each pixel's colour.

    Args:
        prior: (h, w) log odds of person.
        face, near: (h, w) in [0, 1]: where colours say nothing against the person, and where they are learnt.
    """
    bins = bins_of(guide)
    odds, in_doubt = prior, 1 - ramp(prior, *_DOUBTFUL)
    for _ in range(_ROUNDS):
        likely = 1 / (1 + np.exp(-odds))
        told = log_odds(bins, *(shares_of(bins, _sure(side) * near) for side in (likely, 1 - likely)))
        nobodys = in_doubt * ramp(-told, *_NOBODYS)
        nearby = _MOST_COLOURS_SAY + (_MOST_OF_NOBODYS - _MOST_COLOURS_SAY) * nobodys
        most = (_MOST_FROM_AFAR + (nearby - _MOST_FROM_AFAR) * near) * (1 - face)
        odds = prior + np.clip(told, -most, _MOST_COLOURS_SAY)
    return (1 / (1 + np.exp(-odds))).astype(np.float32)


def _sure(probability: np.ndarray) -> np.ndarray:
    return ramp(probability, _SURE_FROM, 1)
