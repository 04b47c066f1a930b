"""What half floats hold of radiance."""

import numpy as np
import pytest

from relight_core.imaging.half_floats import are_finite, within_halves


@pytest.mark.parametrize(
    ("value", "held"),
    [(np.nan, 0.0), (np.inf, 65504.0), (-np.inf, 0.0), (-2.0, 0.0), (1e9, 65504.0), (65504.0, 65504.0)],
)
def test_what_halves_do_not_hold_becomes_the_nearest_that_they_do(value, held):
    radiance = np.array([0.25, value, 0.5])
    limited = within_halves(radiance)
    assert limited.dtype == np.float32
    assert limited.tolist() == [0.25, held, 0.5]
    np.testing.assert_equal(radiance[1], value)


def test_what_halves_hold_is_not_copied_and_nothing_stays_nothing():
    held = np.float32([[0.0, 65504.0]])
    assert within_halves(held) is held
    assert within_halves(np.zeros((0, 3))).shape == (0, 3)


@pytest.mark.parametrize(
    ("value", "finite"),
    [(0.0, True), (65504.0, True), (-65504.0, True), (np.inf, False), (-np.inf, False), (np.nan, False)],
)
def test_finite_halves_are_told(value, finite):
    assert are_finite(np.array([[0.5, value], [-1.0, 2.0]], np.float16)) is finite
