"""Averages, windows and smooth growth, against OpenCV and by hand."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from relight_core.imaging.resampling import resample_window, resize_area, resize_cut_out, resize_smooth

RNG = np.random.default_rng(2)


@given(st.integers(1, 40), st.integers(1, 40), st.integers(1, 40), st.integers(1, 40))
def test_area_averages_keep_the_mean_when_shrinking(height, width, new_height, new_width):
    image = np.random.default_rng(height * width).random((height, width)).astype(np.float32)
    new_height, new_width = min(height, new_height), min(width, new_width)
    small = resize_area(image, (new_height, new_width))
    assert small.shape == (new_height, new_width)
    assert small.mean() == pytest.approx(image.mean(), abs=1e-5)


def test_area_equals_opencv_where_both_are_exact():
    image = RNG.random((60, 80, 3)).astype(np.float32)
    np.testing.assert_allclose(
        resize_area(image, (15, 20)), cv2.resize(image, (20, 15), interpolation=cv2.INTER_AREA), atol=1e-5
    )


def test_a_window_on_whole_pixels_is_a_copy():
    image = RNG.random((30, 40, 3)).astype(np.float32)
    window = resample_window(image, (5, 7, 25, 27), (20, 20))
    np.testing.assert_array_equal(window, image[7:27, 5:25])
    window[...] = 0
    assert image[10, 10].min() > 0


def test_a_window_beyond_the_image_continues_its_edge():
    image = np.tile(np.arange(8, dtype=np.float32), (8, 1))
    window = resample_window(image, (-4, 0, 12, 8), (8, 16))
    np.testing.assert_allclose(window[0], [0] * 4 + list(range(8)) + [7] * 4, atol=1e-6)
    outside = resample_window(image, (100, 100, 110, 110), (3, 3))
    np.testing.assert_allclose(outside, 7.0, atol=1e-6)


@given(st.floats(-20, 20), st.floats(0.3, 60), st.integers(1, 50))
def test_a_ramp_stays_that_ramp_inside(start, length, count):
    image = np.tile(np.arange(200, dtype=np.float32) + 0.5, (3, 1))
    start += 80
    got = resample_window(image, (start, 0, start + length, 3), (3, count))[1]
    expected = start + (np.arange(count) + 0.5) * length / count
    # Half a pixel's worth at most: an area average takes each pixel as constant.
    np.testing.assert_allclose(got, expected, atol=0.13)


def test_growing_never_leaves_the_range_of_the_image():
    image = RNG.integers(0, 2, (9, 9)).astype(np.float32)
    for resized in (resize_smooth(image, (70, 50)), resample_window(image, (1.3, 2, 8, 8.2), (90, 90))):
        assert resized.min() >= 0.0
        assert resized.max() <= 1.0


@pytest.mark.parametrize("shape", [(5, 6), (5, 6, 1), (5, 6, 3), (5, 6, 4)])
def test_channels_are_kept(shape):
    image = np.ones(shape, np.uint8)
    for resize in (resize_area, resize_smooth):
        for size in ((3, 2), (11, 13)):
            resized = resize(image, size)
            assert resized.shape == (*size, *shape[2:])
            assert resized.dtype == np.float32
            np.testing.assert_allclose(resized, 1.0, atol=1e-6)


def test_a_cut_outs_edge_keeps_its_colour_and_what_is_hidden_has_no_say():
    alpha = np.zeros((12, 12), np.float32)
    alpha[:, :7] = 1
    image = np.where(alpha[..., None] > 0, np.float32(0.4), np.float32(9.0)).repeat(3, -1)
    small, share = resize_cut_out(image, alpha, (4, 4))
    np.testing.assert_allclose(share[0], [1, 1, 1 / 3, 0], atol=1e-6)
    np.testing.assert_allclose(small[:, :3], 0.4, rtol=1e-5)
    assert small[:, 3].max() == 0
