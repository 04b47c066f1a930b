"""Lights as a turned camera sees them."""

import numpy as np

from relight_core.lighting.panorama import mean_luminance, shrink
from relight_core.lighting.roll import roll_light
from relight_core.lighting.sphere import directions


def lamp(toward):
    return (directions(16, 32) @ np.float32(toward) > 0.9).astype(np.float32)[..., None].repeat(3, -1)


def middle(light):
    centre = (directions(16, 32) * light.mean(-1, keepdims=True)).sum((0, 1))
    return centre / np.linalg.norm(centre)


def test_no_roll_is_the_light_itself():
    light = lamp((0, 1, 0))
    assert roll_light(light, 0.0) is light


def test_a_lamp_above_moves_to_the_right_of_a_camera_turned_counterclockwise():
    np.testing.assert_allclose(middle(roll_light(lamp((0, 1, 0)), 90.0)), (1, 0, 0), atol=0.05)
    s = 0.5**0.5
    np.testing.assert_allclose(middle(roll_light(lamp((0, 1, 0)), 45.0)), (s, s, 0), atol=0.05)


def test_lamps_on_the_cameras_axis_stay():
    for z in (1, -1):
        np.testing.assert_allclose(middle(roll_light(lamp((0, 0, z)), 30.0)), (0, 0, z), atol=0.05)


def test_the_level_stays_and_rolling_back_gives_about_the_same():
    light = np.random.default_rng(0).gamma(2, 1, (16, 32, 3)).astype(np.float32)
    rolled = roll_light(light, 33.0)
    np.testing.assert_allclose(mean_luminance(rolled), mean_luminance(light), rtol=1e-4)
    smooth = light.mean() + 0.5 * directions(16, 32)
    np.testing.assert_allclose(roll_light(roll_light(smooth, 33.0), -33.0), smooth, atol=0.12)


def test_darkness_stays_dark():
    assert roll_light(np.zeros((16, 32, 3), np.float32), 20.0).max() == 0


def test_a_small_lamp_is_blurred_no_more_than_shrinking_does():
    """Turned from a fine panorama, a lamp of 3 degrees fills few texels of a small one."""
    fine = (directions(64, 128) @ np.float32([0.6, 0.0, 0.8]) > np.cos(np.radians(3.0))).astype(np.float32)[..., None]
    fine = fine.repeat(3, -1)
    rolled, twice = roll_light(fine, 25.0, 16), roll_light(shrink(fine, 16), 25.0)
    assert rolled.shape == (16, 32, 3)
    np.testing.assert_allclose(mean_luminance(rolled), mean_luminance(fine), rtol=1e-4)
    np.testing.assert_allclose(middle(rolled), middle(shrink(roll_light(fine, 25.0), 16)), atol=0.05)
    assert rolled.max() > 1.2 * twice.max()
    np.testing.assert_array_equal(roll_light(fine, 0.0, 16), shrink(fine, 16))
