"""Masks over mouth and nose or about the eyes, scarves, and cups, which de-lighting takes for skin in coloured light.

The networks know no masks. They parse one as skin and explain its colour by the light: beside a red mask the rest of
the face turned green, and in any other light a white one looked like pink skin. But where a mouth should be, no light
gives all of a face a colour that its forehead doesn't have, and hides the lips as well. Nor does one colour temples and
the bridge of the nose between them, but neither forehead nor cheeks. Such an area is a covering, or paint. It is given
the skin's colour before the face is de-lit again, and is cloth of its own colour afterwards.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
import torch
import torch.nn.functional as F

from relight_core.face.parsing import BROWS, EYES, FEWEST_PIXELS, INDEX, MOUTH, SURELY, likely, share_of
from relight_core.imaging.masks import part_at
from relight_core.imaging.ramp import ramp
from relight_core.imaging.resampling import resize_area
from relight_core.imaging.tensor_images import as_image, as_tensor, resized
from relight_core.imaging.tensor_logs import exact_logs
from relight_core.imaging.tensor_means import middle_values
from relight_core.pipeline.stages import Surface, reparsed

FEWEST_EYE_PIXELS = 4
"""Pixels of each eye that are needed to know its place."""
_FOREHEAD, _MOUTH, _AROUND_MOUTH = 0.15, 1.15, 0.3
"""Distances below the middle of the eyes, in distances between the eyes: plain skin is above the first, a mouth's
middle is at the second, and all within a third number of that is mouth."""
_REACHES = (0.05, 2.3), 1.4
"""How far a covering may extend, in the same unit: from and to below the eyes, and to each side."""
_OFF = (0.35, 0.45)
"""Ramp of the difference from the forehead's colour, in log ratios to green, over which skin becomes a covering. In 33
faces a tenth of the area about the mouth is within 0.25 of it; under drawn masks none is within 0.5."""
_MOST = 0.75
"""This share of the area about the mouth must have another colour. A cup at the lips leaves skin above them bare."""
_LIPS = 0.17
"""Largest area of lips and inner mouth, in squares of the distance between the eyes. Faces have 0.2 to 0.6; what the
parsing guesses under masks is 0.13 at most."""
_REACH_PX = 2
"""Gaps in a covering up to twice as wide belong to it; strips of skin in another colour beside it are as narrow."""
_BESIDE = (*EYES, *BROWS, "hair", "hat", "glasses", "cloth")
"""Classes of what may lie beside a mask over the mouth in other colours than skin."""
_CHEEKS = (0.55, 1.9), 0.8
_BROW = -0.75
"""Plain skin is between the first distances below the eyes, and within another number to each side; and, but for hats,
above the third."""
_BAND = (-0.3, 0.28), 0.85
"""A mask about the eyes covers most of this, in the same units."""
_EYE = (0.5, 0.3, 0.22)
"""How far an eye's middle is aside, and half its hole's width and height."""
_BRIDGE = 0.2
_MOST_OF_BAND, _FEW = 0.7, 0.3
"""Shares of each temple and of the bridge that must have another colour than the cheeks, and of the cheeks that may.
Under drawn masks it is 0.77 and more of all three; of 17 faces it is 0.34 at most of one of them, in tinted glasses 0.2
of the bridge."""
_MOST_OF_BROW = 0.6
"""Share of the forehead that may: a brim's shadow colours that too."""
_REACHES_ABOUT_EYES = (-0.7, 0.6), 1.4
_BESIDE_EYES = (*EYES, "hair", "hat", "cloth")
"""Classes of what may lie beside a mask about the eyes. The parsing guesses brows on one, and takes it for glasses."""


@dataclass(frozen=True, eq=False)
class FaceCovering:
    """A mask over mouth and nose, or something else before them.

    Attributes:
        share: (1, 1, S, S) in [0, 1], where it is.
        contrast: (3,) logs of its colour over that of bare skin in the same light.
    """

    share: torch.Tensor
    contrast: torch.Tensor

    def taken_off(self, view: np.ndarray) -> np.ndarray:
        """A view (D, D, 3), linear, with the covering in the colour of skin."""
        return np.clip(view / as_image(self._gain(len(view)).expand(1, 3, -1, -1)), 0, 1)

    def put_on(self, surface: Surface, view: np.ndarray) -> Surface:
        """The surface of that, with the covering as cloth of its own colour.

        Args:
            surface: of the view without the covering.
            view: (D, D, 3) linear, with it.
        """
        size = surface.parsing.shape[-1]
        photo = as_tensor(resize_area(np.clip(view, 0, 1), (size, size)), surface.photo.device)
        parsing = surface.parsing * (1 - self.share)
        parsing[:, INDEX["cloth"], None] += self.share
        return replace(reparsed(surface, parsing), photo=photo, albedo=(surface.albedo * self._gain(size)).clamp(0, 1))

    def _gain(self, size: int) -> torch.Tensor:
        return torch.exp(resized(self.share, size) * self.contrast[:, None, None])


@torch.inference_mode()
def find_face_covering(surface: Surface) -> FaceCovering | None:
    """The covering of a face; None if there is none, or too little of the eyes or of plain skin is seen to tell."""
    place = _below_the_eyes(surface.parsing)
    if place is None:
        return None
    lips = float(share_of(surface.parsing, MOUTH).sum()) / place.apart_px**2
    return _about_the_eyes(surface, place) if lips > _LIPS else _over_the_mouth(surface, place)


def _over_the_mouth(surface: Surface, place: _Place) -> FaceCovering | None:
    """What hides the lips, by its difference from the colour of the forehead."""
    bare = plain_skin(surface) & (place.below < _FOREHEAD)
    if int(bare.sum()) < FEWEST_PIXELS:
        return None
    seen = _seen_of_person(surface)
    off = ramp(_off_colour(seen, bare), *_OFF)
    mouth = place.across**2 + (place.below - _MOUTH) ** 2 < _AROUND_MOUTH**2
    if not _off_over(off, mouth, _MOST):
        return None
    return _covering(surface, seen, off * place.within(*_REACHES), _BESIDE, mouth, bare)


def _about_the_eyes(surface: Surface, place: _Place) -> FaceCovering | None:
    """What has another colour than the cheeks at both temples and between them, but not at the forehead."""
    bare = plain_skin(surface) & place.within(*_CHEEKS)
    if int(bare.sum()) < FEWEST_PIXELS:
        return None
    seen = _seen_of_person(surface)
    off = ramp(_off_colour(seen, bare), *_OFF)
    aside, wide, high = _EYE
    eye = ((place.across.abs() - aside) / wide) ** 2 + (place.below / high) ** 2 < 1
    hidden = likely(share_of(surface.parsing, ("hair", "hat", "background")))[0, 0] > 0.5
    band = place.within(*_BAND) & ~eye & ~hidden
    parts = band & (place.across < -_BRIDGE), band & (place.across > _BRIDGE), band & (place.across.abs() < _BRIDGE)
    if not all(_off_over(off, part, _MOST_OF_BAND) for part in parts):
        return None
    forehead = plain_skin(surface) & (place.below < _BROW)
    if _off_over(off, forehead, _MOST_OF_BROW) or _off_over(off, bare, _FEW):
        return None
    return _covering(surface, seen, off * place.within(*_REACHES_ABOUT_EYES), _BESIDE_EYES, band, bare)


def _covering(
    surface: Surface,
    seen: torch.Tensor,
    off: torch.Tensor,
    beside: tuple[str, ...],
    at: torch.Tensor,
    bare: torch.Tensor,
) -> FaceCovering | None:
    """What is off (S, S) the colour of bare skin, connected to a place (S, S), bool; None if that is next to nothing.

    Args:
        seen: log colours (1, 3, S, S) of the person.
        beside: classes that don't belong to it.
    """
    allowed = (surface.person * (1 - likely(share_of(surface.parsing, beside))))[0, 0]
    share = torch.from_numpy(connected_to((off * allowed).cpu().numpy(), at.cpu().numpy())).to(off)
    share = share * (1 - likely(share_of(surface.parsing, EYES)))[0, 0]
    sure = share > SURELY
    if int(sure.sum()) < FEWEST_PIXELS:
        return None
    contrast = middle_values(seen, sure) - middle_values(seen, bare)
    return FaceCovering(share[None, None], contrast.flatten())


def plain_skin(surface: Surface) -> torch.Tensor:
    """What is surely bare skin of the face, (S, S) bool."""
    return surface.parsing[0, INDEX["skin"]] > SURELY


def _off_over(off: torch.Tensor, part: torch.Tensor, share: float) -> bool:
    """Whether at least a share of a part (S, S), bool, has another colour; never of one that isn't there."""
    return bool(part.any()) and float((off > 0)[part].float().mean()) >= share


def _seen_of_person(surface: Surface) -> torch.Tensor:
    """Log colours (1, 3, S, S), each the mean over 3 x 3 pixels: in single pixels, black cloth's colours are noise.

    What is behind the person doesn't count, so that a jaw's edge doesn't have the colour of a wall.
    """

    def mean(image: torch.Tensor) -> torch.Tensor:
        return F.avg_pool2d(image, 3, 1, 1, count_include_pad=False)

    return exact_logs(mean(surface.photo * surface.person) / mean(surface.person).clamp_min(1e-3))


def _off_colour(seen: torch.Tensor, bare: torch.Tensor) -> torch.Tensor:
    """How far log colours (1, 3, S, S) are from those of bare skin (S, S), bool, in log ratios to green, (S, S)."""
    ratios = seen - seen[:, 1:2]
    return (ratios - middle_values(ratios, bare)).abs().amax(1)[0]


@dataclass(frozen=True, eq=False)
class _Place:
    """Where each pixel is relative to the eyes: across and below their middle, (S, S) each, in distances between them.

    Attributes:
        apart_px: that distance in pixels.
    """

    across: torch.Tensor
    below: torch.Tensor
    apart_px: float

    def within(self, below: tuple[float, float], aside: float) -> torch.Tensor:
        """(S, S) bool: from and to below the eyes, and to each side."""
        return (self.below > below[0]) & (self.below < below[1]) & (self.across.abs() < aside)


def _below_the_eyes(parsing: torch.Tensor) -> _Place | None:
    """Where everything is; None if an eye isn't seen."""
    size = parsing.shape[-1]
    rows, columns = torch.meshgrid(*(torch.arange(size, device=parsing.device).float(),) * 2, indexing="ij")
    places = []
    for name in EYES:
        eye = parsing[0, INDEX[name]]
        if float(eye.sum()) < FEWEST_EYE_PIXELS:
            return None
        places.append(torch.stack([(eye * columns).sum(), (eye * rows).sum()]) / eye.sum())
    left, right = places
    apart_px = float((left - right).norm())
    if apart_px < 1:
        return None
    along, middle = (left - right) / apart_px, (left + right) / 2
    x, y = columns - middle[0], rows - middle[1]
    return _Place((x * along[0] + y * along[1]) / apart_px, (y * along[0] - x * along[1]) / apart_px, apart_px)


def connected_to(share: np.ndarray, place: np.ndarray) -> np.ndarray:
    """The part of a share (S, S) that is connected to a place (S, S), bool, without gaps, (S, S)."""
    window = np.ones((2 * _REACH_PX + 1,) * 2, np.uint8)
    share = cv2.morphologyEx(cv2.morphologyEx(share, cv2.MORPH_CLOSE, window), cv2.MORPH_OPEN, window)
    part = part_at(share > 0, place)
    return np.zeros_like(share) if part is None else share * part
