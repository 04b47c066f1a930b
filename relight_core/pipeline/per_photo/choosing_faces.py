"""Which places in a photo are faces: what cascades take for one, and parsing maps confirm or find by themselves."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

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

_UPRIGHT_TO_DEG, _LYING_FROM_DEG = 15.0, 45.0

_SPECK, _SUSPECTED_SPECK, _MUCH_WIDER = 0.1, 0.2, 3
"""A face narrower than this share of the photo's shorter side is a speck, the second if it is only suspected, and gives
way to one so much wider."""

_LARGER = 1.5
"""A face is so many times as wide as what passes for another in it."""

_AGREED, _SAME_PLACE = 4, 0.7
"""Windows of the search that lead to one place, where boxes share so much of their union."""


def choose_faces(
    photo: Photo,
    evidence: Callable[[FaceBox], int] | None = None,
    locate: Callable[[Crop], FaceBox | None] = lambda view: None,
    look_closer: Callable[[FaceBox], int] | None = None,
    glimpse: Callable[[FaceBox], int] = lambda box: 0,
) -> list[FaceBox]:
    """All faces, the largest first.

    Args:
        evidence: says how many of brows, eyes and mouth are seen in a box. With it, what only cascades take for a
            face counts only if there are two, and where no face is left, less likely places are judged by it, also
            those of faces that lie or stand on their heads.
        locate: says where a view of the photo shows a face; asked where nothing else finds any, or only specks.
        look_closer: a stricter `evidence`. With it, faces are looked for beside those that were confirmed, where there
            is room for some.
        glimpse: as `evidence`, of parts that are only suspected. All three of them confirm what the cascades agree on,
            and what lies or stands on its head, and two or three what is located again and again.

    Raises:
        NoFaceError: no face.
    """
    if evidence is None:
        faces = find_faces(photo) or find_small_faces(photo)
    else:
        faces = find_faces(photo, lambda box: evidence(box) == _ALL_EVIDENCE)
    if evidence is not None and (not faces or any(face.doubtful for face in faces)):
        faces = _confirmed(photo, faces, evidence, locate, glimpse)
        if look_closer is not None:
            faces = _with_companions(photo, faces, look_closer)
    return those_chosen(photo, faces, None)


def those_chosen(photo: Photo, faces: Sequence[FaceBox], face_index: int | None) -> list[FaceBox]:
    """All of a photo's faces, or only the one of an index.

    Raises:
        NoFaceError: there are none.
        InputError: no such index.
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


def _confirmed(
    photo: Photo,
    found: list[FaceBox],
    evidence: Callable[[FaceBox], int],
    locate: Callable[[Crop], FaceBox | None],
    glimpse: Callable[[FaceBox], int],
) -> list[FaceBox]:
    """The boxes that are confirmed, else the best guess, else what is located, else those with a hint of a face.

    Faces that are small in a large photo come last: hardly a portrait has none but those, and looking for them takes
    longer than everything before.
    """

    def is_sure(face: FaceBox) -> bool:
        return not face.doubtful or evidence(face) >= _ENOUGH_EVIDENCE or glimpse(face) == _ALL_EVIDENCE

    def guessed() -> list[FaceBox]:
        return _best(guess_faces(photo), evidence, glimpse)

    def searched() -> list[FaceBox]:
        return _searched(photo, locate, evidence, glimpse)

    faces = list(filter(is_sure, found))
    if faces and all(_is_speck(face, photo, evidence(face)) for face in faces):
        # A button and a fold beside a face in profile, or teeth of one that lies, which cascades don't see.
        least_width = _MUCH_WIDER * max(face.width for face in faces)
        # Of a face that lies the search may only suspect one that stands: then a guess that shows all is better.
        places = (_wider(look(), least_width) for look in (searched, guessed))
        faces = _fullest(places, evidence) or faces
    if not faces:
        # Leaves may pass for half a face, and be all that cascades hit beside a head that leans.
        faces = _fullest((look() for look in (guessed, searched)), evidence)
    if not faces and not found:
        found = find_small_faces(photo)
        faces = list(filter(is_sure, found))
    if not faces:
        return [face for face in found if evidence(face) > 0]
    faces = [replace(face, doubtful=False) for face in faces]
    remember_faces(photo, faces)
    return faces


def _fullest(choices: Iterable[list[FaceBox]], evidence: Callable[[FaceBox], int]) -> list[FaceBox]:
    """The first choice whose faces are all seen whole, else the first that has any.

    Of a face whose brow the photo cuts off, a half or the nostrils and the mouth may pass for a face that lies: such a
    guess gives way to a much larger face around it that stands and shows as much.
    """
    left: list[FaceBox] = []
    for faces in choices:
        if not faces:
            continue
        seen = min(map(evidence, faces))
        if seen == _ALL_EVIDENCE:
            return faces
        if not left or (_lies_within(left, faces) and seen >= min(map(evidence, left))):
            left = faces
    return left


def _lies_within(parts: list[FaceBox], faces: list[FaceBox]) -> bool:
    """Whether all of some boxes lie, and are small parts of the first of some faces, which stands."""
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
    share = _SPECK if seen >= _ENOUGH_EVIDENCE else _SUSPECTED_SPECK
    return seen < _ALL_EVIDENCE and face.width < share * min(photo.linear.shape[:2])


def _searched(
    photo: Photo,
    locate: Callable[[Crop], FaceBox | None],
    evidence: Callable[[FaceBox], int],
    glimpse: Callable[[FaceBox], int],
) -> list[FaceBox]:
    """The face that a search through the whole photo ends at; no cascade has a say here.

    All of its parts must be seen. Of a face that is turned far aside, bowed, or cut by the photo's edge, brows and eyes
    are halves or slivers: there they need only be suspected, where several windows lead to the same place, and the
    more of these do, the fewer.
    """
    places: list[FaceBox] = []
    for place in map(locate, search_windows(photo.linear.shape[:2])):
        if place is None:
            continue
        if evidence(place) == _ALL_EVIDENCE:
            return [place]
        places.append(place)
    votes = [sum(_same_place(place, other) for other in places) for place in places]
    for place, agreed in sorted(zip(places, votes, strict=True), key=lambda pair: -pair[1]):
        if agreed < _AGREED:
            break
        if (suspected := glimpse(place)) >= _ENOUGH_EVIDENCE and suspected + agreed >= _ALL_EVIDENCE + _AGREED:
            return [place]
    return []


def _same_place(place: FaceBox, other: FaceBox) -> bool:
    corners = [np.array([box.x0, box.y0, box.x1, box.y1]) for box in (place, other)]
    return overlap(*corners) > _SAME_PLACE


def _with_companions(photo: Photo, faces: list[FaceBox], look_closer: Callable[[FaceBox], int]) -> list[FaceBox]:
    """The faces, and those beside them that the finder saw too little of, the largest first."""
    more = [guess for guess in guess_companions(photo, faces) if look_closer(guess) >= _ENOUGH_EVIDENCE]
    if not more:
        return faces
    faces = [*faces, *(replace(face, doubtful=False) for face in more)]
    faces.sort(key=lambda face: -face.width * face.height)
    remember_faces(photo, faces)
    return faces


def _best(
    guesses: Iterable[FaceBox], evidence: Callable[[FaceBox], int], glimpse: Callable[[FaceBox], int]
) -> list[FaceBox]:
    """The guess of the highest rank, if it has any; the first that shows all of a face and stands ends it."""
    best, highest = [], ()
    for guess in guesses:
        rank = _rank(evidence(guess), glimpse(guess), abs(guess.roll_deg))
        if rank > highest:
            best, highest = [guess], rank
        if rank[:2] == (True, True):
            break
    return best


def _rank(seen: int, suspected: int, leaning_deg: float) -> tuple[int, ...]:
    """By how much a guess at a face is to be trusted; empty where it shows too little of one.

    One that shows all of a face goes first, of those one that stands; then the one of which more is suspected, then the
    more upright one. What is suspected tells faces that lie or stand on their heads, and hide a part, from animals and
    stones: of those no part may be missing. Of an upright face, such as one in profile, less needs to be seen then.
    """
    upright, stands = leaning_deg < _UPRIGHT_TO_DEG, leaning_deg < _LYING_FROM_DEG
    complete, nothing_missing = seen == _ALL_EVIDENCE, _ALL_EVIDENCE in (seen, suspected)
    least = 1 if upright and nothing_missing else _ENOUGH_EVIDENCE
    if seen < least or not (stands or nothing_missing):
        return ()
    return complete, complete and stands, suspected, stands, upright, seen
