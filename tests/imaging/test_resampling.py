"""Averages, windows and smooth growth, against OpenCV and by hand."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from relight_core.imaging.resampling import (
    at_size,
    resample_window,
    resize_area,
    resize_cut_out,
    resize_smooth,
    shrunk_size,
)

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
    stripes = np.tile(image[:, :1], (1, 9))
    along_one_axis = resize_area(stripes, (90, 4)), resize_area(stripes.T, (4, 90))
    along_both = resize_smooth(image, (70, 50)), resample_window(image, (1.3, 2, 8, 8.2), (90, 90))
    for resized in (*along_both, *along_one_axis):
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


def test_a_faint_veil_keeps_its_colour():
    alpha = np.full((8, 8), 0.02, np.float32)
    small, share = resize_cut_out(np.full((8, 8, 3), 0.4, np.float32), alpha, (2, 2))
    np.testing.assert_allclose(share, 0.02, rtol=1e-5)
    np.testing.assert_allclose(small, 0.4, rtol=1e-5)


def test_an_image_that_has_the_size_is_itself():
    image = RNG.random((5, 6)).astype(np.float32)
    assert at_size(image, (5, 6)) is image
    assert at_size(image, (5, 3)).shape == (5, 3)
    assert at_size(np.ones((5, 6), np.uint8), (5, 6)).dtype == np.float32


@pytest.mark.parametrize(
    ("size", "longest_side", "shrunk"),
    [
        ((3000, 4000), 1000, (750, 1000)),
        ((4000, 3000), 1000, (1000, 750)),
        ((999, 1333), 500, (375, 500)),
        ((1333, 999), 500, (500, 375)),
        ((50, 40), 100, (50, 40)),
        ((50, 40), None, (50, 40)),
        ((1, 5000), 100, (1, 100)),
        ((5000, 2), 100, (100, 1)),
    ],
)
def test_a_picture_shrinks_to_its_longest_side_and_never_grows_or_vanishes(size, longest_side, shrunk):
    assert shrunk_size(size, longest_side) == shrunk


def test_what_shrinks_along_one_axis_only_is_averaged_along_it():
    image = np.tile(np.float32([0, 0, 0, 1] * 5)[:, None], (1, 6))
    np.testing.assert_allclose(resize_smooth(image, (5, 12)), 0.25, atol=1e-6)
    np.testing.assert_allclose(resize_smooth(image.T, (12, 5)), 0.25, atol=1e-6)


def test_mirrored_and_turned_views_of_an_image_are_enlarged_as_copies_of_them_are():
    image = RNG.random((5, 6, 3)).astype(np.float32)
    for view in (image[::-1], image[:, ::-1], image.swapaxes(0, 1), image[..., ::-1]):
        for resize in (resize_smooth, resize_area):
            np.testing.assert_array_equal(resize(view, (13, 14)), resize(view.copy(), (13, 14)))


@pytest.mark.parametrize("count", [6, 7, 8, 9])
def test_a_window_that_shrinks_a_little_keeps_its_mean(count):
    image = RNG.random((12, 14)).astype(np.float32)
    small = resample_window(image, (2, 1, 12, 11), (count, count))
    assert small.mean() == pytest.approx(image[1:11, 2:12].mean(), abs=1e-5)


@pytest.mark.parametrize(("x0", "y0"), [(-3, -2), (-3, 0), (0, -2), (4, 5), (-9, 0), (20, -20)])
def test_a_window_of_whole_pixels_that_hangs_over_the_border_continues_it(x0, y0):
    image = RNG.random((6, 14, 3)).astype(np.float32)
    rows, columns = np.clip(np.arange(y0, y0 + 8), 0, 5), np.clip(np.arange(x0, x0 + 8), 0, 13)
    np.testing.assert_allclose(resample_window(image, (x0, y0, x0 + 8, y0 + 8), (8, 8)), image[rows][:, columns])


def test_a_slope_stays_that_slope_in_a_window_of_a_large_picture():
    y, x = np.mgrid[:2400, :900].astype(np.float32)
    seen = resample_window(np.dstack([y, x, y + x]), (10.25, 20.5, 810.25, 2240.5), (111, 40))
    down, across = np.meshgrid(20.5 + 20 * (np.arange(111) + 0.5), 10.25 + 20 * (np.arange(40) + 0.5), indexing="ij")
    np.testing.assert_allclose(seen, np.dstack([down, across, down + across]) - (0.5, 0.5, 1.0), rtol=1e-4)
