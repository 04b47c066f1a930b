"""The part of the light's panorama that the camera sees."""

import cv2
import numpy as np
import pytest

from relight_core.lighting import background
from relight_core.lighting.background import panorama_view
from relight_core.lighting.environment import Environment
from relight_core.lighting.panorama import rotate


def panorama_background(environment, yaw_deg, height, width, *view, **options):
    """What is seen, at the picture's size."""
    seen = panorama_view(environment, yaw_deg, height, width, *view, **options)
    return cv2.resize(seen, (width, height), interpolation=cv2.INTER_LINEAR)


def stripes(height=128):
    """Red grows to the right of the centre column, green with elevation: a map of directions."""
    u = (np.arange(2 * height) + 0.5) / (2 * height)
    v = (np.arange(height) + 0.5) / height
    panorama = np.ones((height, 2 * height, 3), np.float32)
    panorama[..., 0] = u[None, :] * 360 - 180 + 200
    panorama[..., 1] = 90 - v[:, None] * 180 + 100
    return Environment.from_radiance(panorama)


def angles(picture, environment):
    radiance = picture * environment.level
    return radiance[..., 0] - 200, radiance[..., 1] - 100


def test_the_centre_of_the_picture_is_the_centre_column():
    environment = stripes()
    longitude, latitude = angles(panorama_background(environment, 0, 101, 101, blur_deg=0), environment)
    assert longitude[50, 50] == pytest.approx(0, abs=0.1)
    assert latitude[50, 50] == pytest.approx(0, abs=0.1)


def test_right_is_right_up_is_up_and_the_field_of_view_is_the_longer_sides():
    environment = stripes()
    longitude, latitude = angles(panorama_background(environment, 0, 60, 121, 50, blur_deg=0), environment)
    half_pixel = 50 / 121 / 2
    assert longitude[30, -1] == pytest.approx(25 - half_pixel, abs=0.6)
    assert longitude[30, 0] == pytest.approx(-25 + half_pixel, abs=0.6)
    expected = np.degrees(np.arctan(np.tan(np.radians(25)) * 59 / 121))
    assert latitude[0, 60] == pytest.approx(expected, abs=0.6)
    assert latitude[-1, 60] == pytest.approx(-expected, abs=0.6)


def test_of_an_upright_picture_the_field_of_view_is_from_top_to_bottom():
    environment = stripes()
    longitude, latitude = angles(panorama_background(environment, 0, 121, 60, 50, blur_deg=0), environment)
    assert latitude[0, 30] == pytest.approx(25 - 50 / 121 / 2, abs=0.6)
    assert latitude[-1, 30] == pytest.approx(-25 + 50 / 121 / 2, abs=0.6)
    expected = np.degrees(np.arctan(np.tan(np.radians(25)) * 59 / 121))
    assert longitude[60, -1] == pytest.approx(expected, abs=0.6)


@pytest.mark.parametrize("height", [8, 64])
def test_it_does_not_matter_where_a_panorama_has_its_seam(height):
    radiance = np.random.default_rng(2).random((height, 2 * height, 3)).astype(np.float32)
    ahead, behind = (Environment.from_radiance(each) for each in (radiance, rotate(radiance, 180.0)))
    seen = panorama_view(ahead, 0, 60, 90, 70)
    np.testing.assert_allclose(panorama_view(behind, 180, 60, 90, 70), seen, atol=1e-3)


def test_yaw_moves_the_background_to_the_right():
    environment = stripes()
    longitude, _ = angles(panorama_background(environment, 10, 81, 81, blur_deg=0), environment)
    assert longitude[40, 40] == pytest.approx(-10, abs=0.2)


def test_whole_turns_change_nothing():
    environment = stripes()
    first = panorama_background(environment, 17, 30, 40)
    np.testing.assert_allclose(panorama_background(environment, 377, 30, 40), first, rtol=1e-4)


def test_the_seam_does_not_show():
    """Content made to be even round the sphere is as even across the map's edges."""
    u = (np.arange(256) + 0.5) / 256
    panorama = np.broadcast_to((2 + np.cos(2 * np.pi * u))[None, :, None], (128, 256, 3))
    environment = Environment.from_radiance(panorama)
    seam = panorama_background(environment, 180, 9, 200)
    assert np.abs(np.diff(seam, axis=1)).max() < 0.01


@pytest.mark.parametrize("map_height", [1, 4, 16])
def test_coarse_maps_show_no_texels(map_height):
    noise = np.random.default_rng(0).random((map_height, 2 * map_height, 3))
    environment = Environment.from_radiance(noise)
    picture = panorama_background(environment, 5, 400, 300, blur_deg=0)
    assert np.abs(np.diff(picture, axis=1)).max() < 0.03
    assert np.abs(np.diff(picture, axis=0)).max() < 0.03


def test_no_texel_has_an_edge_that_shows_as_a_crease():
    noise = np.random.default_rng(0).random((16, 32, 3))
    picture = panorama_background(Environment.from_radiance(noise), 5, 64, 64, blur_deg=0)
    assert picture.std() > 0.1
    assert np.abs(np.diff(picture, 2, axis=1)).max() < 0.03


def test_blur_brings_in_the_light_from_just_beyond_the_picture():
    panorama = np.ones((64, 128, 3), np.float32)
    panorama[:, 73:76] = 20.0  # 25 to 34 degrees to the right, where half the view is 25
    environment = Environment.from_radiance(panorama)
    row = panorama_background(environment, 0, 60, 60, 50, blur_deg=4)[30, :, 0] * environment.level
    assert row[-1] > 6.0
    assert row[0] == pytest.approx(1.0, abs=0.01)


def test_blur_softens_but_keeps_even_light():
    noise = np.random.default_rng(1).random((128, 256, 3))
    environment = Environment.from_radiance(noise)
    sharp, soft = (panorama_background(environment, 0, 64, 64, blur_deg=b) for b in (0, 4))
    assert soft.std() < 0.4 * sharp.std()
    even = Environment.from_radiance(np.ones((16, 32, 3)))
    np.testing.assert_allclose(panorama_background(even, 0, 33, 21, blur_deg=5), 1.0, rtol=1e-5)


@pytest.mark.parametrize("view", [(1, 0), (1, 20), (170, 0), (170, 20)])
def test_extreme_views_stay_finite(view):
    picture = panorama_background(stripes(64), 0, 90, 60, *view)
    assert np.isfinite(picture).all()
    assert picture.max() <= stripes(64).shape.max()


@pytest.mark.parametrize(("longer", "field_of_view_deg"), [(2000, 170), (400, 170), (100, 120)])
def test_a_sun_between_the_places_that_are_looked_up_is_seen_however_the_light_turns(longer, field_of_view_deg):
    panorama = np.full((256, 512, 3), 0.3, np.float32)
    panorama[127:129, 255:257] = 500.0
    environment = Environment.from_radiance(panorama)
    views = [panorama_view(environment, yaw, longer // 2, longer, field_of_view_deg) for yaw in np.arange(0, 3, 0.4)]
    brightest = [view.max() * environment.level for view in views]
    assert min(brightest) > 1.0
    assert max(brightest) < 2.5 * min(brightest)


@pytest.mark.parametrize("size", [(1, 1), (1, 50), (300, 2), (64, 64)])
def test_any_size_of_picture(size):
    picture = panorama_background(stripes(16), 33, *size)
    assert picture.shape == (*size, 3)
    assert picture.dtype == np.float32
    assert np.isfinite(picture).all()


@pytest.mark.parametrize("field_of_view_deg", [1e-300, 1e-5, 0.5])
def test_a_field_of_view_of_next_to_nothing_shows_one_colour(field_of_view_deg):
    picture = panorama_background(stripes(16), 33, 40, 60, field_of_view_deg, 5.0)
    assert picture.shape == (40, 60, 3)
    assert np.ptp(picture, axis=(0, 1)).max() < 0.05


@pytest.mark.parametrize(
    "wrong",
    [{"field_of_view_deg": 0}, {"field_of_view_deg": 180}, {"blur_deg": -1}, {"yaw_deg": float("nan")}],
)
def test_impossible_views_are_refused(wrong):
    with pytest.raises(ValueError, match="no view"):
        panorama_background(**{"environment": stripes(8), "yaw_deg": 0, "height": 8, "width": 8} | wrong)


@pytest.mark.parametrize(
    ("field_of_view_deg", "blur_deg", "width"), [(50, 0, 285), (50, 8, 64), (50, 2, 161), (160, 8, 1024)]
)
def test_a_blurred_view_is_drawn_no_larger_than_its_blur_calls_for(field_of_view_deg, blur_deg, width):
    seen = panorama_view(stripes(512), 0, 3000, 4000, field_of_view_deg, blur_deg)
    assert seen.shape == (pytest.approx(width * 3 / 4, abs=1), pytest.approx(width, abs=1), 3)


@pytest.mark.parametrize(("field_of_view_deg", "blur_deg"), [(50, 1), (50, 3), (120, 3), (120, 20)])
def test_drawn_smaller_a_blurred_sun_looks_as_if_drawn_finely(monkeypatch, field_of_view_deg, blur_deg):
    sunny = np.full((512, 1024, 3), 0.2, np.float32)
    sunny[230:233, 530:533] = 200.0
    environment = Environment.from_radiance(sunny)
    view = 0, 600, 800, field_of_view_deg, blur_deg
    small = panorama_background(environment, *view)
    monkeypatch.setattr(background, "_BLURRED_PX", 1e6)
    np.testing.assert_allclose(small, panorama_background(environment, *view), atol=0.03 * small.max())
