"""OpenCV's Haar cascades: raw hits on a grey image, and one box per face from their votes."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np

FRONTAL = ("frontalface_default", "frontalface_alt", "frontalface_alt2")
PROFILE = ("profileface",)

SMALLEST_PX = 28
"""Width of the smallest heads that are looked for."""

_SCALE_STEP = 1.1
"""By how much a cascade's window grows from one search to the next."""
_SAME_FACE_OVERLAP = 0.35
"""Intersection over union from which on two hits are of one face."""
_SURE_VOTES, _FEWEST_VOTES = 15, 8
"""Votes from which on a face needs no eyes to confirm it, and from which on eyes can."""
_EYE_VIEW_PX = 240
"""Width to which the upper half of a face is brought before eyes are looked for."""

_FRONTAL_FACE = (0.095, 0.26, 0.905, 1.065)
"""Brow to chin and cheek to cheek within a frontal hit, as fractions of its side; the medians over
portraits against facial landmarks agree to 0.02 between the three frontal cascades."""

_PROFILE_FACE = (-0.05, 0.20, 0.76, 1.0)
"""The same within a profile hit of a face that looks to the left of the image."""

_detecting = threading.Lock()


@dataclass(frozen=True)
class Candidate:
    """One face, as agreed on by the cascades that hit it.

    Attributes:
        box: (4,) x0, y0, x1, y1 in pixel edges of the grey image, brow to chin and cheek to cheek.
        votes: raw hits that were merged into it, over all cascades.
        cascades: how many different cascades hit it.
        roll_deg: by how much the head leans to the left of the image.
    """

    box: np.ndarray
    votes: int
    cascades: int
    roll_deg: float = 0.0


def frontal_candidates(grey: np.ndarray, smallest_px: int = SMALLEST_PX) -> list[Candidate]:
    """Faces that all frontal cascades see, or fewer see and eyes confirm.

    Args:
        grey: (h, w) uint8, contrast evened out.
        smallest_px: width of the smallest heads; nearly all the time goes into small ones.
    """
    hits = [hit for name in FRONTAL for hit in _hits(grey, name, _FRONTAL_FACE, smallest_px)]
    return [found for found in _merge(hits) if _is_frontal_face(grey, found)]


def every_hit(grey: np.ndarray) -> list[Candidate]:
    """Whatever two frontal cascades take for a face, most of it none.

    Args:
        grey: (h, w) uint8, contrast evened out.
    """
    return _merge([hit for name in FRONTAL[:2] for hit in _hits(grey, name, _FRONTAL_FACE)])


def _is_frontal_face(grey: np.ndarray, found: Candidate) -> bool:
    if found.cascades == len(FRONTAL) and found.votes >= _SURE_VOTES:
        return True
    if found.votes < _FEWEST_VOTES:
        return False
    return _has_eyes(grey, found.box, wanted=1 if found.cascades > 1 else 2)


def profile_candidates(grey: np.ndarray) -> list[Candidate]:
    """Faces seen from the side, looking left or right, with many votes or an eye.

    Args:
        grey: (h, w) uint8, contrast evened out.
    """
    return [
        found
        for found in every_profile_hit(grey)
        if found.votes >= _SURE_VOTES or (found.votes >= _FEWEST_VOTES and _has_eyes(grey, found.box, wanted=1))
    ]


def every_profile_hit(grey: np.ndarray) -> list[Candidate]:
    """Whatever the profile cascade takes for a face that looks left or right.

    Args:
        grey: (h, w) uint8, contrast evened out.
    """
    hits = _hits(grey, PROFILE[0], _PROFILE_FACE)
    for box, votes, _ in _hits(np.ascontiguousarray(grey[:, ::-1]), PROFILE[0], _PROFILE_FACE):
        mirrored = np.array([grey.shape[1] - box[2], box[1], grey.shape[1] - box[0], box[3]])
        hits.append((mirrored, votes, "profileface mirrored"))
    return _merge(hits)


def _hits(
    grey: np.ndarray, name: str, face_within: tuple[float, float, float, float], smallest_px: int = SMALLEST_PX
) -> list[tuple[np.ndarray, int, str]]:
    with _detecting:
        boxes, votes = _cascade(name).detectMultiScale2(grey, _SCALE_STEP, 3, 0, (smallest_px, smallest_px))
    hits = []
    for (x, y, side, _), count in zip(np.asarray(boxes).reshape(-1, 4), np.ravel(votes), strict=True):
        box = np.array([x, y, x, y], np.float64) + side * np.array(face_within)
        hits.append((box, int(count), name))
    return hits


def _merge(hits: list[tuple[np.ndarray, int, str]]) -> list[Candidate]:
    """Group hits that overlap the strongest one; the box is their mean, weighted by votes."""
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
    """Whether the upper half of a face box shows at least `wanted` eyes, of believable size."""
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
