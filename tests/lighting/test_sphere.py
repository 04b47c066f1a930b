"""Directions on a lat-long map, and where directions lie on it."""

import math

import numpy as np
import pytest

from relight_core.lighting.sphere import (
    direction_at,
    directions,
    off_axis,
    place_on_map,
    turn_fraction,
    turned,
    uv_of,
    without_whole_turns,
)


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
    # 280 degrees, or 80 to the other side, after so many whole turns that radians would round them away.
    many, one = (turned(np.array([0.2, 0.5, 0.8]), yaw_deg) for yaw_deg in (1e16, -80.0))
    np.testing.assert_allclose(many, one, atol=1e-12)


def test_panorama_positions_and_directions_are_each_others_inverse():
    grid = directions(8, 16)
    for row in range(8):
        for column in range(16):
            u, v = (column + 0.5) / 16, (row + 0.5) / 8
            assert np.allclose(direction_at(u, v), grid[row, column], atol=1e-6)
            assert uv_of(grid[row, column]) == pytest.approx((u, v), abs=1e-6)
    assert 0.0 <= uv_of([-1e-17, 0.0, 1.0])[0] < 1.0


def test_a_turn_moves_directions_as_it_moves_the_panorama():
    u, v = 0.3, 0.4
    assert np.allclose(turned(direction_at(u, v), 36.0), direction_at(u + 0.1, v))


def test_a_direction_by_its_angles_starts_at_the_camera_and_goes_by_the_right_to_the_top():
    found = [off_axis(*angles) for angles in ((0, 77), (90, 0), (90, 90), (180, 0))]
    np.testing.assert_allclose(found, [(0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 0, -1)], atol=1e-12)


@pytest.mark.parametrize(
    ("yaw_deg", "left_deg", "fraction"),
    [
        (40.0, 40.0, 1 / 9),
        (-90.0, -90.0, 0.75),
        (270.0, -90.0, 0.75),
        (-1e-20, -1e-20, 0.0),
        (-720.0, 0.0, 0.0),
        # So many turns that in radians or single precision no part of one is left.
        (360e12 + 90.0, 90.0, 0.25),
    ],
)
def test_whole_turns_are_taken_off_an_angle_exactly(yaw_deg, left_deg, fraction):
    assert without_whole_turns(yaw_deg) == left_deg
    assert turn_fraction(yaw_deg) == fraction


@pytest.mark.parametrize("yaw_deg", [math.nan, math.inf, -math.inf])
def test_an_angle_that_is_none_is_refused(yaw_deg):
    for taken in (without_whole_turns, turn_fraction):
        with pytest.raises(ValueError, match="finite angle"):
            taken(yaw_deg)
