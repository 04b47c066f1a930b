"""Shares of colours: they sum to one, and their log odds tell two pictures' colours apart."""

import numpy as np

from relight_core.imaging.colour_counts import bins_of, log_odds, shares_of


def test_shares_sum_to_one_and_nothing_to_nothing():
    bins = bins_of(np.random.default_rng(0).random((20, 30, 3)))
    np.testing.assert_allclose(shares_of(bins, np.ones((20, 30))).sum(), 1.0)
    assert shares_of(bins, np.zeros((20, 30))).sum() == 0


def test_colours_beyond_the_range_count_as_its_ends():
    np.testing.assert_array_equal(bins_of(np.array([[-0.1, 0.5, 1.0]])), [[0, 8, 15]])


def test_a_colour_tells_of_the_picture_that_has_it():
    picture = np.zeros((10, 10, 3))
    picture[:, 5:] = 0.9
    bins, left = bins_of(picture), np.repeat([[1.0] * 5 + [0.0] * 5], 10, 0)
    told = log_odds(bins, shares_of(bins, left), shares_of(bins, 1 - left))
    assert told[:, :5].min() > 3
    assert told[:, 5:].max() < -3
    np.testing.assert_allclose(log_odds(bins, shares_of(bins, left), shares_of(bins, left)), 0)


def test_a_share_is_blurred_alike_into_all_three_colours_beside_it():
    shares = shares_of(np.full((1, 1, 3), 8), np.ones((1, 1)))
    beside = [shares[9, 8, 8], shares[8, 9, 8], shares[8, 8, 9]]
    np.testing.assert_allclose(beside, beside[0])
    assert 0.2 * shares[8, 8, 8] < beside[0] < shares[8, 8, 8]
