"""What is put behind the person: a colour, or what the camera sees of the light."""

import numpy as np
import pytest

from relight_core.imaging.black_level import Black
from relight_core.imaging.photo import with_black
from relight_core.lighting.environment import Environment
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.results.backdrop import backdrop_panorama, make_backdrop

BLUE = np.float32([0.014444, 0.051269, 0.116971])


def test_a_colour_is_the_light_that_a_screen_shows_by_its_code():
    for name in ("#204060", "#204060".upper()):
        made = make_backdrop(name, None)
        np.testing.assert_allclose(made.picture, BLUE, rtol=1e-3)
        np.testing.assert_allclose(made.soft, BLUE, rtol=1e-3)
    np.testing.assert_allclose(make_backdrop("#ffFFff", None).picture, 1.0, rtol=1e-5)


def test_a_colour_stays_as_it_was_chosen_where_something_lies_over_the_picture():
    black = Black(np.float32([0.02, 0.03, 0.05]))
    made = make_backdrop("#204060", None, black=black)
    np.testing.assert_allclose(with_black(made.picture, black), BLUE, rtol=1e-3)
    np.testing.assert_allclose(made.soft, BLUE, rtol=1e-3)


@pytest.mark.parametrize("size", [(120, 200), (200, 120)])
def test_what_wraps_round_the_person_is_the_light_behind_blurred_and_as_bright(size):
    panorama = np.full((*size, 3), 0.5, np.float32)
    panorama[55:65, 55:65] = 50.0
    made = make_backdrop("light", panorama)
    assert made.picture is panorama
    assert max(made.soft.shape) <= 64
    assert made.soft.shape[0] / made.soft.shape[1] == pytest.approx(size[0] / size[1], rel=0.05)
    assert made.soft.mean() == pytest.approx(panorama.mean(), rel=0.1)
    assert 1.0 < made.soft.max() < 10.0
    row, column = np.unravel_index(made.soft[..., 0].argmax(), made.soft.shape[:2])
    assert row / made.soft.shape[0] == pytest.approx(60 / size[0], abs=0.05)
    assert column / made.soft.shape[1] == pytest.approx(60 / size[1], abs=0.05)


@pytest.mark.parametrize("size", [(60, 90), (90, 60)])
def test_the_camera_sees_a_lamp_straight_behind_the_person_in_the_middle_and_turned_further_to_the_right(size):
    radiance = np.ones((64, 128, 3), np.float32)
    radiance[28:36, 62:66] = 40.0
    light = Environment.from_radiance(radiance)
    still, turned = (backdrop_panorama(Edit(yaw_deg=yaw), light, size)[..., 1] for yaw in (0.0, 10.0))
    assert still.shape[0] / still.shape[1] == pytest.approx(size[0] / size[1], rel=0.05)
    across = (np.arange(still.shape[1]) + 0.5) / still.shape[1]
    places = [float((seen.sum(0) * across).sum() / seen.sum()) for seen in (still, turned)]
    assert places[0] == pytest.approx(0.5, abs=0.01)
    assert places[1] > 0.52


def test_what_is_behind_is_as_bright_as_the_light():
    even = Environment.from_radiance(np.full((16, 32, 3), 3.0, np.float32))
    np.testing.assert_allclose(backdrop_panorama(Edit(), even, (6, 9)), 3.0, rtol=1e-3)
