"""Lights as a turned camera sees them."""

import numpy as np

from relight_core.lighting.environment import mean_luminance
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
