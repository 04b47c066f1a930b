"""Where in a photo a person probably is: as networks say within their views, as bodies go on beyond, and by colours."""

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
_BESIDE_LEGS, _LEGS_HALF_WIDTH, _HIPS, _KNEES, _BELOW_FEET = 0.05, (0.1, 0.45), 0.5, 1.2, 2.4
"""The last four in sides of a view, the heights below it."""
_LEAST, _TINY = 0.01, 1e-20
_SURE_FROM = 0.7
_NO_GAP_FROM = 0.5
_ENCLOSED, _HALF_ENCLOSED, _WHOLE, _LEAST_GAP_PX = 0.3, 0.15, 0.9, 12
_DEEP, _DEEP_SHARE = 0.05, 0.16
_RIM = np.ones((5, 5), np.uint8)
_ABOUT, _LEAST_ABOUT_PX = 2.0, 12
_PERHAPS_ALIKE, _SURELY_ALIKE = 2.0, 3.0
"""Mean log odds of a gap's colours, person about it to background, from which on it is closed, in part and whole."""
_MOST_COLOURS_SAY, _MOST_FROM_AFAR = 2.0, 4.0
_NOBODYS, _DOUBTFUL, _MOST_OF_NOBODYS = (3.5, 5.0), (3.0, 3.5), 6.0
"""Log odds against the person from which on hardly anything on them has a colour, and next to nothing; those of a mask
up to which and from which on it is in doubt and beyond it; how much colours say where both are so. To networks hair is
solid: a blown wall between two curls, of which they are less sure, would take on every light as a grey haze. Of a
white collar before that wall they are surer."""
_LEFT_BY_COLOURS = (0.05, 0.2)
"""Probability of person, colours heard, up to which a gap is none of the mask's business, and from which on it is."""
_ROUNDS = 2
_GROWN_AT_ONCE = 8
_PERHAPS_FACE, _SURELY_FACE = 0.5, 0.9
_DOUBTED, _DENIED, _SUREST, _AT_MOST_BESIDE = 1.0, 2.0, 0.002, 0.35
"""In a wider look faces are smaller than the person network learnt with. It knows bodies there and what lies behind
them, but doubts what people hold, and beside heads takes things along: in those, colours decide."""
_MIDDLE, _NEARNESS_POWER = 0.05, 4
"""What is added to a distance from the middle of a look, in its sides, and how much faster than it a claim weakens."""

Look = tuple[np.ndarray, Crop]
"""(S, S) probability in [0, 1] that the pixels of a view are a person, and where in the photo the view lies."""


def place_masks(
    people: Sequence[list[Look]],
    size: tuple[int, int],
    photo_size: tuple[int, int],
    others: Sequence[list[Look]] = (),
) -> list[np.ndarray]:
    """Each person's masks at their places in a photo, and around them what is likely of a body below and a head above.

    What somebody may only perhaps reach, and another's nearest look sees, is nobody's: else a lamp between two heads
    would be in doubt, as a part of everyone whose looks end before it. What is as likely a part of somebody else is
    whose is nearer: to the person network an arm or a shirt that a neighbour rests against may belong to both.

    Args:
        people: looks at each, from the nearest to the widest; what is not finite or out of range is brought into it.
            What lies outside the nearest is guessed, and the wider ones have a say in that.
        size: (h, w) of the result.
        photo_size: (height, width).
        others: looks at people who are known not to be meant.

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
    """Probability of person over a whole photo.

    A nose before a wall of skin's colour is none of the wall's, however much more of that colour the wall has: in a
    face, which networks know by its shape, colours have no say against the person. Beyond the nearest looks they have
    most: a wall that a wider one takes for a lap has the colours of the wall behind the shoulders. Within them they
    have even more where the masks are in some doubt and hardly anything on the person has such a colour.

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
    """A matte without what hangs together with no person: nowhere more than on the best way there from a person.

    Things of a person's colours lie about in photos. Hair that flies and hands hang on by something.

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
    """A matte without gaps that lie all within a person and that their mask knows nothing of.

    Skin may have the colour of the wall. Between an arm and a body, or a curl and a neck, where the mask has a gap
    as well or colours leave little of it, one looks through.

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
    """A matte without gaps that have the colours of the person about them and none of what lies behind.

    Through a gap one sees what is seen beside the person too: a black brim, or hair in deep shadow, that the masks
    miss is none.

    Args:
        matte: (h, w) in [0, 1].
        guide: (h, w, 3) sRGB in [0, 1].
        undecided: (h, w) the matte before what is half and half was decided, where a strand that goes about a gap may
            still be whole.

    Returns:
        (h, w) float32, nowhere below the matte.
    """
    inside = cv2.erode((closed(matte) > _ENCLOSED).astype(np.uint8), _RIM) > 0
    inside |= _half_enclosed(np.maximum(matte, undecided))
    return matte + _like_what_is_about(matte, inside & (matte < _WHOLE), guide) * (1 - matte)


def closed(matte: np.ndarray) -> np.ndarray:
    """A matte (h, w) without its holes: what is not, but hangs together with the border only by what is."""
    border = np.ones_like(matte)
    border[1:-1, 1:-1] = 0
    return 1 - _spread_within(np.minimum(border, 1 - matte), 1 - matte)


def _half_enclosed(matte: np.ndarray) -> np.ndarray:
    """Where a matte (h, w) has gaps within what is more person than nothing, and what is soft about them.

    Soft edges hold specks that are shut in; a gap is so in a good part of it.
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
    """(h, w) in [0, 1] how surely the colours of each gap, of a mask (h, w), are those of the person about it."""
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
    """A person's mask at its place; beyond it what is likely of a body below and a head above, and wider looks."""
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
    """Take out of somebody's mask what is only perhaps theirs, where another's nearest look sees that it is nobody's.

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
    """The probability of a guess after what a wider look tells, as far as that is beyond some doubt."""
    told = np.clip(told, _SUREST, 1 - _SUREST)
    odds = np.log(told / (1 - told))
    beyond_doubt = np.maximum(odds - _DOUBTED, 0) + np.minimum(odds + _DENIED, 0)
    return 1 / (1 + (1 - guess) / guess * np.exp(-beyond_doubt))


def _in_range(mask: np.ndarray) -> np.ndarray:
    return np.clip(np.nan_to_num(np.asarray(mask, np.float32)), 0.0, 1.0)


def _around(across: np.ndarray, below: np.ndarray, placed: np.ndarray) -> np.ndarray:
    """(h, w): shoulders widen below a view, hair and hats go on above it; nobody is far above or beside, or below feet.

    A view is 3.4 faces wide and ends two below the face's middle: a person who stands ends two more views down. From
    the knees on, what lies beside legs is floor more often than a gown, and has any colour.

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
    """Log odds plus those of each pixel's colour among what is surely person and surely not, in no face against it."""
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
