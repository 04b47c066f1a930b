"""Where the person network looks."""

import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.face.person_view import face_in_view, inside_photo, person_view, upright, wider_view

CROP = Crop(500.0, 400.0, 256.0)
"""Its face is 196 pixels wide."""


def test_a_view_in_a_large_photo_is_3_4_faces_wide_and_lies_lower_than_the_face():
    view = person_view(CROP, (2000, 3000))
    assert view.side == pytest.approx(3.4 * 196)
    assert view.centre_x == 500
    assert view.centre_y == pytest.approx(400 + 0.35 * 196)


def test_a_view_stays_within_the_photo_where_there_is_room():
    x0, y0, x1, _ = person_view(Crop(100.0, 100.0, 128.0), (1000, 1000)).window
    assert (x0, y0) == pytest.approx((0, 0), abs=1e-9)
    assert x1 <= 1000


def test_a_view_of_a_narrow_photo_is_as_wide_as_it_is_high_and_centred():
    view = person_view(CROP, (600, 300))
    assert (view.side, view.centre_x, view.centre_y) == (600, 150, 300)
    inside = inside_photo(view, (600, 300), 64)
    assert inside.mean() == pytest.approx(0.5, abs=0.02)
    assert inside[:, 32].all()
    assert not inside[:, 0].any()


def test_the_face_is_marked_where_the_crop_has_it():
    view = person_view(CROP, (2000, 3000))
    face = face_in_view(view, CROP, 256)
    rows, columns = np.nonzero(face)
    middle = view.to_photo(np.array([columns.mean() + 0.5, rows.mean() + 0.5]), 256)
    np.testing.assert_allclose(middle, [500, 400], atol=3)
    assert np.ptp(columns) + 1 == pytest.approx(256 / 3.4, abs=2)


def test_a_leaning_head_is_seen_upright_with_its_shoulders_below():
    leaning = Crop(500.0, 400.0, 256.0, roll_deg=30.0)
    view = person_view(leaning, (2000, 3000))
    assert view.roll_deg == 30
    shoulders = leaning.to_photo(np.array([128, 128 + 0.35 * 196]), 256)
    np.testing.assert_allclose([view.centre_x, view.centre_y], shoulders, atol=1e-6)
    rows, columns = np.nonzero(face_in_view(view, leaning, 128))
    assert columns.mean() == pytest.approx(63.5, abs=0.6)
    assert rows.mean() < 60


def test_a_wider_view_reaches_down_to_the_hips():
    view = wider_view(Crop(1500.0, 400.0, 256.0), (4000, 3000))
    assert view.side == pytest.approx(4.8 * 196)
    assert view.centre_x == 1500
    assert 1.35 < (400 - view.window[1]) / 196 < 1.9
    assert (view.window[3] - 400) / 196 > 3.2


@pytest.mark.parametrize(
    ("roll_deg", "turned_deg"), [(0.0, 0), (30.0, 0), (-44.0, 0), (50.0, 90), (-90.0, -90), (170.0, 180)]
)
def test_a_body_is_looked_for_as_the_photo_lies(roll_deg, turned_deg):
    crop = upright(Crop(500.0, 400.0, 256.0, roll_deg))
    assert crop == Crop(500.0, 400.0, 256.0, turned_deg)


def test_no_wider_view_is_taken_of_what_has_been_seen():
    assert wider_view(CROP, (700, 700)) is None
    assert wider_view(CROP, (740, 900)).side == pytest.approx(900)


@pytest.mark.parametrize("roll_deg", [-25.0, 12.0, 25.0])
def test_a_leaning_head_that_fills_its_photo_is_seen_whole(roll_deg):
    """A view as wide as the upright photo, below the face, would cut the top of a head off."""
    view = person_view(Crop(540.0, 552.0, 920.0, roll_deg), (1024, 1024))
    corners = np.array([[1, 1], [1023, 1], [1, 1023], [1023, 1023]], float)
    seen = view.from_photo(corners, 1)
    assert (seen >= 0).all()
    assert (seen <= 1).all()


def test_a_face_that_fills_more_than_the_photo_is_seen_whole():
    assert person_view(Crop(50.0, 50.0, 256.0), (100, 100)).side == pytest.approx(196)
