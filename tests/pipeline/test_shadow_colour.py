"""Shadows between lights of different colours."""

import pytest
import torch

from relight_core.lighting.relief import march_relief
from relight_core.pipeline.per_light.hints import Effects, explicit_sum
from relight_core.pipeline.per_light.shadow_colour import colourfulness, shadow_tint

SIZE = 32
LEFT, RIGHT = 3, 28
RED, BLUE, WHITE = (3.0, 0.1, 0.1), (0.1, 0.1, 3.0), (1.0, 1.0, 1.0)
LUMINANCE = torch.tensor([0.2126, 0.7152, 0.0722])[:, None, None]


def two_lamps(left, right):
    """45 degrees to either side of the camera."""
    light = torch.full((1, 16, 32, 3), 0.05)
    light[:, 7:9, LEFT] = 40 * torch.tensor(left)
    light[:, 7:9, RIGHT] = 40 * torch.tensor(right)
    return light


def bar():
    """A plane with an upright bar in the middle, half as high as the image's half-width."""
    relief, normal = torch.zeros(SIZE, SIZE), torch.zeros(3, SIZE, SIZE)
    relief[:, 15:17], normal[2] = 0.5, 1
    return march_relief(relief, normal, torch.ones(SIZE, SIZE))


def reflected(transport, light):
    irradiance = (transport.open @ light[0].flatten(0, 1)).T.reshape(1, 3, SIZE, SIZE)
    return torch.cat([irradiance, torch.zeros_like(irradiance)], 1)


def found(light):
    transport = bar()
    return shadow_tint(transport, light, reflected(transport, light))


@pytest.mark.parametrize("colour", [WHITE, RED, (0.0, 0.0, 0.0)])
def test_light_of_one_colour_tints_nothing(colour):
    light = two_lamps(WHITE, WHITE) * torch.tensor(colour)
    assert found(light) is None


def test_the_shadow_of_a_red_lamp_is_blue():
    """Left of the bar the right lamp is hidden."""
    tint = found(two_lamps(BLUE, RED))[0, :, SIZE // 2]
    assert tint[0, 12] > 1.2 > 0.6 > tint[2, 12]
    assert tint[2, 19] > 1.1 > 0.6 > tint[0, 19]


def test_the_shadow_of_a_white_lamp_has_the_colour_of_a_weaker_one():
    light = two_lamps(WHITE, (0.3, 0.01, 0.01))
    assert colourfulness(light) < 0.25
    tint = found(light)[0, :, SIZE // 2]
    assert tint[0, 19] < 0.9 * tint[1, 19]


def test_what_is_hidden_in_all_stays():
    transport, light = bar(), two_lamps(BLUE, RED)
    lit = reflected(transport, light)
    albedo, fraction = torch.ones(1, 3, SIZE, SIZE), 0.2
    shadow = fraction * (LUMINANCE * lit[:, :3]).sum(1, keepdim=True)
    effects = Effects(torch.zeros_like(shadow), shadow)
    grey, tinted = (
        (LUMINANCE * explicit_sum(albedo, lit, Effects(effects.specular, shadow, tint))).sum(1)
        for tint in (None, shadow_tint(transport, light, lit))
    )
    torch.testing.assert_close(tinted, grey, rtol=1e-3, atol=1e-3)


def test_a_tint_takes_no_more_than_there_is():
    transport, light = bar(), two_lamps(BLUE, RED)
    lit = reflected(transport, light)
    tint = shadow_tint(transport, light, lit)
    shadow = 0.9 * (LUMINANCE * lit[:, :3]).sum(1, keepdim=True)
    image = explicit_sum(torch.ones_like(tint), lit, Effects(0 * shadow, shadow, tint))
    assert (image >= 0).all()
    assert (image <= lit[:, :3] + 1e-5).all()


def test_colourfulness_grows_with_what_tells_the_colours_apart():
    both, pale, same = two_lamps(BLUE, RED), two_lamps((1.0, 1.0, 1.1), (1.1, 1.0, 1.0)), torch.ones(1, 16, 32, 3)
    assert colourfulness(both) > 0.5 > colourfulness(pale) > colourfulness(same) == pytest.approx(0, abs=1e-5)
    assert colourfulness(7 * both) == pytest.approx(colourfulness(both), rel=1e-4)
