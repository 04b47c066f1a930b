"""The colour of a black body, as a camera sees it whose white balance is set to another temperature."""

from __future__ import annotations

import numpy as np

from relight_core.imaging.colour import REC709_LUMINANCE

COOLEST_KELVIN = 1667.0
HOTTEST_KELVIN = 25000.0
WHITE_KELVIN = 5600.0
"""The default white balance: this temperature comes out grey."""

_XYZ_TO_REC709 = np.array(
    [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.9692660, 1.8760108, 0.0415560],
        [0.0556434, -0.2040259, 1.0572252],
    ]
)


def kelvin_to_rgb(kelvin: float, white_balance_kelvin: float = WHITE_KELVIN) -> np.ndarray:
    """Linear Rec.709 colour of a black body, of luminance 1.

    Args:
        kelvin: temperature of the lamp, [1667, 25000].
        white_balance_kelvin: temperature that comes out grey, same range.

    Returns:
        (3,) float64, each at least 0.

    Raises:
        ValueError: a temperature out of range.
    """
    balanced = _black_body(kelvin) / _black_body(white_balance_kelvin)
    return balanced / (balanced @ REC709_LUMINANCE)


def _black_body(kelvin: float) -> np.ndarray:
    """Linear Rec.709 of the Planckian locus (cubic fit of Kim et al. 2002, US patent 7024034)."""
    if not COOLEST_KELVIN <= kelvin <= HOTTEST_KELVIN:
        raise ValueError(f"{kelvin} K is not between {COOLEST_KELVIN:g} and {HOTTEST_KELVIN:g} K")
    inverse = 1e3 / kelvin
    if kelvin <= 4000:
        x = np.polyval([-0.2661239, -0.2343589, 0.8776956, 0.179910], inverse)
    else:
        x = np.polyval([-3.0258469, 2.1070379, 0.2226347, 0.240390], inverse)
    if kelvin <= 2222:
        y = np.polyval([-1.1063814, -1.34811020, 2.18555832, -0.20219683], x)
    elif kelvin <= 4000:
        y = np.polyval([-0.9549476, -1.37418593, 2.09137015, -0.16748867], x)
    else:
        y = np.polyval([3.0817580, -5.87338670, 3.75112997, -0.37001483], x)
    rgb = _XYZ_TO_REC709 @ np.array([x / y, 1.0, (1 - x - y) / y])
    return np.maximum(rgb, 1e-4)
