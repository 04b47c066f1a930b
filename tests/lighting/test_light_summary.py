"""Where a light comes from, how bright it is, and the ball that shows it."""

import numpy as np
import pytest

from relight_core.lighting.environment import Environment
from relight_core.lighting.panorama import rotate
from relight_core.lighting.preview import lit_ball
from relight_core.lighting.rigs import load_rig
from relight_core.lighting.summary import average_direction, meter_reading, metered_level_ev


def panorama_with(*lamps, ambient=0.0):
    panorama = np.full((32, 64, 3), ambient, np.float32)
    for row, column in lamps:
        panorama[row : row + 2, column : column + 2] = 100.0
    return Environment.from_radiance(panorama)


def test_even_light_has_no_direction():
    even = Environment.from_radiance(np.full((16, 32, 3), 3.0))
    np.testing.assert_allclose(average_direction(even), 0, atol=1e-6)


def test_no_light_has_no_direction():
    dark = Environment.from_radiance(np.zeros((16, 32, 3)))
    assert not average_direction(dark).any()


def test_a_lone_lamp_has_its_direction():
    right = panorama_with((15, 47))
    np.testing.assert_allclose(average_direction(right), [1, 0, 0], atol=0.02)


def test_direction_follows_yaw():
    front = panorama_with((15, 0), ambient=0.2)
    straight, turned = average_direction(front), average_direction(front, 90)
    assert straight[2] > 0.3
    np.testing.assert_allclose(turned, [-straight[2], straight[1], straight[0]], atol=0.02)


def test_opposite_lamps_balance():
    both = panorama_with((15, 15), (15, 47))
    np.testing.assert_allclose(average_direction(both), 0, atol=0.02)


def test_a_lamps_say_in_the_direction_is_its_luminance():
    panorama = np.zeros((32, 64, 3), np.float32)
    panorama[15:17, 15:17, 2] = panorama[15:17, 47:49, 1] = 100.0
    # Blue from the left gives 0.0722 where green from the right gives 0.7152.
    expected = (0.7152 - 0.0722) / (0.7152 + 0.0722)
    np.testing.assert_allclose(average_direction(Environment.from_radiance(panorama)), [expected, 0, 0], atol=0.02)


# The ball


def test_the_ball_is_a_disc_of_finite_light():
    ball = lit_ball(panorama_with((10, 40), ambient=0.1), 48)
    assert ball.shape == (48, 48, 4)
    assert ball.dtype == np.float32
    assert np.isfinite(ball).all()
    assert (ball >= 0).all()
    assert ball[0, 0, 3] == 0
    assert ball[24, 24, 3] == 1
    assert ball[..., 3].sum() == pytest.approx(np.pi * 24**2, rel=0.01)
    assert not ball[ball[..., 3] == 0].any()


@pytest.mark.parametrize(
    ("lamp", "bright"),
    [
        ((15, 47), (slice(None), slice(20, None))),
        ((15, 15), (slice(None), slice(None, 20))),
        ((4, 0), (slice(None, 20), slice(None))),
        ((26, 0), (slice(20, None), slice(None))),
    ],
)
def test_the_side_toward_the_lamp_is_bright(lamp, bright):
    image = lit_ball(panorama_with(lamp), 40)[..., :3]
    assert image[bright].sum() > 0.75 * image.sum()


def test_exposure_does_not_depend_on_the_level():
    panorama = np.random.default_rng(0).random((16, 32, 3))
    dim, strong = (lit_ball(Environment.from_radiance(panorama * s), 24) for s in (1e-6, 1e6))
    np.testing.assert_allclose(dim, strong, rtol=1e-3)
    assert 0.5 < np.percentile(dim[..., 1][dim[..., 3] > 0], 98) < 1.2


@pytest.mark.parametrize("size", [1, 2, 33])
def test_dark_light_gives_a_black_ball_at_any_size(size):
    ball = lit_ball(Environment.from_radiance(np.zeros((8, 16, 3))), size)
    assert not ball[..., :3].any()
    assert ball[..., 3].max() > 0


# The meter


def test_a_light_as_bright_as_a_rig_keeps_its_level():
    assert metered_level_ev(Environment.from_radiance(np.full((16, 32, 3), 1.5))) == pytest.approx(0.0, abs=1e-6)
    assert abs(metered_level_ev(load_rig("rembrandt"))) < 0.2


def test_a_face_is_metered_and_not_the_top_of_a_head():
    """Light from straight above gives a card that leans back by 30 degrees half of what it gives a level one."""
    overhead, before = (np.zeros((64, 128, 3), np.float32) for _ in range(2))
    overhead[:2] = before[30:34, 62:66] = 1.0
    above, ahead = (Environment.from_radiance(light) for light in (overhead, before))
    assert meter_reading(above) == pytest.approx(4.0 * 0.5, rel=0.1)
    assert meter_reading(ahead) == pytest.approx(4.0, rel=0.06)


@pytest.mark.parametrize("rig", ["butterfly", "clamshell", "hard-side", "loop", "overcast", "rembrandt", "soft-window"])
def test_rigs_that_light_a_face_are_about_equally_bright_to_the_meter(rig):
    light = load_rig(rig)
    assert light.level * meter_reading(light) == pytest.approx(1.5, rel=0.15)


@pytest.mark.parametrize("colour", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.2), (0.1, 0.0, 1.0)])
def test_the_meter_reads_luminance_whatever_the_colour(colour):
    white = np.random.default_rng(2).exponential(size=(32, 64, 1)).astype(np.float32)
    tinted = Environment.from_radiance(white * np.float32(colour))
    assert meter_reading(tinted) == pytest.approx(meter_reading(Environment.from_radiance(white)), rel=1e-5)


@pytest.mark.parametrize("stops", [-5, -1, 1, 7])
def test_every_stop_of_light_is_taken_away_again(stops):
    panorama = np.random.default_rng(1).random((32, 64, 3)).astype(np.float32)
    plain, other = (Environment.from_radiance(panorama * 2.0**by) for by in (0, stops))
    assert metered_level_ev(other) == pytest.approx(metered_level_ev(plain) - stops, abs=1e-9)


def test_the_brightest_side_is_metered_wherever_it_is():
    sun = np.full((32, 64, 3), 0.5, np.float32)
    sun[10:12, 40:42] = 400.0
    turned = [metered_level_ev(Environment.from_radiance(rotate(sun, yaw_deg))) for yaw_deg in (0, 45, 90, 180)]
    assert turned[0] < -1.0
    assert turned == pytest.approx([turned[0]] * 4)


@pytest.mark.parametrize(("radiance", "stops"), [(0.0, 0.0), (1e-30, 16.0), (1e30, -16.0)])
def test_no_light_is_left_alone_and_any_other_is_changed_by_so_many_stops_at_most(radiance, stops):
    assert metered_level_ev(Environment.from_radiance(np.full((8, 16, 3), radiance))) == stops
