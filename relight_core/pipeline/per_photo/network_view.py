"""What the networks see of a photo."""

from __future__ import annotations

import numpy as np

from relight_core.face.crop import Crop
from relight_core.imaging.colour import without_colour
from relight_core.imaging.photo import Photo


def network_view(photo: Photo, view: Crop, size: int, exposure: float) -> np.ndarray:
    """A view (size, size, 3) of a photo, linear; see `as_networks_see`."""
    return as_networks_see(view.extract(photo.seen.linear, size), photo.monochrome, exposure)


def as_networks_see(view: np.ndarray, monochrome: bool, exposure: float) -> np.ndarray:
    """A view (S, S, 3) of a photo (a cut-out before grey), linear: a toned photo as the grey one it was, exposed."""
    seen = without_colour(view) if monochrome else view
    return seen if exposure == 1.0 else seen * np.float32(exposure)
