"""Which pixels of a photo belong to a person, according to the person network."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import torch

from relight_core.face.crop import Crop
from relight_core.face.parsing import INDEX, PAPER_CLASSES, share_of
from relight_core.face.person_view import face_in_view, inside_photo
from relight_core.face.silhouette import person_with_headwear, rows_above_the_eyes
from relight_core.imaging.colour import srgb_encode
from relight_core.imaging.photo import Photo
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_images import as_tensor
from relight_core.networks.bundle import NetworkBundle
from relight_core.pipeline.per_photo.likely_person import closed
from relight_core.pipeline.per_photo.network_view import in_picture, network_view, picture_size
from relight_core.pipeline.stages import in_precision

_SIZE = 256
"""Side of the view that the person network sees, in pixels."""
_SURELY = 0.005
"""Probabilities are kept at least so far from 0 and 1, so that odds stay finite."""
_OUTLINE_SHARE, _OUTLINE_SHARE_OF_HATS = 0.8, 0.4
"""Weight of the person network's log odds in the mean with the parsing's: usually, and where the parsing clearly sees a
hat."""
_PERHAPS_HAT, _PLAINLY_HAT = 0.5, 0.95
"""Ramp of the parsing's probability of hat between these two weights."""
_HARDLY_HAT, _MAYBE_HAT = 0.2, 0.4
"""Ramp of that probability over which a gap in the outline becomes a hair band."""
_OPEN, _ENCLOSED, _GAP = 0.3, 0.5, 0.2
"""A gap is enclosed if the faintest probability around it ramps from the first to the second, and exceeds the gap's by
the third."""


@dataclass(frozen=True, eq=False)
class Outline:
    """The probability of a person in a part of a photo.

    Attributes:
        likely: (S, S) float32 in [0, 1].
        view: where in the photo it lies.
    """

    likely: np.ndarray
    view: Crop

    def seen_in(self, view: Crop, size: int) -> tuple[np.ndarray, np.ndarray]:
        """The probability in another view, and the share of each pixel that is known, (size, size) in [0, 1] each."""
        return _moved(self.likely, self.view, view, size)

    def corrected(self, likely: np.ndarray, view: Crop) -> Outline:
        """The outline with its probability replaced by another, (s, s), within that one's view."""
        known_likely, known = _moved(likely, view, self.view, len(self.likely))
        return Outline(known * known_likely + (1 - known) * self.likely, self.view)

    def agreed(self, other: Outline) -> Outline:
        """The outline with its log odds averaged with another's, within the other's view."""
        likely, known = other.seen_in(self.view, len(self.likely))
        return Outline(_mean_odds(self.likely, likely, known / 2).astype(np.float32), self.view)


def _moved(image: np.ndarray, view: Crop, other: Crop, size: int) -> tuple[np.ndarray, np.ndarray]:
    """An image (s, s) of one view resampled in another, (size, size), and the share of each pixel that it covers."""
    corners = np.array([[0.0, 0.0], [size, 0.0], [0.0, size]])
    source = view.from_photo(other.to_photo(corners, size), len(image))
    matrix = cv2.getAffineTransform((source - 0.5).astype(np.float32), (corners - 0.5).astype(np.float32))
    both = np.dstack([image, np.ones_like(image)]).astype(np.float32)
    moved = cv2.warpAffine(both, matrix, (size, size), flags=cv2.INTER_LINEAR)
    return moved[..., 0] / np.maximum(moved[..., 1], 1e-3), moved[..., 1]


@torch.inference_mode()
def outline_person(
    bundle: NetworkBundle,
    photo: Photo,
    crop: Crop,
    view: Crop,
    device: str,
    mirrors: Sequence[bool] = (False,),
    exposure: float = 1.0,
) -> Outline:
    """The outline of the person whose face is in a crop, within a view.

    Args:
        bundle: with a person network.
        photo: of the person.
        crop: the paper's crop of the face (section 3.2).
        view: around that crop (see `face.person_view`).
        device: of the networks.
        mirrors: one entry for each run of the network, whether on the mirrored view; log odds are averaged.
        exposure: of the portrait.
    """
    inside = inside_photo(in_picture(photo, view), picture_size(photo), _SIZE)
    seen = srgb_encode(np.clip(network_view(photo, view, _SIZE, exposure), 0, 1)) * inside[..., None]
    planes = np.dstack([seen, inside, face_in_view(view, crop, _SIZE)]).astype(np.float32)
    stacked = torch.cat([_mirrored_if(as_tensor(planes, device), mirror) for mirror in mirrors])
    logits = in_precision(bundle, device).person(stacked[:, :3], stacked[:, 3:4], stacked[:, 4:])
    aligned = torch.stack([_mirrored_if(look, mirror) for look, mirror in zip(logits, mirrors, strict=True)])
    return Outline(torch.sigmoid(aligned.mean(0))[0].cpu().numpy(), view)


def _mirrored_if(image: torch.Tensor, mirror: bool) -> torch.Tensor:
    return image.flip(-1) if mirror else image


def parsing_within(parsing: torch.Tensor, outline: Outline, view: Crop) -> torch.Tensor:
    """A parsing with its background corrected by an outline; the other classes keep their proportions.

    De-lighting's parsing and the person network make different errors. The parsing sees the head larger and knows hair
    and hats; the person network sees shoulders, was trained on more backgrounds, and has no other task. So:

    - Their log odds are averaged, with more weight on the person network.
    - What the parsing takes for a face remains one.
    - Above the eyes, the lower probability limits the mean: a tree or a window right behind a head is often taken for
      hair or a hat by one of them, but seldom by both.
    - Where the parsing clearly sees a hat there, it has more weight: the person network takes the wide top of a cap for
      something behind the cap's band.
    - A gap between a head and the hair above it is closed where the parsing sees a hat, which is a hair band.

    Args:
        parsing: (1, classes, S, S) probabilities in a view of the photo.
        outline: of the person.
        view: of the parsing.
    """
    found = parsing[0].cpu().numpy()
    by_parsing = person_with_headwear(found)
    likely, known = outline.seen_in(view, parsing.shape[-1])
    mean = _mean_odds(by_parsing, likely, _OUTLINE_SHARE)
    worn = ramp(found[INDEX["hat"]], _HARDLY_HAT, _MAYBE_HAT)
    likely = likely + worn * _enclosed(likely) * np.maximum(by_parsing - likely, 0)
    agreed = np.minimum(_mean_odds(by_parsing, likely, _OUTLINE_SHARE), np.minimum(by_parsing, likely))
    hat = ramp(found[INDEX["hat"]], _PERHAPS_HAT, _PLAINLY_HAT)
    agreed += hat * np.maximum(_mean_odds(by_parsing, likely, _OUTLINE_SHARE_OF_HATS) - agreed, 0)
    mean = mean + rows_above_the_eyes(found) * (agreed - mean)
    both = known * mean + (1 - known) * by_parsing
    person = torch.from_numpy(both.astype(np.float32)).to(parsing.device)[None, None]
    person = torch.maximum(person, share_of(parsing, PAPER_CLASSES))
    others = parsing[:, 1:] + 1e-4 * _by_default(parsing)
    return torch.cat([1 - person, person * others / others.sum(1, keepdim=True)], 1)


def _enclosed(likely: np.ndarray) -> np.ndarray:
    """Certainty that a probability (S, S) has a gap that a person encloses, (S, S) in [0, 1]."""
    around = closed(likely)
    return ramp(around, _OPEN, _ENCLOSED) * ramp(around - likely, 0, _GAP)


def _mean_odds(first: np.ndarray, second: np.ndarray, share: float | np.ndarray) -> np.ndarray:
    """The probability whose log odds are the mean of two others', with a weight `share`, in [0, 1], on the second."""
    first, second = (np.clip(p, _SURELY, 1 - _SURELY) for p in (first, second))
    mean = (first / (1 - first)) ** (1 - share) * (second / (1 - second)) ** share
    return mean / (1 + mean)


def _by_default(parsing: torch.Tensor) -> torch.Tensor:
    """The classes of a person where nothing is known, (1, classes - 1, 1, 1): cloth."""
    default = torch.zeros(1, parsing.shape[1] - 1, 1, 1, device=parsing.device)
    default[:, INDEX["cloth"] - 1] = 1
    return default
