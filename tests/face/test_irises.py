"""Irises are found to a pixel where a photo shows them, and nowhere else."""

import numpy as np
import pytest
from drawn_eye import draw_eyes, parse_eyes

from relight_core.face.crop import Crop
from relight_core.face.irises import find_irises

PAIR = ((90.0, 100.0, 16.0), (205.0, 104.0, 16.0))
VIEW = Crop(150.0, 100.0, 260.0)


def found(irises=PAIR, view=VIEW, exposure=1.0, photo=None, **drawn):
    photo = draw_eyes(irises, **drawn) if photo is None else photo
    return find_irises(photo, exposure, parse_eyes(irises, view), view)


@pytest.mark.parametrize("drawn", [{}, {"iris": 0.2, "pupil": 0.01}, {"specks": ((94, 95, 3), (209, 99, 3))}])
def test_both_are_found(drawn):
    seen = found(**drawn)
    assert len(seen) == 2
    for iris, (x, y, radius) in zip(seen, PAIR, strict=True):
        assert abs(iris.x - x) < 1.5
        assert abs(iris.y - y) < 2.5
        assert abs(iris.radius - radius) < 2


def test_it_does_not_matter_how_a_photo_is_exposed():
    usual = found()
    dark = found(photo=draw_eyes(PAIR) * np.float32(0.01), exposure=100.0)
    assert [(i.x, i.y, i.radius) for i in usual] == [(i.x, i.y, i.radius) for i in dark]


def test_in_a_head_that_leans():
    seen = found(view=Crop(150.0, 100.0, 260.0, 15.0))
    assert len(seen) == 2
    assert all(np.hypot(i.x - x, i.y - y) < 3 for i, (x, y, _) in zip(seen, PAIR, strict=True))


@pytest.mark.parametrize("drawn", [{"opened": 0.0}, {"iris": 0.5, "pupil": 0.5}])
def test_closed_eyes_and_those_of_statues_have_none(drawn):
    assert found(**drawn) == ()


def test_lashes_and_brows_are_no_irises():
    photo = draw_eyes(PAIR, iris=0.15, pupil=0.15)
    y, x = np.mgrid[:200, :300] + 0.5
    for at_x, at_y, radius in PAIR:
        photo[np.hypot(x - at_x, y - at_y + 18) < radius] = 0.02
    assert all(abs(iris.y - y) < 2.5 for iris, (_, y, _) in zip(found(photo=photo), PAIR, strict=True))


def test_an_eye_that_is_hardly_one_makes_the_other_doubtful():
    photo, veiled = draw_eyes(PAIR), draw_eyes(PAIR, iris=0.28, pupil=0.28)
    assert found(photo=np.hstack([photo[:, :150], veiled[:, 150:]])) == ()


def test_eyes_of_few_pixels_have_none():
    irises = ((90.0, 100.0, 3.0), (120.0, 100.0, 3.0))
    assert found(irises, Crop(105.0, 100.0, 80.0)) == ()


def test_no_eyes_have_none():
    parsing = np.zeros((14, 64, 64), np.float32)
    assert find_irises(draw_eyes(PAIR), 1.0, parsing, VIEW) == ()


def test_an_eye_that_the_photos_border_cuts_leaves_the_other_its_iris():
    (iris,) = found(((4.0, 100.0, 16.0), (120.0, 100.0, 16.0)), Crop(60.0, 100.0, 260.0))
    assert (iris.x, iris.y, iris.radius) == pytest.approx((120, 100, 16), abs=1.5)


@pytest.mark.parametrize("value", [0.0, 1e-8, 1e6])
def test_flat_photos_are_no_fault(value):
    assert found(photo=np.full((200, 300, 3), value, np.float32)) == ()


@pytest.mark.parametrize(("right", "down"), [(10.0, 0.0), (-10.0, 3.0)])
def test_irises_that_look_aside_are_found_where_they_are(right, down):
    moved = tuple((x + right, y + down, radius) for x, y, radius in PAIR)
    seen = find_irises(draw_eyes(moved), 1.0, parse_eyes(PAIR, VIEW), VIEW)
    assert len(seen) == 2
    for iris, (x, y, _) in zip(seen, moved, strict=True):
        assert abs(iris.x - x) < 1.5
        assert abs(iris.y - y) < 2.5
