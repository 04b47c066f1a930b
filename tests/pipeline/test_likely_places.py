"""Where around a look at somebody there may be more of them, and what of a matte is theirs."""

import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.pipeline.per_photo.likely_person import attached, closed, place_faces, place_masks

SIZE = (100, 100)
CROP = Crop(50.0, 50.0, 20.0)


def placed(mask):
    return place_masks([[(mask, CROP)]], SIZE, SIZE)[0]


def test_a_face_ends_where_its_look_does():
    face = place_faces([(np.ones((8, 8), np.float32), CROP)], SIZE, SIZE)
    np.testing.assert_array_equal(face[40:60, 40:60], 1)
    face[40:60, 40:60] = 0
    assert face.max() == 0


def test_nobody_is_far_above_or_beside_a_head():
    around = placed(np.full((8, 8), 0.9, np.float32))
    assert around[:20].max() <= 0.02
    assert around[45:55, :5].max() <= 0.02
    assert around[45:55, 95:].max() <= 0.02
    assert around[70, 50] > 0.9, "but a body is below it"
    np.testing.assert_allclose(around[62, [42, 44, 55, 57]], 0.6, err_msg="with shoulders beside it")
    assert around[95, 50] == pytest.approx(0.6), "and farther down perhaps a lap"


def test_the_body_of_a_head_that_leans_is_straight_below_it():
    leaning = place_masks([[(np.full((8, 8), 0.9, np.float32), Crop(50.0, 40.0, 30.0, 30.0))]], SIZE, SIZE)[0]
    np.testing.assert_allclose(leaning[70, 46:55], 0.97)


def test_what_lies_beside_legs_is_floor_and_nobody_is_below_feet():
    around = place_masks([[(np.full((8, 8), 0.9, np.float32), Crop(50.0, 10.0, 20.0))]], SIZE, SIZE)[0]
    lap, legs = around[28], around[50]
    assert lap[[40, 50, 60]].min() >= 0.6
    assert legs[50] == pytest.approx(0.6)
    assert legs[40] == legs[59] < 0.1, "half a view beside the middle of one that is two and a half views wide"
    assert (np.diff(legs[50:]) <= 0).all()
    assert around[75:].max() <= 0.02


@pytest.mark.parametrize(("told", "meant"), [(3.0, 1.0), (np.inf, 1.0), (-2.0, 0.0), (np.nan, 0.0)])
def test_what_a_look_can_t_mean_is_brought_into_range(told, meant):
    found, right = (placed(np.full((8, 8), value, np.float32)) for value in (told, meant))
    np.testing.assert_array_equal(found, right)


def test_hair_goes_on_only_above_what_reaches_the_look_s_upper_edge():
    half = np.zeros((8, 8), np.float32)
    half[:, 4:] = 0.9
    around = placed(half)
    assert around[37:40, 53:58].min() >= 0.5
    assert around[37:40, 42:46].max() <= 0.2


def test_of_what_lies_apart_in_a_look_the_largest_is_somebody():
    matte, mask = np.zeros(SIZE, np.float32), np.zeros(SIZE, np.float32)
    for image in (matte, mask):
        image[20:80, 20:60] = image[30:36, 80:86] = 1
    kept = attached(matte, [mask])
    assert kept[20:80, 20:60].min() == 1
    assert kept[:, 70:].max() == 0
    other = np.zeros(SIZE, np.float32)
    other[28:40, 78:90] = 1
    np.testing.assert_array_equal(attached(matte, [mask, other]), matte)


@pytest.mark.parametrize("mask", [np.zeros(SIZE, np.float32), np.full(SIZE, 0.5, np.float32)])
def test_where_nobody_is_sure_a_matte_stays(mask):
    matte = np.full(SIZE, 0.4, np.float32)
    np.testing.assert_array_equal(attached(matte, [mask]), matte)


@pytest.mark.parametrize("quarters", [0, 1, 2, 3])
def test_a_bay_that_is_open_to_any_border_is_no_hole(quarters):
    matte = np.zeros((20, 20), np.float32)
    matte[5:, 4:16] = 1
    matte[10:, 8:12] = 0
    matte[7:9, 6:8] = 0.25
    found = np.rot90(closed(np.rot90(matte, quarters)), -quarters)
    assert found[10:, 8:12].max() == 0
    np.testing.assert_array_equal(found[7:9, 6:8], 1)
