"""From scene radiance to the screen. shaders/view_transform.glsl is the same function for the GPU.

A colour the screen can show is shown as it is, so a photo comes back as itself. A brighter one keeps its
hue: it is scaled until its largest channel is 1 and then mixed with white by as much as keeps its
luminance at first, easing off so that white is only reached in the limit. Clipping each channel by
itself would turn bright skin yellow.
"""

from __future__ import annotations

import numpy as np

from relight_core.imaging.colour import REC709_LUMINANCE, srgb_encode
from relight_core.imaging.half_floats import LARGEST_HALF

LARGEST_FLOAT = float(np.finfo(np.float32).max)

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
    encoded = srgb_encode(displayable(expose(linear, exposure_ev)))
    return np.clip(encoded, 0.0, 1.0, out=encoded)


def displayable(exposed: np.ndarray, weights: np.ndarray = REC709_LUMINANCE) -> np.ndarray:
    """Exposed radiance as a display has it, before its transfer curve; changed in place and returned.

    Args:
        exposed: (..., 3) float32, [0, inf), in the display's primaries.
        weights: (3,) what those add to luminance.

    Returns:
        (..., 3) linear, [0, 1].
    """
    if exposed.size and exposed.max() > 1.0:
        # A maximum along an axis of three takes numpy ten times as long.
        peak = np.maximum(np.maximum(exposed[..., 0], exposed[..., 1]), exposed[..., 2])
        over = peak > 1.0
        exposed[over] = _into_range(exposed[over], peak[over], weights.astype(np.float32))
    return exposed


def expose(
    linear: np.ndarray, exposure_ev: float, *, darkest: float = 0.0, brightest: float = LARGEST_HALF
) -> np.ndarray:
    """Radiance times 2 ** exposure_ev, cleaned of NaN and infinite values and limited.

    Args:
        darkest: 0, or -brightest to keep colours outside Rec.709.
        brightest: finite; `LARGEST_FLOAT` keeps all that float32 holds.

    Returns:
        a new float32 array.
    """
    stops = min(max(float(np.nan_to_num(exposure_ev)), -MAX_EXPOSURE_EV), MAX_EXPOSURE_EV)
    cleaned = np.array(linear, np.float32, order="C")
    # NaN compares as neither.
    if cleaned.size and not (cleaned.min() >= darkest and cleaned.max() <= brightest):
        np.nan_to_num(cleaned, copy=False, nan=0.0, posinf=brightest, neginf=darkest)
        np.clip(cleaned, np.float32(darkest), np.float32(brightest), out=cleaned)
    if stops == 0:
        return cleaned
    with np.errstate(over="ignore"):
        cleaned *= np.float32(2.0**stops)
    return np.clip(cleaned, np.float32(darkest), np.float32(brightest), out=cleaned)


def _into_range(linear: np.ndarray, peak: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """(N, 3) colours whose largest channel `peak` (N,) is above 1, brought to [0, 1]."""
    scaled = linear / peak[:, None]
    dimmed = scaled @ weights
    missing = dimmed * (peak - 1.0) / np.maximum(1.0 - dimmed, np.float32(1e-4))
    white = -np.expm1(-missing)[:, None]
    return scaled + (1.0 - scaled) * white
