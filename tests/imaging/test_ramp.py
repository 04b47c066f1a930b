"""A straight way from 0 to 1, in either direction."""

import numpy as np
import torch

from relight_core.imaging.ramp import ramp


def test_it_rises_from_the_start_and_stays_within_0_and_1():
    expected = torch.tensor([0.0, 0.0, 0.25, 1.0, 1.0])
    torch.testing.assert_close(ramp(torch.tensor([-9.0, 2.0, 3.0, 6.0, 99.0]), 2.0, 6.0), expected)


def test_it_falls_where_the_full_end_is_the_smaller_one():
    torch.testing.assert_close(ramp(torch.tensor([9.0, 6.0, 3.0, 1.0]), 6.0, 2.0), torch.tensor([0.0, 0.0, 0.75, 1.0]))


def test_it_takes_arrays_as_well():
    np.testing.assert_allclose(ramp(np.array([1.0, 3.0, 9.0]), 2.0, 6.0), [0.0, 0.25, 1.0])
