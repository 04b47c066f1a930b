"""What the networks see of a photo."""

from __future__ import annotations

import numpy as np

from relight_core.face.crop import Crop
from relight_core.imaging.colour import without_colour
from relight_core.imaging.photo import Photo


def network_view(photo: Photo, view: Crop, size: int) -> np.ndarray:
    """A view (size, size, 3) of a photo, linear: a cut-out before grey, a toned photo as the grey one it was."""
    seen = view.extract(photo.seen.linear, size)
    return without_colour(seen) if photo.monochrome else seen
