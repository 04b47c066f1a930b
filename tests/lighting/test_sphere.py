"""Directions on a lat-long map, and where directions lie on it."""

import numpy as np
import pytest

from relight_core.lighting.sphere import directions, off_axis, place_on_map, turned


def test_where_directions_lie_is_where_they_came_from():
    across, down = place_on_map(*np.moveaxis(7.0 * directions(6, 12).astype(float), -1, 0))
    np.testing.assert_allclose(across * 12 - 0.5, np.tile(np.arange(12), (6, 1)), atol=1e-5)
    np.testing.assert_allclose(down * 6 - 0.5, np.tile(np.arange(6)[:, None], (1, 12)), atol=1e-5)


@pytest.mark.parametrize(("direction", "place"), [((0, 0, -1), 0.5), ((1, 0, 0), 0.75), ((-1, 0, 0), 0.25)])
def test_the_middle_looks_away_from_the_camera_and_the_right_is_x(direction, place):
    across, down = place_on_map(*(float(part) for part in direction))
    assert (across, down) == (pytest.approx(place), pytest.approx(0.5))


def test_a_turn_moves_to_the_right():
    moved, _ = place_on_map(*turned(np.array([0.0, 0.3, -1.0]), 36.0))
    assert moved == pytest.approx(0.6)
    np.testing.assert_allclose(turned(np.array([0.2, 0.5, 0.8]), 360.0), [0.2, 0.5, 0.8], atol=1e-12)


def test_a_direction_by_its_angles_starts_at_the_camera_and_goes_by_the_right_to_the_top():
    found = [off_axis(*angles) for angles in ((0, 77), (90, 0), (90, 90), (180, 0))]
    np.testing.assert_allclose(found, [(0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 0, -1)], atol=1e-12)
