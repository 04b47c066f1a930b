"""Which places in a photo are faces: cascades propose them, and parsing maps confirm or find them.

Cascades alone are unreliable, so their places are judged by the parsing there (`face.evidence`):

- *evidence* is how many of brows, eyes and mouth win pixels there, 0 to 3;
- a *glimpse* is the same count by probabilities, which may be too small to win a pixel;
- to *locate* is to find a face in a view by its parsing alone, without a cascade;
- to *look closer* is a stricter kind of evidence, for guesses beside known faces, most of which are wrong.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from relight_core.errors import InputError, NoFaceError
from relight_core.face.cascades import overlap
from relight_core.face.crop import Crop
from relight_core.face.find import (
    FaceBox,
    find_faces,
    find_small_faces,
    guess_companions,
    guess_faces,
    remember_faces,
)
from relight_core.face.windows import search_windows
from relight_core.imaging.photo import Photo

_ENOUGH_EVIDENCE, _ALL_EVIDENCE = 2, 3
"""Parts out of three; any face shows at least two."""

_UPRIGHT_TO_DEG, _LYING_FROM_DEG = 15.0, 45.0
"""Up to the first roll a face is *upright*. Up to the second it *stands*, and from there on it lies or is upside down.
"""

_SPECK, _SUSPECTED_SPECK, _MUCH_WIDER = 0.1, 0.2, 3
"""A *speck* is narrower than the first share of the photo's shorter side, or than the second if there is hardly any
evidence of it. It gives way to a face that is more than three times as wide."""

_LARGER = 1.5
"""A face is so many times as wide as a part of it that was taken for another face."""

_AGREED, _SAME_PLACE = 4, 0.7
"""Number of search windows that must lead to the same place, and intersection over union of the same place."""


class Eyes(Protocol):
    """A judge of places in a photo; the module explains its terms."""

    def evidence(self, box: FaceBox) -> int:
        """0 to 3. 2 confirms a box of the cascades. If none is confirmed, less likely places are judged by it."""

    def glimpse(self, box: FaceBox) -> int:
        """0 to 3. 3 confirms a box of the cascades, or a face that lies or is upside down; 2 or 3 a place that `locate`
        finds from several views."""

    def locate(self, view: Crop) -> FaceBox | None:
        """The face in a view of the photo, if any; used if nothing else finds one, or only specks."""

    def look_closer(self, box: FaceBox) -> int:
        """A stricter `evidence` for more faces beside confirmed ones."""


def choose_faces(photo: Photo, eyes: Eyes | None = None) -> list[FaceBox]:
    """All faces, the largest first.

    Args:
        photo: to search.
        eyes: judges the boxes of the cascades, and finds what these miss; None trusts the cascades.

    Raises:
        NoFaceError: no face.
        UnwantedError: nobody waits for them any more; nothing that is half decided is remembered.
    """
    if eyes is None:
        faces = find_faces(photo) or find_small_faces(photo)
    else:
        faces = find_faces(photo, lambda box: eyes.evidence(box) == _ALL_EVIDENCE)
        if not faces or any(face.doubtful for face in faces):
            faces = _with_companions(photo, _confirmed(photo, faces, eyes), eyes)
    return those_chosen(photo, faces, None)


def those_chosen(photo: Photo, faces: Sequence[FaceBox], face_index: int | None) -> list[FaceBox]:
    """All of a photo's faces, or only the one with an index.

    Raises:
        NoFaceError: there are none.
        InputError: there is no such index.
    """
    name = photo.path or "the photo"
    if not faces:
        raise NoFaceError(
            f"{name}: no face found; say where it is, or use a photo in which one is larger or better lit"
        )
    if face_index is None:
        return list(faces)
    if not 0 <= face_index < len(faces):
        count = "1 face, number 0" if len(faces) == 1 else f"{len(faces)} faces, numbers 0 to {len(faces) - 1}"
        raise InputError(f"{name}: there is no face number {face_index}; it has {count}")
    return [faces[face_index]]


def _confirmed(photo: Photo, found: list[FaceBox], eyes: Eyes) -> list[FaceBox]:
    """The confirmed boxes; else the best guess; else what is located; else boxes with any evidence at all.

    Small faces in a large photo come last, since hardly a portrait has only those, and the search for them takes longer
    than everything before.
    """

    def is_sure(face: FaceBox) -> bool:
        seen = not face.doubtful or eyes.evidence(face) >= _ENOUGH_EVIDENCE
        return seen or eyes.glimpse(face) == _ALL_EVIDENCE

    def guessed() -> list[FaceBox]:
        return _best(guess_faces(photo), eyes)

    def searched() -> list[FaceBox]:
        return _searched(photo, eyes)

    faces = list(filter(is_sure, found))
    if faces and all(_is_speck(face, photo, eyes.evidence(face)) for face in faces):
        # A speck is often a button or a fold beside a face in profile, which cascades don't see, or the teeth of a face
        # that lies. A much wider face with full evidence is preferred.
        least_width = _MUCH_WIDER * max(face.width for face in faces)
        # If the face lies, the search may find some evidence of a standing one; a guess with full evidence is better.
        places = (_wider(look(), least_width) for look in (searched, guessed))
        faces = _fullest(places, eyes) or faces
    if not faces:
        # Not simply the first: beside a leaning head, cascades may only hit leaves that look like half a face.
        faces = _fullest((look() for look in (guessed, searched)), eyes)
    if not faces and not found:
        found = find_small_faces(photo)
        faces = list(filter(is_sure, found))
    if not faces:
        return [face for face in found if eyes.evidence(face) > 0]
    return [replace(face, doubtful=False) for face in faces]


def _fullest(choices: Iterable[list[FaceBox]], eyes: Eyes) -> list[FaceBox]:
    """The first choice whose faces all have full evidence, otherwise the first that has any faces.

    With one exception: if the photo cuts off a brow, half of the face, or its nostrils and mouth, may be taken for a
    small face that lies. Such a choice gives way to a later one with a larger upright face around it and no less
    evidence.
    """
    left: list[FaceBox] = []
    for faces in choices:
        if not faces:
            continue
        seen = min(map(eyes.evidence, faces))
        if seen == _ALL_EVIDENCE:
            return faces
        if not left or (_lies_within(left, faces) and seen >= min(map(eyes.evidence, left))):
            left = faces
    return left


def _lies_within(parts: list[FaceBox], faces: list[FaceBox]) -> bool:
    """Whether the first of `faces` is upright, and all of `parts` lie and are small parts of it."""
    face = faces[0]
    return abs(face.roll_deg) < _UPRIGHT_TO_DEG and all(
        abs(part.roll_deg) >= _LYING_FROM_DEG
        and face.width > _LARGER * part.width
        and face.x0 <= (part.x0 + part.x1) / 2 <= face.x1
        and face.y0 <= (part.y0 + part.y1) / 2 <= face.y1
        for part in parts
    )


def _wider(faces: list[FaceBox], least_width: float) -> list[FaceBox]:
    return [face for face in faces if face.width > least_width]


def _is_speck(face: FaceBox, photo: Photo, seen: int) -> bool:
    """Whether a face with less than full evidence, `seen`, is very small in the photo."""
    share = _SPECK if seen >= _ENOUGH_EVIDENCE else _SUSPECTED_SPECK
    return seen < _ALL_EVIDENCE and face.width < share * min(photo.linear.shape[:2])


def _searched(photo: Photo, eyes: Eyes) -> list[FaceBox]:
    """The one face that a search of the whole photo without cascades finds, if any.

    Full evidence ends the search. A face that is turned far aside, bowed, or cut by the photo's edge only shows halves
    or slivers of brows and eyes. For such a face a glimpse of 3 is enough if four windows lead to the same place, and
    one of 2 if five do.
    """
    places: list[FaceBox] = []
    for place in map(eyes.locate, search_windows(photo.linear.shape[:2])):
        if place is None:
            continue
        if eyes.evidence(place) == _ALL_EVIDENCE:
            return [place]
        places.append(place)
    votes = [sum(_same_place(place, other) for other in places) for place in places]
    for place, agreed in sorted(zip(places, votes, strict=True), key=lambda pair: -pair[1]):
        if agreed < _AGREED:
            break
        if (suspected := eyes.glimpse(place)) >= _ENOUGH_EVIDENCE and suspected + agreed >= _ALL_EVIDENCE + _AGREED:
            return [place]
    return []


def _same_place(place: FaceBox, other: FaceBox) -> bool:
    """Whether two windows of the search lead to the same place."""
    corners = [np.array([box.x0, box.y0, box.x1, box.y1]) for box in (place, other)]
    return overlap(*corners) > _SAME_PLACE


def _with_companions(photo: Photo, faces: list[FaceBox], eyes: Eyes) -> list[FaceBox]:
    """The faces, with more beside them that the finder missed, the largest first.

    They are remembered here, at the end: a search that was stopped before would else not look for companions again.
    """
    more = [guess for guess in guess_companions(photo, faces) if eyes.look_closer(guess) >= _ENOUGH_EVIDENCE]
    if more:
        faces = [*faces, *(replace(face, doubtful=False) for face in more)]
        faces.sort(key=lambda face: -face.width * face.height)
    if not all(face.doubtful for face in faces):
        remember_faces(photo, faces)
    return faces


def _best(guesses: Iterable[FaceBox], eyes: Eyes) -> list[FaceBox]:
    """The guess of the highest rank, if any has one. The first that stands and has full evidence ends the search."""
    best, highest = [], ()
    for guess in guesses:
        rank = _rank(eyes.evidence(guess), eyes.glimpse(guess), abs(guess.roll_deg))
        if rank > highest:
            best, highest = [guess], rank
        if rank[:2] == (True, True):
            break
    return best


def _rank(seen: int, suspected: int, leaning_deg: float) -> tuple[int, ...]:
    """The rank by which guesses are compared, higher is better; empty if too little of a face is seen.

    A guess with full evidence comes first, and among these one that stands; then the larger glimpse, then one that
    stands. A face that lies or is upside down and lacks evidence of a part must have a glimpse of all three, which
    distinguishes it from animals and stones. For an upright face with such a glimpse, such as one in profile, an
    evidence of 1 is enough.

    Args:
        seen: evidence.
        suspected: glimpse.
        leaning_deg: absolute roll.
    """
    upright, stands = leaning_deg < _UPRIGHT_TO_DEG, leaning_deg < _LYING_FROM_DEG
    complete, nothing_missing = seen == _ALL_EVIDENCE, _ALL_EVIDENCE in (seen, suspected)
    least = 1 if upright and nothing_missing else _ENOUGH_EVIDENCE
    if seen < least or not (stands or nothing_missing):
        return ()
    return complete, complete and stands, suspected, stands, upright, seen
