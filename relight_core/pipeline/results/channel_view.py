"""How each channel is shown: linear data to a picture, on the CPU."""

from __future__ import annotations

import numpy as np

from relight_core.face.parsing import PALETTE_SRGB
from relight_core.imaging.view_transform import apply_view

_SPECULAR_GAIN = 4.0
_SHADOW_GAIN = 2.0


def channel_to_srgb(name: str, array: np.ndarray) -> np.ndarray:
    """A channel of `Relit.channels` as (h, w, 3) float32 sRGB in [0, 1].

    Normals as (n + |n|) / 2, black where there is no surface and so no normal, parsing in its palette, effects
    amplified to be seen, lights compressed by x / (1 + x) since their range has no end, everything else through the
    view transform.
    """
    if name == "normal":
        normal = np.clip(np.nan_to_num(array), -1, 1)
        length = np.linalg.norm(normal, axis=-1, keepdims=True)
        return np.clip((normal + length) / 2, 0, 1).astype(np.float32)
    if name == "parsing":
        return (np.array(PALETTE_SRGB, np.float32) / 255)[np.clip(array, 0, len(PALETTE_SRGB) - 1)]
    if name in ("source_light", "target_light"):
        light = np.maximum(np.nan_to_num(array), 0)
        return apply_view((light / (1 + light)).astype(np.float32))
    gain = {"specular": _SPECULAR_GAIN, "shadow": _SHADOW_GAIN}.get(name, 1.0)
    image = array[..., None].repeat(3, -1) if array.ndim == 2 else array
    return apply_view(np.ascontiguousarray(image * gain, np.float32))
