"""From scene radiance to the screen. shaders/view_transform.glsl is the same function for the GPU.

A colour the screen can show is shown as it is, so a photo comes back as itself. A brighter one keeps its
hue: it is scaled until its largest channel is 1 and then mixed with white by as much as keeps its
luminance at first, easing off so that white is only reached in the limit. Clipping each channel by
itself would turn bright skin yellow.
"""

from __future__ import annotations

import numpy as np

from relight_core.imaging.colour import luminance, srgb_encode

BRIGHTEST = 65504.0
"""Radiance above this is shown as this; also what infinity becomes (the largest half float)."""

MAX_EXPOSURE_EV = 32.0
"""Exposure is limited to plus and minus this many stops."""


def apply_view(linear: np.ndarray, exposure_ev: float = 0.0) -> np.ndarray:
    """What the screen and 8- or 16-bit files show of a radiance.

    NaN and negative values show as black, infinity as the brightest value of its channel.

    Args:
        linear: (..., 3) linear Rec.709, [0, inf).
        exposure_ev: stops; the radiance is multiplied by 2 ** exposure_ev.

    Returns:
        (..., 3) float32 sRGB, [0, 1]; at exposure 0 exactly the sRGB curve for colours in [0, 1].
    """
    shown = expose(linear, exposure_ev)
    if shown.size and shown.max() > 1.0:
        # A maximum along an axis of three takes numpy ten times as long.
        peak = np.maximum(np.maximum(shown[..., 0], shown[..., 1]), shown[..., 2])
        over = peak > 1.0
        shown[over] = _into_range(shown[over], peak[over])
    encoded = srgb_encode(shown)
    return np.clip(encoded, 0.0, 1.0, out=encoded)


def expose(linear: np.ndarray, exposure_ev: float) -> np.ndarray:
    """Radiance times 2 ** exposure_ev, cleaned of NaN, negative and infinite values; a new float32 array."""
    stops = min(max(float(np.nan_to_num(exposure_ev)), -MAX_EXPOSURE_EV), MAX_EXPOSURE_EV)
    cleaned = np.array(linear, np.float32, order="C")
    # NaN compares as neither.
    if cleaned.size and not (cleaned.min() >= 0.0 and cleaned.max() <= BRIGHTEST):
        np.nan_to_num(cleaned, copy=False, nan=0.0, posinf=BRIGHTEST, neginf=0.0)
        np.clip(cleaned, 0.0, BRIGHTEST, out=cleaned)
    if stops == 0:
        return cleaned
    cleaned *= np.float32(2.0**stops)
    return np.minimum(cleaned, np.float32(BRIGHTEST), out=cleaned)


def _into_range(linear: np.ndarray, peak: np.ndarray) -> np.ndarray:
    """(N, 3) colours whose largest channel `peak` (N,) is above 1, brought to [0, 1]."""
    scaled = linear / peak[:, None]
    dimmed = luminance(scaled)
    missing = dimmed * (peak - 1.0) / np.maximum(1.0 - dimmed, np.float32(1e-4))
    white = -np.expm1(-missing)[:, None]
    return scaled + (1.0 - scaled) * white
