"""What a garment is: an opaque mesh in the head's own frame with a label."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Garment:
    """Something worn on a head, ready for a ray caster that knows no transparency.

    Attributes:
        vertices: (V, 3) float32, centimetres, the frame of the head before its pose is applied
            (face toward +z, +y up).
        faces: (F, 3) int32.
        uv: (V, 2) float32 in [0, 1], v upward.
        label: one of "hair", "glasses", "hat", "cloth", "brow", "lash", "neck", the last for other bare skin too.
        opacity: (h, w) uint8 or None; faces where it is low are already gone from `faces`.
        colour_srgb: (h, w, 3) uint8 encoded colour, or None.
        name: which item it is, for records and previews.
        made_of: "trim" where it is of another stuff than the rest of its label (a hatband, a badge), or the label
            whose stuff it is (the cloth of a headscarf below the chin is the hat's); None for its own label's.
    """

    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    label: str
    opacity: np.ndarray | None = None
    colour_srgb: np.ndarray | None = None
    name: str = ""
    made_of: str | None = None
