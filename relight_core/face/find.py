"""Face detection with OpenCV's cascades, and guesses for better judges where cascades see too little."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import cv2
import numpy as np

from relight_core.face.cascades import (
    SMALLEST_PX,
    Candidate,
    every_hit,
    every_profile_hit,
    frontal_candidates,
    overlap,
    profile_candidates,
)
from relight_core.imaging.colour import luminance, srgb_encode
from relight_core.imaging.photo import Photo
from relight_core.imaging.resampling import resize_area
from relight_core.unwanted import UnwantedError

_LONG_SIDE_PX = 800
"""Longer side of the copy of a photo in which faces are searched for first."""
_LEAST_SIDE_PX = 24
"""A narrower copy has no room for a cascade's window."""
_LARGEST_GROWTH = 3.0
"""A small photo is enlarged by at most this factor."""
_WHITE_PERCENTILE, _AGAINST_LIGHT_PERCENTILES = 99.0, (50.0, 25.0)
"""Percentile of a photo's luminance that becomes white for the cascades; and those that are tried for a face in front
of a bright sky or window, which would be too dark."""
_BEYOND_DOUBT_VOTES = 40
"""Hits of all cascades together from which on a face needs no judge."""
_LARGE, _BESIDE_LARGE = 0.25, 0.1
"""Widths as shares of the photo's longer side: of a face that makes the photo a portrait, and of the smallest heads
that are searched for beside it."""
_TILTS_DEG = (-30.0, 30.0)
"""Angles at which leaning faces are searched for."""

_LONG_SIDE_FOR_SMALL_PX, _LONG_SIDE_FOR_SMALL_TURNED_PX = 2800, 1400
"""Longer sides of the copies in which small faces are searched for: upright ones, and those in profile or leaning."""
_SHRUNK_FOR_SMALL = 0.7
"""Largest scale of these copies: with it the smallest heads of a cascade, of 28 pixels, have 40 in the photo, and
smaller ones aren't worth relighting."""

_ALL_TILTS_DEG = (0.0, -30.0, 30.0, -60.0, 60.0, -90.0, 90.0, -120.0, 120.0, -150.0, 150.0, 180.0)
_LONG_SIDE_FOR_GUESSES_PX = 400
_MOST_GUESSES, _MOST_PROFILE_GUESSES = 16, 3
_SAME_PLACE = 0.3
"""Intersection over union from which on two guesses at the same angle count as one."""
_FILLING_SHARE = 0.9
"""Width of a face that fills the photo, as a share of the photo's shorter side."""

_LONG_SIDE_FOR_COMPANIONS_PX = 500
_LARGEST_ALONE, _LARGEST_LYING_ALONE = 0.13, 0.25
"""Widths, as shares of the photo's longer side, above which a single known face leaves no room for others. For an
upright face it is lower, since the first search would have seen several; for one that lies or is upside down the
search stops at the first."""
_LIKE_COMPANIONS = (0.5, 1.6)
"""Range of companions' widths, in widths of the largest known face."""
_BESIDE = 0.65
"""Boxes belong to one face if their centres are nearer than this, in widths and heights of the known one."""

_known: WeakKeyDictionary[Photo, list[FaceBox]] = WeakKeyDictionary()
"""What `find_faces` has found; photos are searched once."""
_finding = threading.Lock()


@dataclass(frozen=True)
class FaceBox:
    """A face from cheek to cheek and from brow to chin, in pixel edges: pixel i spans i to i + 1.

    A box may reach beyond the photo if the face does. Its sides are the face's own width and height, as if the face
    had been rotated upright about its centre.

    Attributes:
        roll_deg: the angle by which the head leans to the left of the photo.
        doubtful: whether only cascades say that this is a face.
    """

    x0: float
    y0: float
    x1: float
    y1: float
    roll_deg: float = 0.0
    doubtful: bool = False

    @property
    def width(self) -> float:
        """Pixels."""
        return self.x1 - self.x0

    @property
    def height(self) -> float:
        """Pixels."""
        return self.y1 - self.y0


Judge = Callable[[FaceBox], bool]
"""Says whether a box holds a face."""


class _InDoubtError(Exception):
    """A judge would be needed to tell whether something is a face."""


def find_faces(photo: Photo, is_face: Judge = lambda box: False) -> list[FaceBox]:
    """Find faces with OpenCV's Haar cascades (Viola and Jones 2001).

    First upright frontal faces; beside a large one only those that are not much smaller. If none of them is beyond
    doubt, also faces in profile and, on rotated copies, faces that lean by up to about 45 degrees, which takes four
    times as long; not in a photo that shows a large face beyond doubt when it is turned by a quarter or a half, for
    whose faces `guess_faces` is needed anyway. A photo is searched once, however many threads ask.

    Args:
        is_face: a better judge of doubtful faces, such as a network; asked before the long search.

    Returns:
        Largest first, small doubtful ones last; empty if there is none.

    Raises:
        UnwantedError: nobody waits for them any more (see `relight_core.unwanted`), as from all searches here; then
            nothing is remembered.
    """
    with _finding:
        if photo not in _known:
            _known[photo] = _search(photo, is_face)
        return list(_known[photo])


def find_faces_beyond_doubt(photo: Photo) -> None:
    """Run `find_faces` ahead, before a judge is available; where it would need one, nothing is remembered.

    Nor is it where nobody waits for it any more.
    """

    def leave(box: FaceBox) -> bool:
        raise _InDoubtError

    with suppress(_InDoubtError, UnwantedError):
        find_faces(photo, leave)


def find_small_faces(photo: Photo) -> list[FaceBox]:
    """Faces that are too small for `find_faces`: upright ones down to about 40 pixels in a photo of 12 megapixels.

    For when nothing else is found, since this takes several times as long, up to 20 seconds of one core, and hardly a
    portrait has only such faces. `find_faces` then returns them too.

    Returns:
        As `find_faces`.
    """
    most = _SHRUNK_FOR_SMALL * max(photo.linear.shape[:2])
    if most <= _LONG_SIDE_PX:
        return []
    for look, long_side_px in (
        (frontal_candidates, _LONG_SIDE_FOR_SMALL_PX),
        (_turned_away, _LONG_SIDE_FOR_SMALL_TURNED_PX),
    ):
        grey, scale = _detection_view(photo.linear, min(long_side_px, most), 1.0)
        if min(grey.shape) >= _LEAST_SIDE_PX and (found := look(grey)):
            faces = _boxes(found, scale)
            remember_faces(photo, faces)
            return faces
    return []


def remember_faces(photo: Photo, faces: list[FaceBox]) -> None:
    """Make `find_faces` return these faces for a photo, once they have been corrected."""
    with _finding:
        _known[photo] = list(faces)


def guess_faces(photo: Photo) -> list[FaceBox]:
    """Places that may be faces, leaning by any angle: whatever any cascade hits, for a better judge to choose from.

    Returns:
        At most 17: up to three in profile, then the others, the likeliest first. One place may be listed at several
        angles. The last is always a face that fills the photo, of which cascades see too little.
    """
    grey, scale = _detection_view(photo.linear, _LONG_SIDE_FOR_GUESSES_PX, _LARGEST_GROWTH)
    if min(grey.shape) < _LEAST_SIDE_PX:
        return []
    hits = _when_turned(every_hit, grey, _ALL_TILTS_DEG)
    # The profile cascade has fewer votes, with which its guesses would always come last: so its best come first.
    sides = sorted(every_profile_hit(grey), key=lambda hit: -hit.votes)[:_MOST_PROFILE_GUESSES]
    guesses: list[Candidate] = []
    for hit in [*sides, *sorted(hits, key=lambda hit: -hit.votes)]:
        # The same place may be right at another angle.
        if all(overlap(hit.box, known.box) < _SAME_PLACE or hit.roll_deg != known.roll_deg for known in guesses):
            guesses.append(hit)
    return [*(_in_photo(guess, scale) for guess in guesses[:_MOST_GUESSES]), _filling(photo)]


def guess_companions(photo: Photo, known: Sequence[FaceBox]) -> list[FaceBox]:
    """Places that may be more faces beside known ones, for a better judge to choose from.

    Only photos with room for others are searched: those with several known faces, or whose only one is small. Every
    hit of a cascade counts, whatever its votes, if it is about as large as the known faces, and upright, in profile or
    leaning by up to 45 degrees. If the photo is on its side or upside down, this is relative to its largest face.

    Returns:
        At most 16, the likeliest first, none in the place of a known face.
    """
    long_side = max(photo.linear.shape[:2])
    if not known:
        return []
    first = max(known, key=lambda face: face.width)
    largest, lies_deg = first.width, 90.0 * round(first.roll_deg / 90)
    if len(known) == 1 and largest > (_LARGEST_LYING_ALONE if lies_deg else _LARGEST_ALONE) * long_side:
        return []
    grey, scale = _detection_view(photo.linear, _LONG_SIDE_FOR_COMPANIONS_PX, _LARGEST_GROWTH)
    if min(grey.shape) < _LEAST_SIDE_PX:
        return []
    looks = [(every_hit, 0.0), (every_profile_hit, 0.0), *((every_hit, tilt_deg) for tilt_deg in _TILTS_DEG)]
    hits = [hit for look, tilt_deg in looks for hit in _when_turned(look, grey, (tilt_deg - lies_deg,))]
    guesses: list[FaceBox] = []
    for hit in sorted(hits, key=lambda hit: -hit.votes):
        guess = _in_photo(hit, scale)
        alike = _LIKE_COMPANIONS[0] < guess.width / largest < _LIKE_COMPANIONS[1]
        if alike and not any(_in_the_same_place(guess, face) for face in (*known, *guesses)):
            guesses.append(guess)
    return guesses[:_MOST_GUESSES]


def _in_the_same_place(guess: FaceBox, known: FaceBox) -> bool:
    """Whether a guess is so near to a known face that both are the same."""
    across = abs(guess.x0 + guess.x1 - known.x0 - known.x1) / 2
    down = abs(guess.y0 + guess.y1 - known.y0 - known.y1) / 2
    return across < _BESIDE * known.width and down < _BESIDE * known.height


def _search(photo: Photo, is_face: Judge) -> list[FaceBox]:
    """`find_faces`, without remembering the result."""
    grey, scale = _detection_view(photo.linear, _LONG_SIDE_PX, _LARGEST_GROWTH)
    if min(grey.shape) < _LEAST_SIDE_PX:
        return []
    long_side = max(grey.shape)
    found = frontal_candidates(grey, max(round(_BESIDE_LARGE * long_side), SMALLEST_PX))
    if any(_is_sure(candidate) and _width(candidate) >= _LARGE * long_side for candidate in found):
        return _boxes(found, scale)
    found = frontal_candidates(grey)
    if not found and _is_turned(grey):
        return []
    found = found or _against_light(photo)
    if not any(map(_is_sure, found)) and not any(is_face(_in_photo(candidate, scale)) for candidate in found):
        found += _turned_away(grey)
    return _boxes(found, scale)


def _is_turned(grey: np.ndarray) -> bool:
    """Whether a large face beyond doubt lies or is upside down, as in a photo that was taken sideways.

    Then nobody need be looked for who leans: `guess_faces` looks at all angles. This takes a twentieth of the time.
    """
    smallest_px = max(round(_LARGE * max(grey.shape)), SMALLEST_PX)
    quarters = (np.ascontiguousarray(np.rot90(grey, number)) for number in (1, 3, 2))
    return any(_is_sure(candidate) for quarter in quarters for candidate in frontal_candidates(quarter, smallest_px))


def _against_light(photo: Photo) -> list[Candidate]:
    """Frontal faces that cascades see only after the photo has been brightened."""
    for white_percentile in _AGAINST_LIGHT_PERCENTILES:
        bright, _ = _detection_view(photo.linear, _LONG_SIDE_PX, _LARGEST_GROWTH, white_percentile)
        if found := frontal_candidates(bright):
            return found
    return []


def _is_sure(candidate: Candidate) -> bool:
    return candidate.votes >= _BEYOND_DOUBT_VOTES


def _boxes(found: list[Candidate], scale: float) -> list[FaceBox]:
    """The plausible candidates in an image of this scale as boxes in the photo, the best first."""
    return [_in_photo(candidate, scale) for candidate in _plausible(sorted(found, key=_weight, reverse=True))]


def _turned_away(grey: np.ndarray) -> list[Candidate]:
    """Faces in profile or, if there are none, faces that lean."""
    return profile_candidates(grey) or _when_turned(frontal_candidates, grey, _TILTS_DEG)


def _filling(photo: Photo) -> FaceBox:
    """A face that fills the photo."""
    height, width = photo.linear.shape[:2]
    half = _FILLING_SHARE * min(height, width) / 2
    return FaceBox(width / 2 - half, height / 2 - half, width / 2 + half, height / 2 + half, doubtful=True)


def _in_photo(candidate: Candidate, scale: float) -> FaceBox:
    return FaceBox(*(float(edge) / scale for edge in candidate.box), candidate.roll_deg, doubtful=True)


def _weight(candidate: Candidate) -> float:
    """Area times confidence."""
    width, height = candidate.box[2:] - candidate.box[:2]
    return float(width * height) * min(candidate.votes / _BEYOND_DOUBT_VOTES, 1.0)


def _plausible(found: list[Candidate]) -> list[Candidate]:
    """Drop boxes mostly inside a better one, such as a mouth taken for a face, and doubtful ones that are far smaller.

    Args:
        found: best first.
    """
    kept: list[Candidate] = []
    for candidate in found:
        tiny = kept and _width(candidate) < _width(kept[0]) / 2
        if tiny and not _is_sure(candidate):
            continue
        if not any(_share_within(candidate.box, better.box) > 0.5 for better in kept):
            kept.append(candidate)
    return kept


def _width(candidate: Candidate) -> float:
    return float(candidate.box[2] - candidate.box[0])


def _share_within(box: np.ndarray, other: np.ndarray) -> float:
    """The share of a box's area that lies within another box."""
    ratio = overlap(box, other)
    area, other_area = (np.prod(b[2:] - b[:2]) for b in (box, other))
    # ratio = shared / (area + other_area - shared), solved for shared.
    return float(ratio * (area + other_area) / (1.0 + ratio) / area)


def _detection_view(
    linear: np.ndarray, long_side_px: int, growth: float, white_percentile: float = _WHITE_PERCENTILE
) -> tuple[np.ndarray, float]:
    """The image that cascades see, (h, w) uint8 with exposure and local contrast equalised, and its scale.

    Args:
        linear: (H, W, 3).
        long_side_px: longer side of the image.
        growth: largest scale.
        white_percentile: of luminance, which becomes white.
    """
    height, width = linear.shape[:2]
    scale = min(long_side_px / max(height, width), growth)
    size = max(round(height * scale), 1), max(round(width * scale), 1)
    brightness = luminance(resize_area(linear, size))
    white = float(np.percentile(brightness, white_percentile))
    if white > 0.0:
        brightness = np.minimum(brightness / np.float32(white), 1.0)
    grey = np.rint(np.clip(srgb_encode(brightness), 0.0, 1.0) * 255.0).astype(np.uint8)
    return cv2.createCLAHE(clipLimit=2.0, tileGridSize=(8, 8)).apply(grey), scale


def _when_turned(
    look: Callable[[np.ndarray], list[Candidate]], grey: np.ndarray, tilts_deg: Iterable[float]
) -> list[Candidate]:
    """What `look` finds in the image rotated by each angle; boxes are centred on the face's place in the image."""
    found = []
    for tilt_deg in tilts_deg:
        turned, back = _turned(grey, tilt_deg)
        found += [replace(_moved(candidate, back), roll_deg=-tilt_deg) for candidate in look(turned)]
    return found


def _turned(grey: np.ndarray, tilt_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """The whole image rotated counterclockwise, and the (2, 3) affine map of its points back."""
    height, width = grey.shape
    matrix = cv2.getRotationMatrix2D((width / 2, height / 2), tilt_deg, 1.0)
    cosine, sine = abs(matrix[0, 0]), abs(matrix[0, 1])
    size = int(width * cosine + height * sine), int(width * sine + height * cosine)
    matrix[:, 2] += np.array(size) / 2 - np.array([width, height]) / 2
    turned = cv2.warpAffine(grey, matrix, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return turned, cv2.invertAffineTransform(matrix)


def _moved(candidate: Candidate, affine: np.ndarray) -> Candidate:
    """The candidate with the same size, and its centre through a (2, 3) affine map."""
    centre = affine @ np.append((candidate.box[:2] + candidate.box[2:]) / 2, 1.0)
    half = (candidate.box[2:] - candidate.box[:2]) / 2
    return Candidate(np.concatenate([centre - half, centre + half]), candidate.votes, candidate.cascades)
