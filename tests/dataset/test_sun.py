"""A lamp as small as the sun: where a head hides it from itself, and how sharp the edge of that is."""

from types import SimpleNamespace

import numpy as np
import pytest

from relight_core.dataset.lighting.appearance import Appearance
from relight_core.dataset.lighting.sun import in_sun, sample_sun
from relight_core.lighting.horizon import Horizon

SIZE = 128
PIXEL = 2 / SIZE
COLUMN = slice(60, 68)


def wall(height=0.25):
    """A plane with a wall down its middle, 8 pixels thick."""
    relief = np.zeros((SIZE, SIZE), np.float32)
    relief[:, COLUMN] = height
    return relief


def sunlit(relief, toward, wide_deg):
    return Horizon(relief, np.ones(relief.shape, bool)).visibility(tuple(toward), wide_deg / 2)


def from_the_right(elevation_deg):
    angle = np.radians(elevation_deg)
    return np.array([np.cos(angle), 0, np.sin(angle)])


@pytest.mark.parametrize("elevation_deg", [30, 45, 60])
def test_a_wall_throws_a_shadow_as_long_as_trigonometry_says(elevation_deg):
    row = sunlit(wall(), from_the_right(elevation_deg), 0.5)[64]
    expected = 0.25 / np.tan(np.radians(elevation_deg)) / PIXEL
    assert (1 - row[: COLUMN.start]).sum() == pytest.approx(expected, abs=2.5)
    assert row[COLUMN.stop + 1 :].min() == 1
    assert row[COLUMN.start + 1 : COLUMN.stop - 1].min() > 0.9


def test_up_is_up():
    relief = np.zeros((SIZE, SIZE), np.float32)
    relief[COLUMN, :] = 0.25
    column = sunlit(relief, np.array([0, np.sqrt(0.5), np.sqrt(0.5)]), 0.5)[:, 64]
    assert column[: COLUMN.start - 1].min() == 1
    assert column[COLUMN.stop + 2 : COLUMN.stop + 12].max() < 0.1


def test_a_wider_lamp_has_softer_edges_that_grow_with_the_way():
    def softness_px(wide_deg, height):
        row = sunlit(wall(height), from_the_right(45), wide_deg)[64, : COLUMN.start]
        return ((row > 0.05) & (row < 0.95)).sum()

    assert softness_px(0.3, 0.5) < softness_px(8, 0.5)
    assert softness_px(8, 0.1) < softness_px(8, 0.5)


def test_a_plane_and_what_is_straight_ahead_have_no_shadow():
    slope = np.linspace(-0.2, 0.2, SIZE, dtype=np.float32)[None, :].repeat(SIZE, 0)
    assert sunlit(slope, from_the_right(50), 0.5).min() == 1
    assert sunlit(wall(), np.array([0.0, 0.0, 1.0]), 0.5).min() == 1


def test_a_sun_is_one_texel_before_the_head():
    for seed in range(50):
        light = sample_sun(np.random.default_rng(seed))
        assert light.shape == (16, 32, 3)
        (lit,) = np.argwhere(light.sum(-1) > 0)
        assert light.mean() > 0
        # Of a lat-long map's columns those at its sides are before the person.
        assert lit[1] < 9 or lit[1] > 22


def test_most_suns_stand_above_and_each_has_a_colour_of_its_own():
    lights = [sample_sun(np.random.default_rng(seed)) for seed in range(100)]
    assert np.mean([np.argwhere(light.sum(-1) > 0)[0, 0] < 8 for light in lights]) > 0.6
    colours = np.array([light.max((0, 1)) for light in lights])
    assert colours.min() > 0
    assert np.std(np.log(colours[:, 0] / colours[:, 2])) > 0.05


def test_a_head_in_the_sun_is_dark_where_it_hides_it_and_as_bright_as_in_the_open_elsewhere():
    covered = np.ones((SIZE, SIZE), bool)
    head = SimpleNamespace(covered=covered, depth=wall().reshape(-1), scatter=lambda image: image.reshape(SIZE, SIZE))
    light = np.zeros((16, 32, 3), np.float32)
    light[7, 28] = 1  # a little above, to the right, in front
    dim, bright = np.full((2, SIZE * SIZE, 3), 0.3, np.float32), np.full((2, SIZE * SIZE, 3), 0.5, np.float32)
    seen = in_sun(
        Appearance(dim, dim, 0.0, None),
        head,
        light,
        SimpleNamespace(irradiance_open=bright),
        1,
        np.random.default_rng(0),
    )
    irradiance = seen.irradiance[1].reshape(SIZE, SIZE, 3)
    assert irradiance[64, COLUMN.start - 6].max() < 0.01
    assert irradiance[64, 110].min() == pytest.approx(0.5)
    assert seen.specular[1].reshape(SIZE, SIZE, 3)[64, COLUMN.start - 6].max() < 0.01
    np.testing.assert_array_equal(seen.irradiance[0], dim[0])
    np.testing.assert_array_equal(dim, np.full_like(dim, 0.3))
