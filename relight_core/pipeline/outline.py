"""Which pixels of a photo belong to a person, as the person network sees them."""

from __future__ import annotations

import numpy as np
import torch

from relight_core.face.crop import Crop
from relight_core.face.person_view import face_in_view, inside_photo, person_view
from relight_core.imaging.colour import srgb_encode
from relight_core.imaging.photo import Photo
from relight_core.networks.bundle import NetworkBundle
from relight_core.pipeline.stages import in_precision

_SIZE = 256


@torch.inference_mode()
def outline_person(bundle: NetworkBundle, photo: Photo, crop: Crop, device: str) -> tuple[np.ndarray, Crop]:
    """Probability of person in the view about a face.

    Args:
        bundle: with a person network.
        crop: the paper's crop of the face (section 3.2).

    Returns:
        (256, 256) float32 in [0, 1], and where in the photo it lies.
    """
    size = photo.linear.shape[:2]
    view = person_view(crop, size)
    inside = inside_photo(view, size, _SIZE)
    seen = srgb_encode(np.clip(view.extract(photo.linear, _SIZE), 0, 1)) * inside[..., None]
    planes = np.dstack([seen, inside, face_in_view(view, crop, _SIZE)]).astype(np.float32)
    stacked = torch.from_numpy(planes).permute(2, 0, 1)[None].to(device)
    logits = in_precision(bundle, device).person(stacked[:, :3], stacked[:, 3:4], stacked[:, 4:])
    return torch.sigmoid(logits)[0, 0].cpu().numpy(), view
