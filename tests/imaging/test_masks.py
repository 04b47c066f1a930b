"""Where masks lie, and what of them hangs together."""

import numpy as np
import pytest

from relight_core.imaging.masks import bounds, disc, distance_to, largest_part, part_at


@pytest.mark.parametrize("kind", [bool, np.float32])
def test_bounds_are_the_rows_and_columns_about_all_of_a_mask(kind):
    mask = np.zeros((6, 9), kind)
    mask[1, 4] = mask[3, 2] = 1
    assert bounds(mask) == (slice(1, 4), slice(2, 5))
    assert mask[bounds(np.zeros_like(mask))].size == 0


def test_faint_shares_count_as_much_as_full_ones():
    mask = np.zeros((4, 4), np.float32)
    mask[2, 3] = 1e-9
    assert bounds(mask) == (slice(2, 3), slice(3, 4))


def test_the_largest_part_hangs_together_over_corners_too():
    mask = np.zeros((5, 8), bool)
    mask[0, 0] = mask[1, 1] = mask[2, 2] = True
    mask[4, 5:7] = True
    part = largest_part(mask)
    assert np.argwhere(part).tolist() == [[0, 0], [1, 1], [2, 2]]
    assert largest_part(mask, 3).sum() == 3
    assert largest_part(mask, 4) is None
    assert largest_part(np.zeros_like(mask)) is None


def test_the_part_at_a_place_is_the_one_that_most_of_it_lies_in():
    mask = np.zeros((6, 9), bool)
    mask[0, 0] = mask[1, 1] = True
    mask[4:6, 3:9] = True
    place = np.zeros_like(mask)
    place[:2, :2] = place[4, 3] = place[:4, 5:] = True
    assert np.argwhere(part_at(mask, place)).tolist() == [[0, 0], [1, 1]]
    place[5, 3:5] = True
    assert part_at(mask, place).sum() == 12
    assert part_at(mask, ~mask) is None
    assert part_at(np.zeros_like(mask), ~mask) is None


def test_a_disc_has_a_middle_and_reaches_its_radius():
    assert disc(0.1).shape == (3, 3)
    assert disc(2.6).shape == (7, 7)
    assert disc(2.6)[3].all()
    assert disc(2.6)[0, 0] == 0


def test_the_largest_part_may_come_last_and_be_more_than_all_that_is_left_out():
    mask = np.ones((6, 6), bool)
    mask[1], mask[0, 3:] = False, False
    np.testing.assert_array_equal(np.unique(np.argwhere(largest_part(mask))[:, 0]), [2, 3, 4, 5])
    assert largest_part(mask).sum() == 24


def test_distances_lead_to_the_nearest_place_and_are_finite_where_there_is_none():
    where = np.zeros((9, 12), bool)
    where[4, 2] = where[4, 11] = True
    distance = distance_to(where)
    np.testing.assert_allclose(distance[4], [2, 1, 0, 1, 2, 3, 4, 4, 3, 2, 1, 0], atol=0.01)
    assert distance[0, 2] == pytest.approx(4, abs=0.01)
    assert (distance_to(np.zeros((9, 12), bool)) == 21).all()
