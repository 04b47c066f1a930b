"""Which pixels of a photo belong to a person, as the person network sees them."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import torch

from relight_core.face.crop import Crop
from relight_core.face.parsing import FACE_LABELS, INDEX
from relight_core.face.person_view import face_in_view, inside_photo, person_view
from relight_core.imaging.colour import srgb_encode
from relight_core.imaging.photo import Photo
from relight_core.networks.bundle import NetworkBundle
from relight_core.pipeline.stages import in_precision

_SIZE = 256


@dataclass(frozen=True, eq=False)
class Outline:
    """A person in a photo.

    Attributes:
        likely: (S, S) float32 in [0, 1], probability of person.
        view: where in the photo that lies.
    """

    likely: np.ndarray
    view: Crop

    def seen_in(self, view: Crop, size: int) -> tuple[np.ndarray, np.ndarray]:
        """Probability (size, size) in another view of the photo, and how much of it is known there, both in [0, 1]."""
        corners = np.array([[0.0, 0.0], [size, 0.0], [0.0, size]])
        matrix = cv2.getAffineTransform(
            self.view.from_photo(view.to_photo(corners, size), len(self.likely)).astype(np.float32) - 0.5,
            corners.astype(np.float32) - 0.5,
        )
        both = np.dstack([self.likely, np.ones_like(self.likely)])
        moved = cv2.warpAffine(both, matrix, (size, size), flags=cv2.INTER_LINEAR)
        return moved[..., 0] / np.maximum(moved[..., 1], 1e-3), moved[..., 1]


@torch.inference_mode()
def outline_person(bundle: NetworkBundle, photo: Photo, crop: Crop, device: str) -> Outline:
    """The person whose face lies in a crop.

    Args:
        bundle: with a person network.
        crop: the paper's crop of the face (section 3.2).
    """
    size = photo.linear.shape[:2]
    view = person_view(crop, size)
    inside = inside_photo(view, size, _SIZE)
    seen = srgb_encode(np.clip(view.extract(photo.linear, _SIZE), 0, 1)) * inside[..., None]
    planes = np.dstack([seen, inside, face_in_view(view, crop, _SIZE)]).astype(np.float32)
    stacked = torch.from_numpy(planes).permute(2, 0, 1)[None].to(device)
    logits = in_precision(bundle, device).person(stacked[:, :3], stacked[:, 3:4], stacked[:, 4:])
    return Outline(torch.sigmoid(logits)[0, 0].cpu().numpy(), view)


def parsing_within(parsing: torch.Tensor, outline: Outline, view: Crop) -> torch.Tensor:
    """A parsing whose background is what the outline leaves out: its other classes share the rest as they did.

    De-lighting sees little more than the head, and learns fourteen classes beside albedo and shape; what it takes
    for a face stays one.

    Args:
        parsing: (1, classes, S, S) probabilities in a view of the photo.
    """
    likely, known = (torch.from_numpy(p).to(parsing)[None, None] for p in outline.seen_in(view, parsing.shape[-1]))
    background = parsing[:, :1]
    person = torch.maximum(likely * known + (1 - background) * (1 - known), parsing[:, list(FACE_LABELS)].sum(1, True))
    others = parsing[:, 1:] + 1e-4 * _by_default(parsing)
    return torch.cat([1 - person, person * others / others.sum(1, keepdim=True)], 1)


def _by_default(parsing: torch.Tensor) -> torch.Tensor:
    """What a person is where nothing else is known: (1, classes - 1, 1, 1)."""
    default = torch.zeros(1, parsing.shape[1] - 1, 1, 1, device=parsing.device)
    default[:, INDEX["cloth"] - 1] = 1
    return default
