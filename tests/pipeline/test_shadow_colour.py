"""Shadows between lights of different colours."""

import numpy as np
import pytest
import torch

from relight_core.lighting.relief import march_relief
from relight_core.pipeline.per_light.hints import Effects, explicit_sum, hidden_by_colour
from relight_core.pipeline.per_light.shadow_colour import colourfulness, shadow_colour_odds

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
    irradiance = (transport.unshadowed @ light[0].flatten(0, 1)).T.reshape(1, 3, SIZE, SIZE)
    return torch.cat([irradiance, torch.zeros_like(irradiance)], 1)


def found(light):
    transport = bar()
    return shadow_colour_odds(transport, light, reflected(transport, light))


@pytest.mark.parametrize("colour", [WHITE, RED, (0.0, 0.0, 0.0)])
def test_light_of_one_colour_tints_nothing(colour):
    light = two_lamps(WHITE, WHITE) * torch.tensor(colour)
    assert found(light) is None


def test_the_shadow_of_a_red_lamp_is_blue():
    """Left of the bar the right lamp is hidden."""
    odds = found(two_lamps(BLUE, RED))[0, :, SIZE // 2]
    assert odds[0, 12] > 1.2 > 0.6 > odds[2, 12]
    assert odds[2, 19] > 1.1 > 0.6 > odds[0, 19]


def test_the_shadow_of_a_white_lamp_has_the_colour_of_a_weaker_one():
    light = two_lamps(WHITE, (0.3, 0.01, 0.01))
    assert colourfulness(light) < 0.25
    odds = found(light)[0, :, SIZE // 2]
    assert odds[0, 19] < 0.9 * odds[1, 19]


@pytest.mark.parametrize("albedo", [(1.0, 1.0, 1.0), (0.6, 0.3, 0.2)])
@pytest.mark.parametrize("share", [0.02, 0.2, 0.9])
def test_what_is_hidden_in_all_stays(albedo, share):
    transport, light = bar(), two_lamps(BLUE, RED)
    lit, albedo = reflected(transport, light), torch.tensor(albedo)[None, :, None, None].expand(1, 3, SIZE, SIZE)
    shadow = share * (LUMINANCE * albedo * lit[:, :3]).sum(1, keepdim=True)
    plain, coloured = (
        (LUMINANCE * explicit_sum(albedo, lit, Effects(0 * shadow, shadow, odds))).sum(1)
        for odds in (None, shadow_colour_odds(transport, light, lit))
    )
    torch.testing.assert_close(coloured, plain, rtol=0.01, atol=1e-3)


def test_no_more_is_taken_than_there_is():
    transport, light = bar(), two_lamps(BLUE, RED)
    lit = reflected(transport, light)
    shadow = 0.9 * (LUMINANCE * lit[:, :3]).sum(1, keepdim=True)
    odds = shadow_colour_odds(transport, light, lit)
    image = explicit_sum(torch.ones_like(odds), lit, Effects(0 * shadow, shadow, odds))
    assert (image > 0).all()
    assert (image <= lit[:, :3] + 1e-5).all()


def test_a_deeper_shadow_than_the_relief_knows_keeps_some_of_each_colour():
    """A brim hides 55 % of a blue sky and 27 % of a low orange sun; the network says twice as much of both."""
    by_relief, sun_and_sky = torch.tensor([0.27, 0.3, 0.55]), torch.tensor([3.0, 2.0, 1.2])[None, :, None, None]
    odds = (by_relief / (1 - by_relief) / (0.3 / 0.7))[None, :, None, None]
    left = 1 - hidden_by_colour(torch.full((1, 1, 1, 1), 0.6), odds, sun_and_sky)[0, :, 0, 0]
    assert left[2] > 0.15
    assert left[0] > left[1] > left[2]


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_all_or_nothing_has_no_colour(share):
    odds, white = torch.tensor([0.1, 1.0, 20.0])[None, :, None, None], torch.ones(1, 3, 1, 1)
    hidden = hidden_by_colour(torch.full((1, 1, 1, 1), share), odds, white)
    torch.testing.assert_close(hidden, torch.full((1, 3, 1, 1), share), atol=1e-3, rtol=0)


def test_where_there_is_no_light_nothing_is_undefined():
    odds = torch.tensor([0.1, 1.0, 20.0])[None, :, None, None]
    assert hidden_by_colour(torch.full((1, 1, 1, 1), 0.5), odds, torch.zeros(1, 3, 1, 1)).isfinite().all()


def test_colourfulness_grows_with_what_tells_the_colours_apart():
    both, pale, same = two_lamps(BLUE, RED), two_lamps((1.0, 1.0, 1.1), (1.1, 1.0, 1.0)), torch.ones(1, 16, 32, 3)
    assert colourfulness(both) > 0.5 > colourfulness(pale) > colourfulness(same) == pytest.approx(0, abs=1e-5)
    assert colourfulness(7 * both) == pytest.approx(colourfulness(both), rel=1e-4)


def test_colours_count_by_how_much_of_the_sphere_they_fill():
    """At the pole a row of texels is a twentieth of one beside the horizon."""
    high, level = torch.ones(2, 1, 16, 32, 3)
    high[:, 0], level[:, 8] = torch.tensor([3.0, 0.0, 0.0]), torch.tensor([3.0, 0.0, 0.0])
    assert colourfulness(high) < 0.15 * colourfulness(level)


def test_a_shadow_as_deep_as_the_relief_has_it_hides_of_each_colour_what_the_relief_does():
    transport, light = bar(), two_lamps(BLUE, RED)
    lit, white = reflected(transport, light), torch.ones(1, 3, SIZE, SIZE)
    left = transport.visibility(light[0].permute(2, 0, 1), SIZE)[:, 0][None]
    shadow = (LUMINANCE * (1 - left) * lit[:, :3]).sum(1, keepdim=True)
    image = explicit_sum(white, lit, Effects(0 * shadow, shadow, shadow_colour_odds(transport, light, lit)))
    torch.testing.assert_close(image, left * lit[:, :3], atol=0.05 * float(lit.max()), rtol=0)
    assert left[0, 0].min() < 0.05


def test_the_colour_of_a_shadow_comes_evenly_as_a_gel_gets_stronger():
    transport, strongest = bar(), []
    for share in np.linspace(0, 0.5, 26):
        gel = torch.lerp(torch.ones(3), torch.tensor([1.0, 0.4, 0.3]), float(share)).tolist()
        light = two_lamps(WHITE, gel)
        odds = shadow_colour_odds(transport, light, reflected(transport, light))
        strongest.append(0.0 if odds is None else float(odds.log().abs().max()))
    assert strongest[-1] > 0.08
    assert 0 <= np.diff(strongest).min() <= np.diff(strongest).max() < 0.03
