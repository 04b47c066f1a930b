"""The networks see very dark and very bright photos at an exposure that they know; all others as they are."""

from dataclasses import replace

import numpy as np
import pytest
from tiny_relighter import EDIT, some_light, some_photo

from relight_core.face.crop import Crop
from relight_core.face.find import FaceBox
from relight_core.face.paste import all_of
from relight_core.imaging.photo import Photo
from relight_core.pipeline.per_photo.exposing import (
    exposed,
    exposure_about_faces,
    exposure_of_face,
    exposure_of_view,
    sampled_pixels,
)
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


def among_lights(value=0.03):
    """A face of so much in the middle of a photo that is brighter, and nowhere plain, all around."""
    photo = grey(value)
    around = np.random.default_rng(0).uniform(2.0, 5.0, (100, 100, 1)).astype(np.float32)
    around[31:69, 31:69] = value
    photo.linear[:] = around
    return photo


def test_what_the_crop_of_a_face_has_around_its_middle_does_not_count():
    assert exposure_of_face(among_lights(), CROP) == pytest.approx(5.0, rel=1e-3)


@pytest.mark.parametrize(("lit", "exposure"), [(0.06, 5.0), (0.15, 1.0), (0.45, 1.0)])
def test_a_face_that_is_dark_but_for_a_tenth_is_as_bright_as_that(lit, exposure):
    photo = grey(0.03)
    photo.linear[32:68, 32:68] *= np.random.default_rng(0).uniform(0.9, 1.0, (36, 36, 1)).astype(np.float32)
    photo.linear[32:68, 32 : 32 + round(36 * lit)] = 0.2
    assert exposure_of_face(photo, CROP) == pytest.approx(exposure, rel=0.05)


def test_a_twentieth_of_a_face_that_is_brighter_than_white_counts_up_to_twice_the_rest():
    photo = grey(0.8)
    photo.linear[32:68, 32:34] = 1.3
    assert exposure_of_face(photo, CROP) == pytest.approx(0.85 / 1.3, rel=1e-3)
    photo.linear[32:68, 32:34] = 30.0
    assert exposure_of_face(photo, CROP) == pytest.approx(0.85 / 1.6, rel=1e-3)


def uneven(value):
    """A photo of up to so much and half of that, nowhere plain."""
    noise = np.random.default_rng(0).uniform(0.5, 1.0, (100, 100, 1)).astype(np.float32)
    return Photo(value * noise.repeat(3, 2), bits=32)


@pytest.mark.parametrize(("width", "dark", "bright"), [(3, 5.0, 1.0), (20, 1.0, 1.0), (60, 1.0, 0.36)])
def test_a_view_is_dark_where_all_but_a_twentieth_of_it_is_and_too_bright_where_half_is(width, dark, bright):
    lamp, white = uneven(0.03), uneven(0.3)
    lamp.linear[:, 20 : 20 + width] *= 20
    white.linear[:, 20 : 20 + width] *= 4 / 0.3
    view = Crop(50.0, 50.0, 100.0)
    assert exposure_of_view(lamp, view) == pytest.approx(dark, rel=0.1)
    assert exposure_of_view(white, view) == pytest.approx(bright, rel=0.1)


def test_a_view_of_a_part_is_metered_there_alone():
    photo = uneven(0.03)
    photo.linear[:, 60:] *= 10
    seen = sampled_pixels(photo, Crop(30.0, 20.0, 40.0))
    assert seen.shape == (1600, 3)
    assert 0.029 < seen.max() < 0.031
    assert sampled_pixels(photo, Crop(80.0, 20.0, 40.0)).min() > 0.14


def test_of_a_framed_photo_the_picture_is_metered():
    picture = np.random.default_rng(0).uniform(0.5, 1.0, (200, 160)) * np.where(np.arange(160) < 80, 0.03, 0.5)
    picture = picture[..., None].repeat(3, 2).astype(np.float32)
    whole = Photo(np.pad(picture, ((20, 20), (60, 60), (0, 0)), constant_values=0.9), bits=32)
    assert whole.picture[0] > 55
    assert exposure_of_face(whole, Crop(98.0, 110.0, 50.0)) == pytest.approx(5.0, rel=0.1)


def test_the_exposure_of_faces_reaches_as_far_as_they_are_large():
    crops = Crop(20.0, 50.0, 10.0), Crop(80.0, 50.0, 40.0)
    about = exposure_about_faces((1.0, 16.0), crops, (100, 100))
    assert about.dtype == np.float32
    assert float(about[50, 50, 0]) > 10
    assert exposure_about_faces((3.0, 3.0), crops, (100, 100)) == 3.0


def test_what_is_exposed_stays_32_bit_and_as_it_is_where_nothing_is_to_do():
    linear, band = grey(0.25).linear, all_of((100, 100), (100, 100))
    assert exposed(linear, 1.0, band) is linear
    for exposure in (2.0, np.float64(2.0)):
        twice = exposed(linear, exposure, band)
        np.testing.assert_array_equal(twice, np.full_like(linear, 0.5))
        assert twice.dtype == np.float32
    assert linear[0, 0, 0] == 0.25


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
