"""Histogram, waveform and extremes: every pixel is counted once, at the right place."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from relight_core.imaging.false_colour import difference_colours, scale_colours
from relight_core.imaging.scopes import (
    extremes,
    histogram,
    histogram_picture,
    thinned,
    waveform,
    waveform_picture,
)

sizes = st.tuples(st.integers(1, 40), st.integers(1, 600))


@given(sizes, st.integers(0, 2**32 - 1))
def test_every_pixel_is_counted_once(size, seed):
    codes = np.random.default_rng(seed).integers(0, 256, (*size, 3), np.uint8)
    assert (histogram(codes).sum(axis=1) == size[0] * size[1]).all()
    counted = waveform(codes, columns=64, rows=32).sum(axis=(0, 1))
    assert (counted == size[0] * max(size[1], 64)).all()


def test_a_histogram_counts_codes_per_channel():
    codes = np.zeros((2, 3, 3), np.uint8)
    codes[..., 0] = 255
    codes[0, 0] = (7, 8, 9)
    counts = histogram(codes)
    assert counts[0, 255] == 5
    assert counts[1, 0] == 5
    assert [counts[0, 7], counts[1, 8], counts[2, 9]] == [1, 1, 1]


def test_a_waveform_shows_a_ramp_as_a_rising_line():
    codes = np.repeat(np.arange(256, dtype=np.uint8)[None, :, None], 3, axis=2)
    counts = waveform(codes, columns=256, rows=128)
    rows, columns = np.nonzero(counts[..., 1])
    assert (rows == 127 - columns // 2).all()


def test_a_picture_narrower_than_its_waveform_is_spread_over_it():
    codes = np.repeat(np.uint8([10, 100, 200])[None, :, None], 3, axis=2)
    rows, columns = np.nonzero(waveform(codes, columns=9, rows=256)[..., 0].T)[::-1]
    assert columns.tolist() == list(range(9))
    assert rows.tolist() == [245] * 3 + [155] * 3 + [55] * 3
    counts = waveform(codes, columns=9, rows=256, seen=np.array([[False, True, False]]))
    assert counts[155, 3:6].min() == 1
    assert counts.sum() == 3 * 3


@pytest.mark.parametrize("draw", [histogram_picture, waveform_picture])
@pytest.mark.parametrize("code", [0, 128, 255])
def test_the_pictures_of_a_flat_picture_are_finite_and_show_something(draw, code):
    shown = draw(np.full((5, 7, 3), code, np.uint8))
    assert shown.dtype == np.uint8
    assert shown.shape[2] == 4
    assert shown[..., 3].max() > 200
    assert shown[..., 3].min() == 0


def test_a_red_picture_makes_a_red_peak():
    codes = np.zeros((8, 8, 3), np.uint8)
    codes[..., 0] = 200
    peak = histogram_picture(codes)[-1, 200].astype(int)
    assert peak[0] > 2 * max(peak[1], peak[2])
    assert peak[3] == 255
    trace = waveform_picture(codes)[127 - 100, 128]
    assert (trace[0] > 200, trace[1:3].max(), trace[3] > 200) == (True, 0, True)


def test_columns_of_a_histogram_grow_from_below_and_are_as_wide_to_either_side():
    codes = np.zeros((1, 300, 3), np.uint8)
    codes[:, :100], codes[:, 100:150] = 80, 160
    coverage = histogram_picture(codes)[..., 3]
    assert coverage.shape == (96, 256)
    full = (coverage == 255).sum(0)
    assert (full[80], full[160]) == (96, 48)
    assert full[79] == full[81] == 48
    assert coverage[-1, 160] == 255
    assert coverage[0, 160] == 0


def test_extremes_tell_dark_bright_and_bad_apart():
    linear = np.full((10, 10, 3), 0.5, np.float32)
    linear[0] = 0.0
    linear[1, :5, 0] = 1.0
    linear[2, :2, 0] = np.nan
    linear[2, 2, 1] = np.inf
    found = extremes(linear)
    assert (found.too_dark, found.too_bright, found.no_number) == pytest.approx((0.1, 0.05, 0.03))
    assert extremes(linear, 1.0).too_bright == pytest.approx(0.1 * 9 - 0.03)
    halves = np.minimum(linear, np.float32(65504)).astype(np.float16)
    assert extremes(halves) == found


@given(st.tuples(st.integers(1, 3000), st.integers(1, 3000)))
def test_thinning_keeps_few_pixels_and_at_least_one(size):
    kept = thinned(np.broadcast_to(np.uint8(0), (*size, 3)), most=10000)
    assert 1 <= kept.shape[0] * kept.shape[1] <= 2.1 * 10000 + max(size)
    assert kept.shape[0] <= size[0]


def test_false_colours_get_lighter_away_from_nothing():
    scale = scale_colours()[0].astype(int) @ np.array([2126, 7152, 722])
    assert (np.diff(scale) >= 0).all()
    difference = difference_colours()[0].astype(int)
    light = difference @ np.array([2126, 7152, 722])
    assert light.argmin() == pytest.approx(127.5, abs=12)
    assert (difference[:60, 2] > difference[:60, 0]).all()
    assert (difference[-60:, 0] > difference[-60:, 2]).all()


def test_what_is_transparent_does_not_count():
    codes = np.zeros((40, 300, 3), np.uint8)
    codes[:, 100:] = (255, 0, 9)
    seen = np.zeros((40, 300), bool)
    seen[:, :100] = True
    assert histogram(codes, seen)[:, 0].tolist() == [4000] * 3
    assert histogram(codes, seen).sum() == 3 * 4000
    assert waveform(codes, columns=300, rows=64, seen=seen)[-1, :100].min() == 40
    assert waveform(codes, columns=300, rows=64, seen=seen)[:, 100:].max() == 0
    np.testing.assert_array_equal(histogram_picture(codes, seen), histogram_picture(codes[:, :100]))
    assert waveform_picture(codes, seen)[:, 100:].max() == 0
    assert extremes(codes.astype(np.float32), seen=seen).too_bright == 0
    assert extremes(codes.astype(np.float32), seen=~seen).too_bright == 1
    nobody = extremes(codes.astype(np.float32), seen=np.zeros_like(seen))
    assert (nobody.too_dark, nobody.too_bright, nobody.no_number) == (0, 0, 0)


def test_a_black_backdrop_neither_flattens_the_histogram_nor_shows_as_white():
    codes = np.zeros((40, 40, 3), np.uint8)
    codes[:2] = 128
    coverage = histogram_picture(codes)[..., 3]
    assert coverage[:, 128].min() == 255
    assert coverage[:, 0].min() == 255
    assert coverage[:, 255].max() == 0


def test_what_the_screen_shows_as_its_darkest_grey_is_not_too_dark():
    """Code 1 is 1 / (12.92 * 255), and half of that is rounded to it."""
    assert extremes(np.full((4, 4, 3), 0.00016, np.float32)).too_dark == 0
    assert extremes(np.full((4, 4, 3), 0.00015, np.float32)).too_dark == 1


def test_a_waveform_is_no_brighter_for_a_picture_of_more_pixels():
    ramp = np.broadcast_to(np.arange(256, dtype=np.uint8)[:, None, None], (256, 256, 3))
    larger = ramp.repeat(4, 0).repeat(4, 1)
    np.testing.assert_array_equal(waveform_picture(larger), waveform_picture(ramp))
    np.testing.assert_array_equal(waveform_picture(ramp[:, :64]), waveform_picture(ramp))
