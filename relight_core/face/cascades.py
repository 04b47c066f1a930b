"""OpenCV's Haar cascades: raw hits on a grey image, merged into one box per face."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from functools import lru_cache
from itertools import count, takewhile
from pathlib import Path

import cv2
import numpy as np

from relight_core.unwanted import stop_if_unwanted

FRONTAL = ("frontalface_default", "frontalface_alt", "frontalface_alt2")
PROFILE = ("profileface",)

SMALLEST_PX = 28
"""Width of the smallest heads that are searched for, in pixels of the image that a cascade sees."""

_SCALE_STEP = 1.1
"""Ratio of two consecutive sizes of a cascade's window."""
_NEIGHBOURS, _ALIKE = 3, 0.2
"""A hit has more windows than the first; and they differ by no more than this share of their sizes."""
_SEARCHED_AT_ONCE_PX = 1400
"""Longer side of the largest image that is searched for all sizes in one call, which takes a second of one core."""
_SAME_FACE_OVERLAP = 0.35
"""Intersection over union above which two hits belong to one face."""
_SURE_VOTES, _FEWEST_VOTES = 15, 8
"""Votes from which on a face is accepted without eyes, and below which it is rejected even with eyes."""
_EYE_VIEW_PX = 240
"""Width to which the upper half of a face is scaled before eyes are searched for."""

_FRONTAL_FACE = (0.095, 0.26, 0.905, 1.065)
"""x0, y0, x1, y1 of a face, cheek to cheek and brow to chin, in a frontal hit, as fractions of its side. Measured on
portraits with facial landmarks; the medians of the three frontal cascades agree to 0.02."""

_PROFILE_FACE = (-0.05, 0.20, 0.76, 1.0)
"""The same in a profile hit of a face that looks to the left of the image."""

_detecting = threading.Lock()
"""Cascades are shared, and can't be used by two threads at once."""


@dataclass(frozen=True)
class Candidate:
    """One face, merged from the hits of several cascades.

    Attributes:
        box: (4,) x0, y0, x1, y1 in pixel edges of the grey image, cheek to cheek and brow to chin.
        votes: raw hits that were merged into it, over all cascades.
        cascades: how many different cascades hit it.
        roll_deg: the angle by which the head leans to the left of the image.
    """

    box: np.ndarray
    votes: int
    cascades: int
    roll_deg: float = 0.0


def frontal_candidates(grey: np.ndarray, smallest_px: int = SMALLEST_PX) -> list[Candidate]:
    """Faces that all frontal cascades hit, or that fewer hit and eyes confirm.

    Args:
        grey: (h, w) uint8, with local contrast equalised.
        smallest_px: width of the smallest heads; searching for small ones takes nearly all the time.
    """
    hits = [hit for name in FRONTAL for hit in _hits(grey, name, _FRONTAL_FACE, smallest_px)]
    return [found for found in _merge(hits) if _is_frontal_face(grey, found)]


def every_hit(grey: np.ndarray) -> list[Candidate]:
    """Whatever two frontal cascades hit, most of which is not a face.

    Args:
        grey: (h, w) uint8, with local contrast equalised.
    """
    return _merge([hit for name in FRONTAL[:2] for hit in _hits(grey, name, _FRONTAL_FACE)])


def _is_frontal_face(grey: np.ndarray, found: Candidate) -> bool:
    if found.cascades == len(FRONTAL) and found.votes >= _SURE_VOTES:
        return True
    if found.votes < _FEWEST_VOTES:
        return False
    return _has_eyes(grey, found.box, wanted=1 if found.cascades > 1 else 2)


def profile_candidates(grey: np.ndarray) -> list[Candidate]:
    """Faces in profile, looking left or right, that have many votes or an eye.

    Args:
        grey: (h, w) uint8, with local contrast equalised.
    """
    return [
        found
        for found in every_profile_hit(grey)
        if found.votes >= _SURE_VOTES or (found.votes >= _FEWEST_VOTES and _has_eyes(grey, found.box, wanted=1))
    ]


def every_profile_hit(grey: np.ndarray) -> list[Candidate]:
    """Whatever the profile cascade hits, looking left or right, most of which is not a face.

    Args:
        grey: (h, w) uint8, with local contrast equalised.
    """
    hits = _hits(grey, PROFILE[0], _PROFILE_FACE)
    for box, votes, _ in _hits(np.ascontiguousarray(grey[:, ::-1]), PROFILE[0], _PROFILE_FACE):
        mirrored = np.array([grey.shape[1] - box[2], box[1], grey.shape[1] - box[0], box[3]])
        hits.append((mirrored, votes, "profileface mirrored"))
    return _merge(hits)


def _hits(
    grey: np.ndarray, name: str, face_within: tuple[float, float, float, float], smallest_px: int = SMALLEST_PX
) -> list[tuple[np.ndarray, int, str]]:
    """A cascade's hits: box of the face, votes, name of the cascade.

    Raises:
        UnwantedError: nobody waits for them any more; here, since all searches by cascades come here again and again.
    """
    is_large = max(grey.shape) > _SEARCHED_AT_ONCE_PX
    boxes, votes = (_detected_by_size if is_large else _detected)(grey, name, smallest_px)
    hits = []
    for (x, y, side, _), windows in zip(np.asarray(boxes).reshape(-1, 4), np.ravel(votes), strict=True):
        box = np.array([x, y, x, y], np.float64) + side * np.array(face_within)
        hits.append((box, int(windows), name))
    return hits


def _detected(
    grey: np.ndarray, name: str, smallest_px: int, largest_px: int = 0, neighbours: int = _NEIGHBOURS
) -> tuple[np.ndarray, np.ndarray]:
    """What OpenCV says: boxes (x, y, width, height), and how many windows each was merged from."""
    stop_if_unwanted()
    with _detecting:
        smallest, largest = (smallest_px, smallest_px), (largest_px, largest_px)
        return _cascade(name).detectMultiScale2(grey, _SCALE_STEP, neighbours, 0, smallest, largest)


def _detected_by_size(grey: np.ndarray, name: str, smallest_px: int) -> tuple[np.ndarray, np.ndarray]:
    """The same but for windows at the very edge, size by size: one call for all sizes takes up to ten seconds."""
    first, last = _cascade(name).getOriginalWindowSize()[0], min(grey.shape)
    sizes = takewhile(lambda side: side <= last, (round(first * _SCALE_STEP**number) for number in count()))
    # What reaches a pixel beyond the image is cut off, which OpenCV does to merged windows only.
    windows = [
        (x, y, side, side)
        for side in sizes
        if side >= smallest_px
        for x, y, _, _ in np.reshape(_detected(grey, name, side, side, neighbours=0)[0], (-1, 4)).tolist()
    ]
    return cv2.groupRectangles(windows, _NEIGHBOURS, _ALIKE)


def _merge(hits: list[tuple[np.ndarray, int, str]]) -> list[Candidate]:
    """Merge hits that overlap the strongest one, then those that overlap the strongest of the rest, and so on.

    Each box is the mean of its hits, weighted by votes.
    """
    waiting = sorted(hits, key=lambda hit: -hit[1])
    found = []
    while waiting:
        strongest = waiting[0][0]
        group = [hit for hit in waiting if overlap(hit[0], strongest) > _SAME_FACE_OVERLAP]
        waiting = [hit for hit in waiting if overlap(hit[0], strongest) <= _SAME_FACE_OVERLAP]
        votes = np.array([hit[1] for hit in group], np.float64)
        box = (np.stack([hit[0] for hit in group]) * votes[:, None]).sum(axis=0) / votes.sum()
        found.append(Candidate(box, int(votes.sum()), len({hit[2] for hit in group})))
    return found


def overlap(a: np.ndarray, b: np.ndarray) -> float:
    """Intersection of two boxes over their union."""
    width = min(a[2], b[2]) - max(a[0], b[0])
    height = min(a[3], b[3]) - max(a[1], b[1])
    if width <= 0 or height <= 0:
        return 0.0
    shared = width * height
    total = (a[2] - a[0]) * (a[3] - a[1]) + (b[2] - b[0]) * (b[3] - b[1]) - shared
    return float(shared / total)


def _has_eyes(grey: np.ndarray, box: np.ndarray, wanted: int) -> bool:
    """Whether the upper half of a face box shows at least `wanted` eyes of a plausible size."""
    width = box[2] - box[0]
    x0, x1 = np.clip(np.rint([box[0] - 0.05 * width, box[2] + 0.05 * width]), 0, grey.shape[1]).astype(int)
    y0, y1 = np.clip(np.rint([box[1] - 0.15 * width, box[1] + 0.55 * width]), 0, grey.shape[0]).astype(int)
    if x1 - x0 < 16 or y1 - y0 < 12:
        return False
    factor = _EYE_VIEW_PX / (x1 - x0)
    view = cv2.resize(grey[y0:y1, x0:x1], None, fx=factor, fy=factor, interpolation=cv2.INTER_LINEAR)
    sizes = (_EYE_VIEW_PX // 8, _EYE_VIEW_PX // 2)
    with _detecting:
        eyes = _cascade("eye_tree_eyeglasses").detectMultiScale(
            view, 1.1, 4, 0, (sizes[0], sizes[0]), (sizes[1], sizes[1])
        )
    return len(eyes) >= wanted


@lru_cache(maxsize=8)
def _cascade(name: str) -> cv2.CascadeClassifier:
    path = Path(cv2.data.haarcascades) / f"haarcascade_{name}.xml"
    cascade = cv2.CascadeClassifier(str(path))
    if cascade.empty():
        raise RuntimeError(f"OpenCV's cascade {path} is missing; install opencv-contrib-python-headless 4.x")
    return cascade
