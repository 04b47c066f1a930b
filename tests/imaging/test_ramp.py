"""A straight way from 0 to 1, in either direction."""

import numpy as np
import torch

from relight_core.imaging.ramp import ramp, smooth_ramp


def test_it_rises_from_the_start_and_stays_within_0_and_1():
    expected = torch.tensor([0.0, 0.0, 0.25, 1.0, 1.0])
    torch.testing.assert_close(ramp(torch.tensor([-9.0, 2.0, 3.0, 6.0, 99.0]), 2.0, 6.0), expected)


def test_it_falls_where_the_full_end_is_the_smaller_one():
    torch.testing.assert_close(ramp(torch.tensor([9.0, 6.0, 3.0, 1.0]), 6.0, 2.0), torch.tensor([0.0, 0.0, 0.75, 1.0]))


def test_it_takes_arrays_as_well():
    np.testing.assert_allclose(ramp(np.array([1.0, 3.0, 9.0]), 2.0, 6.0), [0.0, 0.25, 1.0])


def test_a_number_stays_within_0_and_1_too():
    assert [ramp(value, 2.0, 6.0) for value in (-9.0, 3.0, 99.0)] == [0.0, 0.25, 1.0]
    assert [ramp(value, 6.0, 2.0) for value in (-9.0, 3.0, 99.0)] == [1.0, 0.75, 0.0]


def test_a_smooth_one_is_flat_at_both_ends_and_even_about_its_middle():
    assert [smooth_ramp(value, 2.0, 6.0) for value in (-9.0, 2.0, 3.0, 4.0, 5.0, 6.0, 99.0)] == [
        *(0.0, 0.0, 0.15625, 0.5, 0.84375, 1.0, 1.0)
    ]
    ends = smooth_ramp(np.array([0.001, 0.999]), 0.0, 1.0)
    np.testing.assert_allclose(ends, [3e-6, 1 - 3e-6], atol=1e-8)
