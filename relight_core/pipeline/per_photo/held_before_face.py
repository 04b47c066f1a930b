"""What is held before a face or stuck on it, such as a phone, a card or a sticker: half skin to the parsing.

De-lighting takes a part of such a thing for skin and another for background. Its colour went into the light, beside a
red phone the face turned green, and a white one became translucent skin. But there is no background within a face. So
background there is the thing, and what is connected to it and has its colour belongs to it. As a `FaceCovering` it has
the colour of skin while the face is de-lit again, and is cloth afterwards.
"""

from __future__ import annotations

import cv2
import numpy as np
import torch
import torch.nn.functional as F

from relight_core.face.parsing import EYES, FEWEST_PIXELS, INDEX, MOUTH, PAPER_CLASSES, likely, share_of
from relight_core.imaging.masks import disc, largest_part
from relight_core.imaging.tensor_logs import exact_logs
from relight_core.imaging.tensor_means import middle_values
from relight_core.pipeline.per_photo.face_covering import FEWEST_EYE_PIXELS, FaceCovering, connected_to, plain_skin
from relight_core.pipeline.stages import Surface

_RIM, _LEAST = 0.07, 0.01
"""Background counts from so far within the face's outline on, and from so large an area on, in the square root of the
face's area and in that. Of the wall beside the nose of a profile, less lies as deep. There is none in seventeen photos,
nor in those under a hard light and coloured ones."""
_OTHER_COLOUR, _OTHER_BRIGHTNESS = 0.35, 1.2
"""In logs: at least one of the two sets a thing apart from the skin, its ratios to green or its brightness."""
_ALIKE, _LEAST_RATIOS, _LEAST_BRIGHTNESS, _COLOURED, _BRIGHTNESS_OF_COLOURED = 0.5, 0.15, 0.6, 0.5, 1.0
"""What is within this share of that difference has the thing's colour; or within so many logs, brightness within more
where the thing has a colour of its own: it is lighter and darker here and there."""
_NOT_OF_IT = ("hair", *MOUTH)


@torch.inference_mode()
def find_held_before_face(surface: Surface) -> FaceCovering | None:
    """The thing before a face; None if there is none, or too little of the face is seen to tell."""
    face, bare = _outline(surface.parsing), plain_skin(surface)
    eyes = float(share_of(surface.parsing, EYES).sum())
    if face is None or eyes < FEWEST_EYE_PIXELS or int(bare.sum()) < FEWEST_PIXELS:
        return None
    hole = _hole(surface.parsing, face)
    if hole is None:
        return None
    seen = exact_logs(F.avg_pool2d(surface.photo, 3, 1, 1, count_include_pad=False))
    at = torch.from_numpy(hole).to(bare)
    contrast = (middle_values(seen, at) - middle_values(seen, bare)).flatten()
    alike = _alike(seen, at, contrast)
    if alike is None:
        return None
    alike = alike & (likely(share_of(surface.parsing, _NOT_OF_IT))[0, 0] < 0.5)
    share = _joined(alike.cpu().numpy(), hole, face)
    if share is None:
        return None
    share = F.avg_pool2d(torch.from_numpy(share).to(seen)[None, None], 3, 1, 1, count_include_pad=False)
    return FaceCovering(share, contrast)


def _alike(seen: torch.Tensor, at: torch.Tensor, contrast: torch.Tensor) -> torch.Tensor | None:
    """Where log colours (1, 3, S, S) are those of a place (S, S), bool, (S, S) bool; None if these are the skin's.

    Args:
        contrast: (3,) logs of the place's colour over the skin's.
    """
    other = float((contrast - contrast[1]).abs().max())
    brighter = float(contrast.mean().abs())
    if other < _OTHER_COLOUR and brighter < _OTHER_BRIGHTNESS:
        return None
    apart = seen - middle_values(seen, at)
    ratios, brightness = (apart - apart[:, 1:2]).abs().amax(1)[0], apart.mean(1).abs()[0]
    least = _BRIGHTNESS_OF_COLOURED if other > _COLOURED else _LEAST_BRIGHTNESS
    return (ratios < max(_ALIKE * other, _LEAST_RATIOS)) & (brightness < max(_ALIKE * brighter, least))


def _outline(parsing: torch.Tensor) -> np.ndarray | None:
    """The convex hull (S, S), bool, of the largest patch that is face; None if there is none."""
    patch = largest_part((share_of(parsing, PAPER_CLASSES)[0, 0] > 0.5).cpu().numpy())
    if patch is None:
        return None
    corners = cv2.convexHull(cv2.findNonZero(patch))
    return cv2.fillConvexPoly(np.zeros_like(patch), corners, 1).astype(bool)


def _hole(parsing: torch.Tensor, face: np.ndarray) -> np.ndarray | None:
    """The largest background (S, S), bool, well within a face's outline; None if there is next to none."""
    area = int(face.sum())
    within = cv2.erode(face.astype(np.uint8), disc(_RIM * area**0.5)) > 0
    background = (parsing[0, INDEX["background"]] > 0.5).cpu().numpy() & within
    hole = largest_part(cv2.morphologyEx(background.astype(np.uint8), cv2.MORPH_OPEN, disc(1)), _LEAST * area)
    return None if hole is None else hole > 0


def _joined(alike: np.ndarray, hole: np.ndarray, face: np.ndarray) -> np.ndarray | None:
    """What is connected to a hole and of its colour, without gaps, (S, S) bool; None if that is next to nothing.

    What reaches farther beyond the face's outline than within it is more than the thing, such as a wall of its colour.
    """
    thing = connected_to((alike | hole).astype(np.float32), hole) > 0
    if (thing & ~face).sum() >= (thing & face).sum():
        thing = connected_to((thing & face).astype(np.float32), hole) > 0
    return thing if thing.any() else None
