"""The colours of glowing bodies are those that tables have."""

import numpy as np
import pytest

from relight_core.lighting.colour_temperature import kelvin_to_rgb

REC709 = np.array([0.2126, 0.7152, 0.0722])
FROM_XYZ = np.array(
    [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
)
PLANCKIAN_XY = {
    2000: (0.5267, 0.4133),
    2500: (0.4770, 0.4137),
    3000: (0.4369, 0.4041),
    3500: (0.4053, 0.3907),
    4000: (0.3805, 0.3768),
    4500: (0.3608, 0.3636),
    5000: (0.3451, 0.3516),
    6000: (0.3221, 0.3318),
    7000: (0.3064, 0.3166),
    10000: (0.2807, 0.2884),
}
"""Chromaticities (CIE 1931) of black bodies, after Wyszecki and Stiles."""


def seen(kelvin):
    x, y = PLANCKIAN_XY[kelvin]
    return FROM_XYZ @ [x / y, 1.0, (1 - x - y) / y]


@pytest.mark.parametrize("white_kelvin", [3500, 6000])
@pytest.mark.parametrize("kelvin", sorted(PLANCKIAN_XY))
def test_a_body_has_its_tabulated_colour_in_a_camera_that_is_balanced_for_another(kelvin, white_kelvin):
    balanced = seen(kelvin) / seen(white_kelvin)
    expected = balanced / (balanced @ REC709)
    np.testing.assert_allclose(kelvin_to_rgb(kelvin, white_kelvin), expected, rtol=0.01, atol=0.001)


def test_hotter_bodies_are_bluer_all_the_way_and_all_have_a_luminance_of_one():
    colours = np.array([kelvin_to_rgb(kelvin) for kelvin in np.linspace(1667, 25000, 500)])
    assert colours.min() >= 0
    np.testing.assert_allclose(colours @ REC709, 1.0, rtol=1e-9)
    red, _, blue = np.diff(colours, axis=0).T
    assert red.max() < 0
    assert blue.min() > -1e-6
    assert np.abs(np.diff(colours, axis=0)).max() < 0.1
