"""What perfect de-lighting would find of a held-out head."""

from __future__ import annotations

import numpy as np
import torch

from relight_core.evaluation.held_out import HeldOutHead, HeldOutLight
from relight_core.face.parsing import CLASSES
from relight_core.imaging.resampling import resize_area
from relight_core.imaging.tensor_images import as_tensor
from relight_core.imaging.tensor_normals import unit_normals
from relight_core.pipeline.stages import Surface


def true_surface(head: HeldOutHead, light: HeldOutLight, size: int, device: str) -> Surface:
    """The true surface at a side of `size` pixels, of a photo under a light; the photo itself is left black."""

    def tensor(image: np.ndarray) -> torch.Tensor:
        return as_tensor(resize_area(image, (size, size)), device)

    truth = head.surface()
    person = tensor(truth["covered"])
    # What is 0 outside the head has no say in its outline: 0 is the height of the face's middle.
    covered = person.clamp_min(1e-6)
    normal = unit_normals(tensor(truth["normal"]))
    return Surface(
        photo=torch.zeros_like(normal),
        albedo=tensor(truth["albedo"]) / covered,
        normal=normal,
        relief=tensor(truth["relief"]) / covered,
        parsing=tensor(np.eye(len(CLASSES), dtype=np.float32)[truth["label"]]),
        person=person,
        source_light=torch.from_numpy(light.radiance)[None].to(device),
    )
