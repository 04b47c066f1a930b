"""The probability that a pixel of a photo belongs to a person, from three sources.

Within the networks' views it is their prediction. Beyond these it is a prior on where bodies continue below and beside
a head. Both are then corrected by colour: by how common a pixel's colour is among what surely is a person and among
what surely isn't.

A *look* is a view with a network's probability of person; the *nearest* look at a person shows the least around them.
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
"""Prior probabilities of person beyond the nearest look (see `_prior_beyond`)."""
_BESIDE_LEGS = 0.05
"""The largest prior beside the legs."""
_LEGS_HALF_WIDTH = (0.1, 0.45)
"""Ramp of the distance from the view's middle, in its sides, over which legs end."""
_HIPS, _KNEES, _BELOW_FEET = 0.5, 1.2, 2.4
"""Distances below the view's lower edge, in its sides."""

_LEAST, _TINY = 0.01, 1e-20
"""The least probability, so that log odds stay finite, and what is added to a divisor that may be 0."""
_SURE_FROM = 0.7
"""Probability from which on a mask begins to be sure, of person or of background."""
_NO_GAP_FROM = 0.5
"""A gap in the matte begins to be closed at this probability of the mask, and is closed from `_SURE_FROM` on."""

_ENCLOSED, _HALF_ENCLOSED = 0.3, 0.15
"""A place lies within a person, or within a soft outline, if the matte's alpha with holes filled is above this."""
_WHOLE = 0.9
"""A place within a person is part of a gap if its alpha is below this."""
_LEAST_GAP_PX = 12
"""Smaller gaps are ignored, in pixels."""
_DEEP, _DEEP_SHARE = 0.05, 0.16
"""In a gap within a soft outline at least this share of the pixels must have an alpha that is lower, by at least the
first, than with holes filled."""
_RIM = np.ones((5, 5), np.uint8)
"""Size of the soft edge of an outline, which is not a gap."""
_ABOUT, _LEAST_ABOUT_PX = 2.0, 12
"""The person's colours are learnt within this distance of a gap, in square roots of its area and at least in pixels."""
_PERHAPS_ALIKE, _SURELY_ALIKE = 2.0, 3.0
"""Ramp of the mean log odds of a gap's colours, for the person around it against the background, over which it is
closed."""

_MOST_BY_COLOURS, _MOST_BEYOND = 2.0, 4.0
"""Largest change of log odds by colours: within the nearest looks, and, against the person, beyond them."""
_ABSENT = (3.5, 5.0)
"""Ramp of log odds against the person over which a colour goes from rare on them to next to absent."""
_DOUBTFUL = (3.0, 3.5)
"""Ramp of a mask's log odds over which it ceases to be in doubt."""
_MOST_IF_ABSENT = 6.0
"""Largest change of log odds by colours that are absent from the person, where the mask is in doubt. To networks hair
is solid, and a blown-out wall between two curls would be relit as a grey haze. But they are less sure of it than of,
say, a white collar in front of that wall."""
_GAP_BY_COLOURS = (0.05, 0.2)
"""Ramp of the probability of person after the correction by colour: below it a gap stays open whatever the mask says,
above it the mask decides."""
_ROUNDS = 2
"""Rounds in which colours are learnt again from the corrected probability."""
_GROWN_AT_ONCE = 8
"""Steps of a reconstruction between two checks whether it still grows."""
_PERHAPS_FACE, _SURELY_FACE = 0.5, 0.9
"""Ramp of the probability of face over which colours cease to count against a person."""

_DOUBTED, _DENIED, _SUREST = 1.0, 2.0, 0.002
"""Log odds for and against a person that a wider look must exceed to count, and its least probability. Its faces are
smaller than those the person network was trained on: it recognises bodies and what lies behind them, but is unsure
about things that people hold."""
_AT_MOST_BESIDE = 0.35
"""Largest probability that a wider look may give to what lies beside or above a head. There the network tends to
include things, so colours should decide."""
_MIDDLE, _NEARNESS_POWER = 0.05, 4
"""A person's claim to a place falls with this power of the place's distance from the middle of their nearest look, in
the look's sides, plus the first number."""

Look = tuple[np.ndarray, Crop]
"""(S, S) probability in [0, 1] that the pixels of a view are a person, and where in the photo the view lies."""


def place_masks(
    people: Sequence[list[Look]],
    size: tuple[int, int],
    photo_size: tuple[int, int],
    others: Sequence[list[Look]] = (),
) -> list[np.ndarray]:
    """Each person's probability over the whole photo: from the looks at them, and beyond these from a prior on bodies.

    Two rules apply between neighbours:

    - Where a person has only the weak prior, and another person's nearest look covers the place, it belongs to nobody.
      Otherwise a lamp between two heads would stay in doubt for everyone whose looks end before it.
    - Where `others` are about as likely, a place belongs to the person whose look has it nearer to its middle, since
      the person network may count an arm or a shirt that a neighbour leans against for both.

    Args:
        people: looks at each person, from the nearest to the widest; values that are not finite or out of range are
            replaced. Beyond the nearest look the prior holds, corrected by the wider ones.
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
            _yield_to_others(mask, looks, near, photo_size)
    if not others:
        return placed
    theirs = sum(_placed(looks, size, photo_size) * _nearness(looks, size, photo_size) for looks in others)
    own = [_nearness(looks, size, photo_size) for looks in people]
    return [mask * (mask * mine / (mask * mine + theirs + _TINY)) for mask, mine in zip(placed, own, strict=True)]


def place_faces(faces: Iterable[Look], size: tuple[int, int], photo_size: tuple[int, int]) -> np.ndarray:
    """Probability (h, w) in [0, 1] that a place in a photo belongs to a face; sizes as of `place_masks`."""
    whole, result = all_of(size, photo_size), np.zeros(size, np.float32)
    for face, view in faces:
        seen = spread_crop(_in_range(face), view, whole)
        result = np.maximum(result, np.where(_inside(view, size, photo_size), seen, 0))
    return result


def near_views(people: Sequence[list[Look]], size: tuple[int, int], photo_size: tuple[int, int]) -> np.ndarray:
    """Which places in a photo lie in anybody's nearest look, (h, w) bool; arguments as of `place_masks`."""
    seen = (_inside(looks[0][1], size, photo_size) for looks in people)
    return np.logical_or.reduce([np.zeros(size, bool), *seen])


def likely_person(
    guide: np.ndarray, placed: list[np.ndarray], face: np.ndarray | None = None, near: np.ndarray | None = None
) -> np.ndarray:
    """Probability of person over a whole photo: the masks, corrected by colour.

    The correction is limited, and differently in different places:

    - In a face, which networks recognise by its shape, colours never count against the person: a nose in front of a
      wall of the colour of skin stays a nose.
    - Beyond the nearest looks they count more than within: a wall that a wider look takes for a lap has the colours of
      the wall behind the shoulders.
    - Within the nearest looks they count most where the masks are in doubt and hardly anything on the person has such a
      colour.

    Args:
        guide: (h, w, 3) sRGB in [0, 1], a small copy of the photo.
        placed: masks of that size (see `place_masks`).
        face: (h, w) probability of a face, of that size (see `place_faces`); None if no face is known.
        near: (h, w) in [0, 1], of that size, what lies in the nearest looks (see `near_views`), from which alone
            colours are learnt; None if everything does.

    Returns:
        (h, w) float32 in (0, 1).
    """
    likely = np.maximum.reduce([np.full(guide.shape[:2], _LEAST, np.float32), *placed])
    likely = np.clip(cv2.GaussianBlur(likely, (0, 0), 1.0), _LEAST, 1 - _LEAST)
    known = ramp(np.zeros_like(likely) if face is None else face, _PERHAPS_FACE, _SURELY_FACE)
    near = np.ones_like(likely) if near is None else near
    return _corrected_by_colour(guide, np.log(likely / (1 - likely)), known, near)


def attached(matte: np.ndarray, placed: list[np.ndarray]) -> np.ndarray:
    """A matte without what isn't connected to a person, such as things that happen to have a person's colours.

    Flying hair and hands are always connected by something. No place keeps more than the smallest alpha along the best
    path to a person.

    Args:
        matte: (h, w) in [0, 1], over the whole photo.
        placed: as of `likely_person`; the largest part of each mask that is sure counts as a person.

    Returns:
        (h, w) float32, nowhere above the matte; the matte itself if no mask shows anybody.
    """
    surely = np.zeros_like(matte)
    for seen in placed:
        largest = largest_part(seen > _SURE_FROM)
        if largest is not None:
            surely = np.maximum(surely, largest * matte)
    return _spread_within(surely, matte) if surely.any() else matte


def without_holes(matte: np.ndarray, placed: list[np.ndarray], likely: np.ndarray) -> np.ndarray:
    """A matte without enclosed gaps that the masks don't have, such as skin of the same colour as the wall.

    A gap that the masks have too, or that colours show clearly, is real: between an arm and the body, or between a curl
    and the neck.

    Args:
        matte, placed: as of `attached`.
        likely: (h, w), of `likely_person`.

    Returns:
        (h, w) float32, nowhere below the matte.
    """
    person = np.maximum.reduce([np.zeros_like(matte), *placed])
    known = ramp(person, _NO_GAP_FROM, _SURE_FROM) * ramp(likely, *_GAP_BY_COLOURS)
    return matte + known * (closed(matte) - matte)


def without_lookalikes(matte: np.ndarray, guide: np.ndarray, undecided: np.ndarray) -> np.ndarray:
    """A matte without the gaps whose colours are those of the person around them and not of the background.

    A real gap shows the background that is also seen beside the person. A black brim, or hair in deep shadow, which the
    masks may miss, has other colours.

    Args:
        matte: (h, w) in [0, 1].
        guide: (h, w, 3) sRGB in [0, 1].
        undecided: (h, w) the matte before even areas near one half were decided; only in it may a strand around a gap
            be unbroken.

    Returns:
        (h, w) float32, nowhere below the matte.
    """
    inside = cv2.erode((closed(matte) > _ENCLOSED).astype(np.uint8), _RIM) > 0
    inside |= _half_enclosed(np.maximum(matte, undecided))
    return matte + _likeness_to_surroundings(matte, inside & (matte < _WHOLE), guide) * (1 - matte)


def closed(matte: np.ndarray) -> np.ndarray:
    """A matte (h, w) with its holes filled: background that isn't connected to the border through background."""
    border = np.ones_like(matte)
    border[1:-1, 1:-1] = 0
    return 1 - _spread_within(np.minimum(border, 1 - matte), 1 - matte)


def _half_enclosed(matte: np.ndarray) -> np.ndarray:
    """The gaps that a soft outline of a matte (h, w) encloses, with their soft edges, (h, w) bool.

    Soft edges enclose specks by chance. Of a gap, a good part of the pixels must be enclosed.
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


def _likeness_to_surroundings(matte: np.ndarray, gaps: np.ndarray, guide: np.ndarray) -> np.ndarray:
    """Certainty that each gap in a bool mask (h, w) has the colours of the person around it, (h, w) in [0, 1]."""
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
    """Greyscale reconstruction by dilation (Vincent 1993): the seed grows over its neighbours, up to the limit."""
    kernel = np.ones((3, 3), np.uint8)
    while True:
        grown = seed
        # Several steps at once, since checking for growth takes longer than growing.
        for _ in range(_GROWN_AT_ONCE):
            grown = np.minimum(cv2.dilate(grown, kernel), limit)
        if np.array_equal(grown, seed):
            return seed
        seed = grown


def _placed(looks: list[Look], size: tuple[int, int], photo_size: tuple[int, int]) -> np.ndarray:
    """A person's probability (h, w): the nearest look, and beyond it the prior on bodies, corrected by wider looks."""
    whole = all_of(size, photo_size)
    (person, view), *wider = looks
    seen = spread_crop(_in_range(person), view, whole)
    across, down = across_and_down(upright(view), size, photo_size)
    beyond, below = _prior_beyond(np.abs(across - 0.5), down - 1, seen), down > 1
    for person_wider, wider_view in wider:
        corrected = _corrected_by(beyond, spread_crop(_in_range(person_wider), wider_view, whole))
        corrected = np.where(below, corrected, np.minimum(corrected, np.maximum(beyond, _AT_MOST_BESIDE)))
        beyond = np.where(_inside(wider_view, size, photo_size), corrected, beyond)
    return np.where(_inside(view, size, photo_size), seen, beyond).astype(np.float32)


def _yield_to_others(mask: np.ndarray, looks: list[Look], near: np.ndarray, photo_size: tuple[int, int]) -> None:
    """Lower a person's mask, in place, to `_NOBODY` where it is only the weak prior and another's nearest look reaches.

    Args:
        mask: (h, w), the person's.
        looks: at the person.
        near: (h, w), `near_views` of everybody.
        photo_size: (height, width).
    """
    perhaps = near & (mask <= _PERHAPS_BODY)
    for _, view in looks:
        perhaps &= ~_inside(view, mask.shape, photo_size)
    mask[perhaps] = np.minimum(mask[perhaps], _NOBODY)


def _nearness(looks: list[Look], size: tuple[int, int], photo_size: tuple[int, int]) -> np.ndarray:
    """The weight of a person's claim to each place in a photo, by its distance from their nearest look, (h, w) > 0."""
    across, down = across_and_down(looks[0][1], size, photo_size)
    return ((_MIDDLE + np.hypot(across - 0.5, down - 0.5)) ** -_NEARNESS_POWER).astype(np.float32)


def _inside(view: Crop, size: tuple[int, int], photo_size: tuple[int, int]) -> np.ndarray:
    """Which places in a photo lie in a view, (h, w) bool."""
    across, down = across_and_down(view, size, photo_size)
    return (across >= 0) & (across < 1) & (down >= 0) & (down < 1)


def _corrected_by(guess: np.ndarray, wider: np.ndarray) -> np.ndarray:
    """A prior probability corrected by a wider look's, as far as its log odds exceed the thresholds of doubt."""
    wider = np.clip(wider, _SUREST, 1 - _SUREST)
    odds = np.log(wider / (1 - wider))
    beyond_doubt = np.maximum(odds - _DOUBTED, 0) + np.minimum(odds + _DENIED, 0)
    return 1 / (1 + (1 - guess) / guess * np.exp(-beyond_doubt))


def _in_range(mask: np.ndarray) -> np.ndarray:
    """A mask as float32 in [0, 1], without NaN."""
    return np.clip(np.nan_to_num(np.asarray(mask, np.float32)), 0.0, 1.0)


def _prior_beyond(across: np.ndarray, below: np.ndarray, placed: np.ndarray) -> np.ndarray:
    """The prior probability of person beyond a view, (h, w).

    Shoulders widen below a view, hair and hats continue above it, and nobody is far above or beside it, or below their
    own feet. A view is 3.4 faces wide and ends two faces below the face's middle (see `face.person_view`), so a
    standing person ends about two views further down. From the knees down, what lies beside legs is more often floor,
    of any colour, than a gown.

    Args:
        across, below: (h, w) distance of each place from the view's middle sideways, and from its lower edge
            downwards, in its sides.
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


def _corrected_by_colour(guide: np.ndarray, prior: np.ndarray, face: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Probability (h, w) from prior log odds plus the limited log odds of each pixel's colour.

    Args:
        guide: (h, w, 3) sRGB.
        prior: (h, w) log odds of person.
        face, near: (h, w) in [0, 1]: where colours don't count against the person, and where they are learnt.
    """
    bins = bins_of(guide)
    odds, in_doubt = prior, 1 - ramp(prior, *_DOUBTFUL)
    for _ in range(_ROUNDS):
        likely = 1 / (1 + np.exp(-odds))
        colour_odds = log_odds(bins, *(shares_of(bins, _sure(side) * near) for side in (likely, 1 - likely)))
        absent = in_doubt * ramp(-colour_odds, *_ABSENT)
        nearby = _MOST_BY_COLOURS + (_MOST_IF_ABSENT - _MOST_BY_COLOURS) * absent
        most = (_MOST_BEYOND + (nearby - _MOST_BEYOND) * near) * (1 - face)
        odds = prior + np.clip(colour_odds, -most, _MOST_BY_COLOURS)
    return (1 / (1 + np.exp(-odds))).astype(np.float32)


def _sure(probability: np.ndarray) -> np.ndarray:
    """The weight of pixels for learning colours, by their probability."""
    return ramp(probability, _SURE_FROM, 1)
