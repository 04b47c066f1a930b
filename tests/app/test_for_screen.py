"""What the screen gets of photos, cut-outs and lights: sizes, hidden colours and brightness."""

import numpy as np
import pytest

from app.engine.screen import ball_for_screen, panorama_for_screen, radiance_for_screen
from relight_core.lighting.environment import Environment


def even_light(height, radiance=1.0):
    return Environment.from_radiance(np.full((height, 2 * height, 3), radiance, np.float32))


def test_a_photo_that_is_too_long_for_a_texture_is_made_smaller_with_its_alpha():
    linear, alpha = np.full((8, 9000, 3), 0.25, np.float32), np.ones((8, 9000), np.float32)
    alpha[:, 4500:], linear[:, 4500:] = 0, 50.0
    assert radiance_for_screen(linear).shape == (7, 8192, 3)
    screen = radiance_for_screen(linear, alpha)
    assert screen.shape == (7, 8192, 4)
    half = 4096
    assert np.abs(screen[:, : half - 3] - np.float16([0.25, 0.25, 0.25, 1])).max() < 1e-3
    assert screen[:, half + 3 :].max() == 0, "what is hidden stays so"


def test_what_a_cut_out_of_a_texture_s_size_hides_is_black():
    linear, alpha = np.full((4, 6, 3), 0.25, np.float32), np.zeros((4, 6), np.float32)
    alpha[:, :3] = 0.5
    screen = radiance_for_screen(linear, alpha)
    np.testing.assert_array_equal(screen[:, :3], np.broadcast_to(np.float16([0.25, 0.25, 0.25, 0.5]), (4, 3, 4)))
    assert screen[:, 3:].max() == 0


@pytest.mark.parametrize("height", [2, 16, 64, 100, 256, 300, 512])
def test_a_panorama_is_twice_as_wide_as_high_and_no_higher_than_256(height):
    shown = panorama_for_screen(even_light(height))
    assert shown.shape == (len(shown), 2 * len(shown), 3)
    assert len(shown) <= 256
    assert len(shown) >= min(height, 256)


def test_a_coarse_panorama_is_drawn_without_its_pixels_edges():
    assert len(panorama_for_screen(even_light(16))) == 256


def test_a_panorama_is_shown_a_stop_darker_than_it_is_whatever_its_units_and_times_its_gain():
    for radiance in (0.01, 1.0, 500.0):
        shown = panorama_for_screen(even_light(256, radiance))
        # Half of white in sRGB.
        assert np.abs(shown.astype(int) - 188).max() <= 2
    dimmed = panorama_for_screen(even_light(256), 0.5)
    assert np.abs(dimmed.astype(int) - 137).max() <= 2


def test_a_ball_in_even_light_is_even_and_covers_a_disc():
    ball = ball_for_screen(even_light(16))
    assert (ball.shape, ball.dtype) == ((96, 96, 4), np.uint8)
    assert ball[48, 48, 3] == 255
    assert ball[0, 0, 3] == 0
    assert (ball[..., 3] > 127).mean() == pytest.approx(np.pi / 4, abs=0.08)
    inside = ball[30:66, 30:66, :3].astype(int)
    assert np.ptp(inside) <= 12
    # The bright parts have a luminance of 0.85, which is 237 in sRGB.
    assert np.percentile(ball[ball[..., 3] > 0][:, :3], 98) == pytest.approx(237, abs=2)
