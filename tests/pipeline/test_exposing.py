"""The networks see very dark and very bright photos at an exposure that they know; all others as they are."""

from dataclasses import replace

import numpy as np
import pytest
from tiny_relighter import EDIT, some_light, some_photo

from relight_core.face.crop import Crop
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.pipeline.per_photo.exposing import exposure_about_faces, exposure_of_face, exposure_of_view
from relight_core.pipeline.quality import tier_of
from relight_core.pipeline.relighter import Relighter

CROP = Crop(50.0, 50.0, 60.0)
BOXES = (FaceBox(6, 16, 50, 72), FaceBox(60, 20, 104, 76))


def grey(value, bits=32):
    return Photo(np.full((100, 100, 3), value, np.float32), bits=bits)


@pytest.mark.parametrize("value", [0.151, 0.3, 0.7, 1.0])
def test_a_photo_as_photos_are_is_seen_as_it_is(value):
    assert exposure_of_face(grey(value, 8), CROP) == 1.0
    assert exposure_of_view(grey(value, 8), CROP) == 1.0


@pytest.mark.parametrize(
    ("value", "seen"),
    [*((dark, 0.15) for dark in (1e-8, 1e-3, 0.02, 0.14)), *((lit, 0.85) for lit in (1.2, 30.0, 1e16))],
)
def test_a_dark_face_is_seen_as_the_darkest_known_and_one_brighter_than_white_below_it(value, seen):
    assert value * exposure_of_face(grey(value), CROP) == pytest.approx(seen, rel=1e-4)
    assert value * exposure_of_view(grey(value), CROP) == pytest.approx(seen, rel=1e-4)


def test_nothing_switches_where_a_photo_comes_to_be_too_bright_or_too_dark():
    for edge in (0.15, 1.0, 1.15):
        below, above = (exposure_of_face(grey(edge * nearly), CROP) for nearly in (0.999, 1.001))
        assert below == pytest.approx(above, rel=0.005)


@pytest.mark.parametrize(("bits", "most"), [(8, 32.0), (16, 1024.0)])
def test_codes_next_to_black_are_noise_and_stay_dark(bits, most):
    for value in (1e-6, 0.0):
        assert exposure_of_face(grey(value, bits), CROP) == most


def test_black_is_finite():
    assert np.isfinite(exposure_of_face(grey(0.0), CROP))


def test_a_face_is_what_counts_and_not_what_is_around_it():
    photo = grey(0.03)
    photo.linear[:25] = photo.linear[75:] = 5.0
    assert exposure_of_face(photo, CROP) == pytest.approx(5.0, rel=1e-3)


def test_glare_is_no_part_of_how_bright_a_face_is():
    photo = grey(0.4)
    photo.linear[40:50, 30:70] = 1e4
    assert exposure_of_face(photo, CROP) == 1.0


def test_a_face_at_the_border_is_metered_as_far_as_it_is_inside():
    assert exposure_of_face(grey(0.03), Crop(0.0, 0.0, 400.0)) == pytest.approx(5.0, rel=1e-3)
    assert exposure_of_face(grey(0.03), Crop(-500.0, -500.0, 40.0)) == pytest.approx(5.0, rel=1e-3)


def relit_at(weights, factor, light=None):
    photo = some_photo(3)
    photo = replace(photo, linear=photo.linear * np.float32(factor), bits=32)
    relighter = Relighter(weights)
    relighter.set_portrait(photo, boxes=BOXES)
    light = light or relighter.estimated_light("live")
    return relighter.relight(light, replace(EDIT, background="transparent")).full.render()[0], photo


@pytest.mark.usefixtures("small_and_seeing_faces")
@pytest.mark.parametrize(("one", "other"), [(1e-2, 1e-5), (20.0, 2e4)])
def test_what_a_light_makes_of_a_photo_does_not_hang_on_its_units(weights, one, other):
    light = some_light(5)
    of_one, _ = relit_at(weights, one, light)
    of_other, _ = relit_at(weights, other, light)
    assert of_one.mean() > 0.01
    np.testing.assert_allclose(of_other, of_one, atol=0.002 * float(of_one.max()))


@pytest.mark.usefixtures("small_and_seeing_faces")
@pytest.mark.parametrize("factor", [1e-5, 2e4])
def test_its_own_light_makes_the_photo_again_in_whatever_units(weights, factor):
    relit, photo = relit_at(weights, factor)
    for box in BOXES:
        part = np.s_[int(box.y0) + 8 : int(box.y1) - 8, int(box.x0) + 8 : int(box.x1) - 8]
        difference = np.abs(relit[part] - photo.linear[part])
        assert difference.mean() < 0.15 * photo.linear[part].mean()


def test_half_way_between_two_faces_the_exposure_is_half_as_many_stops():
    about = exposure_about_faces((1.0, 16.0), (Crop(20.0, 50.0, 30.0), Crop(80.0, 50.0, 30.0)), (100, 100))
    assert float(about[50, 49:51].prod() ** 0.5) == pytest.approx(4.0, rel=0.02)
    assert float(about[50, 20, 0]) < 1.1
    assert float(about[50, 80, 0]) > 14


@pytest.mark.usefixtures("small_and_seeing_faces")
def test_how_bright_faces_are_beside_each_other_is_told_in_the_photos_units(weights):
    levels = []
    for factor in (2.0**-6, 2.0**-8):
        relighter = Relighter(weights)
        relighter.set_portrait(Photo(some_photo().linear * np.float32(factor), bits=32), boxes=BOXES)
        levels.append(relighter._faces[0].exposure(tier_of("live")))
    assert levels[1] / levels[0] == pytest.approx(0.25, rel=1e-3)
