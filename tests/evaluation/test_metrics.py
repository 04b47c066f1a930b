"""Error measures against numbers worked out by hand."""

import math

import numpy as np
import pytest
from skimage.metrics import structural_similarity

from relight_core.evaluation.metrics import (
    Interval,
    interval_over_heads,
    normal_angle_deg,
    normal_rmse,
    psnr,
    rmse,
    ssim,
    wlog_l2,
)

LEFT_HALF = np.array([[True, False], [True, False]])


def image(*values):
    return np.array(values, np.float32).reshape(2, 2)


def normals(*vectors):
    return np.array(vectors, np.float32).reshape(1, -1, 3)


def test_rmse_by_hand():
    assert rmse(image(1, 0, 0, 0), image(0, 0, 0, 0)) == pytest.approx(0.5)
    assert rmse(image(1, 5, 0, 9), image(0, 0, 0, 0), LEFT_HALF) == pytest.approx(math.sqrt(0.5))


def test_rmse_counts_every_channel():
    estimate, reference = np.zeros((1, 2, 3)), np.zeros((1, 2, 3))
    estimate[0, 0] = [3, 0, 0]
    assert rmse(estimate, reference) == pytest.approx(math.sqrt(9 / 6))
    assert rmse(estimate, reference, np.array([[True, False]])) == pytest.approx(math.sqrt(3))


def test_small_differences_of_large_images_survive():
    large = np.full((400, 400), 1000.0, np.float32)
    assert rmse(large + np.float32(0.0625), large) == pytest.approx(0.0625, rel=1e-9)


def test_nan_inside_the_mask_shows_and_outside_does_not():
    broken = image(np.nan, 0, 0, 0)
    assert math.isnan(rmse(broken, image(0, 0, 0, 0)))
    assert rmse(broken, image(0, 0, 0, 0), ~LEFT_HALF) == 0.0


def test_psnr_by_hand():
    assert psnr(image(0.1, 0.1, 0.1, 0.1), image(0, 0, 0, 0)) == pytest.approx(20.0, abs=1e-5)
    assert psnr(image(0.01, 9, 0.01, 9), image(0, 0, 0, 0), LEFT_HALF) == pytest.approx(40.0, abs=1e-5)
    assert psnr(image(1, 2, 3, 4), image(1, 2, 3, 4)) == math.inf


def test_ssim_of_equal_and_of_flat_images():
    noise = np.random.default_rng(0).random((24, 20, 3))
    assert ssim(noise, noise) == pytest.approx(1.0)
    # Flat images: only the luminance term is left, (2 * 0.2 * 0.4 + 0.0001) / (0.04 + 0.16 + 0.0001).
    flat = np.full((16, 16), 0.2), np.full((16, 16), 0.4)
    assert ssim(*flat) == pytest.approx(0.1601 / 0.2001)


def test_ssim_in_the_inside_is_scikit_images():
    rng = np.random.default_rng(1)
    reference = rng.random((40, 40, 3))
    estimate = np.clip(reference + rng.normal(0, 0.1, reference.shape), 0, 1)
    mask = np.zeros((40, 40), bool)
    mask[5:-5, 5:-5] = True
    expected = structural_similarity(
        estimate, reference, data_range=1, channel_axis=2, gaussian_weights=True, use_sample_covariance=False
    )
    assert ssim(estimate, reference, mask) == pytest.approx(expected, abs=1e-9)
    assert ssim(estimate, reference) == ssim(reference, estimate)


def test_ssim_ignores_what_lies_far_outside_the_mask():
    rng = np.random.default_rng(2)
    reference = rng.random((40, 40))
    estimate = reference.copy()
    estimate[30:] = 0
    mask = np.zeros((40, 40), bool)
    mask[:20] = True
    assert ssim(estimate, reference, mask) == pytest.approx(1.0)
    assert ssim(estimate, reference) < 0.9


def test_normals_by_hand():
    reference = normals([0, 0, 1], [0, 0, 1])
    estimate = normals([0, 0, 1], [1, 0, 0])
    assert normal_angle_deg(estimate, reference) == pytest.approx(45.0)
    assert normal_rmse(estimate, reference) == pytest.approx(math.sqrt(2 / 6))
    second = np.array([[False, True]])
    assert normal_angle_deg(estimate, reference, second) == pytest.approx(90.0)
    assert normal_angle_deg(-reference, reference) == pytest.approx(180.0)


def test_angles_ignore_length_and_are_exact_when_small():
    tilt = math.radians(0.01)
    reference = np.array([[[0.0, 0.0, 3.0]]])
    estimate = np.array([[[0.5 * math.sin(tilt), 0.0, 0.5 * math.cos(tilt)]]])
    assert normal_angle_deg(estimate, reference) == pytest.approx(0.01, rel=1e-6)
    assert normal_angle_deg(reference, reference) == 0.0
    assert normal_angle_deg(np.zeros((1, 1, 3)), reference) == 90.0


def test_wlog_l2_by_hand():
    # At 1 x 2 each texel is half the sphere, 2 pi; log(1 + (e - 1)) = 1 in one channel of one texel.
    reference, estimate = np.zeros((1, 2, 3)), np.zeros((1, 2, 3))
    estimate[0, 1, 2] = math.e - 1
    assert wlog_l2(estimate, reference) == pytest.approx((2 * math.pi) ** 2)


def test_wlog_l2_weighs_texels_by_their_solid_angle():
    reference = np.zeros((16, 32, 3), np.float32)
    pole, equator = reference.copy(), reference.copy()
    pole[0, 5] = 1.0
    equator[8, 5] = 1.0
    # cos 0 - cos(pi/16) = 0.0192147; cos(pi/2) - cos(9 pi/16) = 0.1950903; log 2 squared = 0.4804530.
    step = 2 * math.pi / 32
    assert wlog_l2(pole, reference) == pytest.approx(3 * 0.480453 * (step * 0.0192147) ** 2, rel=1e-5)
    assert wlog_l2(equator, reference) == pytest.approx(3 * 0.480453 * (step * 0.1950903) ** 2, rel=1e-5)


def test_wlog_l2_is_symmetric_and_zero_for_equals():
    rng = np.random.default_rng(0)
    first, second = rng.exponential(size=(2, 16, 32, 3))
    assert wlog_l2(first, second) == pytest.approx(wlog_l2(second, first))
    assert wlog_l2(first, first) == 0.0


def test_equal_values_have_an_interval_without_width():
    assert interval_over_heads(np.full(6, 2.0), np.array([0, 0, 1, 1, 2, 2])) == (2.0, 2.0, 2.0)


def test_an_interval_of_many_heads_is_what_the_normal_law_says():
    values = np.random.default_rng(0).normal(10, 2, 400)
    mean, low, high = interval_over_heads(values, np.arange(400))
    assert mean == pytest.approx(values.mean())
    error = values.std() / 20
    assert low == pytest.approx(mean - 1.96 * error, abs=0.02 * error)
    assert high == pytest.approx(mean + 1.96 * error, abs=0.02 * error)


def test_an_interval_of_few_heads_by_hand():
    """Means 1, 2 and 6: mean 3, standard deviation sqrt 7, Student's t of 2 degrees of freedom 4.302653."""
    mean, low, high = interval_over_heads(np.array([0.0, 2.0, 2.0, 2.0, 5.0, 7.0]), np.array(list("aabbcc")))
    assert mean == 3.0
    assert high - mean == pytest.approx(4.302653 * math.sqrt(7 / 3), rel=1e-6)
    assert mean - low == pytest.approx(high - mean)


@pytest.mark.parametrize("pictures", [1, 20])
def test_intervals_of_eight_heads_hold_the_truth_as_often_as_they_say(pictures):
    rng, held = np.random.default_rng(2), 0
    for _ in range(400):
        values = rng.normal(0, 1, 8)[:, None] + rng.normal(0, 2, (8, pictures))
        _, low, high = interval_over_heads(values.ravel(), np.repeat(np.arange(8), pictures))
        held += low <= 0 <= high
    assert held / 400 == pytest.approx(0.95, abs=0.03)


def test_more_pictures_of_the_same_heads_make_no_surer():
    values = np.random.default_rng(1).normal(size=12)
    once = interval_over_heads(values, np.arange(12))
    tenfold = interval_over_heads(np.repeat(values, 10), np.repeat(np.arange(12), 10))
    assert tenfold == pytest.approx(once)


def test_heads_weigh_by_their_pictures_and_may_have_any_name():
    """The sums are 3 of three pictures and 5 of one: off by 3 from what a mean of 2 gives them, both."""
    mean, low, high = interval_over_heads(np.array([1.0, 1.0, 1.0, 5.0]), np.array(["ann", "ann", "ann", "bob"]))
    assert mean == 2.0
    # Student's t of 1 degree of freedom is 12.706205; sqrt(2 / 1 * (9 + 9)) / 4 = 1.5.
    assert (low, high) == (pytest.approx(2 - 12.706205 * 1.5), pytest.approx(2 + 12.706205 * 1.5))


def test_an_interval_ends_where_the_figure_does():
    assert Interval(0.1, -0.3, 0.5).within(0.0, math.inf) == (0.1, 0.0, 0.5)
    assert Interval(0.9, 0.5, 1.3).within(-1.0, 1.0) == (0.9, 0.5, 1.0)
    assert Interval(0.2, 0.1, 0.3).within(0.0, 1.0) == (0.2, 0.1, 0.3)
    assert all(math.isnan(end) for end in Interval(0.2, math.nan, math.nan).within(0.0, 1.0)[1:])


def test_confidence():
    values, heads = np.random.default_rng(2).random(30), np.arange(30) // 3
    wide, narrow = (interval_over_heads(values, heads, confidence=c) for c in (0.99, 0.5))
    assert wide.low < narrow.low < narrow.mean < narrow.high < wide.high


def test_one_head_says_nothing_about_others():
    mean, low, high = interval_over_heads(np.array([1.0, 3.0]), np.array([7, 7]))
    assert mean == 2.0
    assert math.isnan(low)
    assert math.isnan(high)


@pytest.mark.parametrize("measure", [rmse, psnr, ssim, normal_rmse, normal_angle_deg])
def test_what_does_not_compare_is_refused(measure):
    picture = np.zeros((16, 16, 3))
    with pytest.raises(ValueError, match="compare"):
        measure(picture[:, :12], picture)
    with pytest.raises(ValueError, match="mask is bool"):
        measure(picture, picture, np.ones((16, 16)))
    with pytest.raises(ValueError, match="mask is bool"):
        measure(picture, picture, np.ones((16, 12), bool))
    with pytest.raises(ValueError, match="no pixel"):
        measure(picture, picture, np.zeros((16, 16), bool))
    with pytest.raises(ValueError, match="compare"):
        measure(picture[:0], picture[:0])


def test_other_wrong_inputs():
    with pytest.raises(ValueError, match="compare"):
        wlog_l2(np.zeros((16, 32, 3)), np.zeros((8, 16, 3)))
    with pytest.raises(ValueError, match=r"normals are \(H, W, 3\)"):
        normal_rmse(np.zeros((4, 4)), np.zeros((4, 4)))
    with pytest.raises(ValueError, match="one head per value"):
        interval_over_heads(np.zeros(3), np.zeros(2))
    with pytest.raises(ValueError, match="one head per value"):
        interval_over_heads(np.zeros(0), np.zeros(0))
    with pytest.raises(ValueError, match="finite"):
        interval_over_heads(np.array([1.0, math.inf]), np.array([0, 1]))
    with pytest.raises(ValueError, match="confidence"):
        interval_over_heads(np.array([1.0, 2.0]), np.array([0, 1]), confidence=95)
