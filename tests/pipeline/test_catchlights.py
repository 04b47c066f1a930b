"""Eyes mirror the lamps that are there, where a ball would, and nothing that comes from everywhere alike."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from drawn_eye import draw_eyes

from relight_core.face.crop import Crop
from relight_core.face.irises import Iris
from relight_core.lighting.environment import Environment
from relight_core.lighting.panorama import rotate
from relight_core.lighting.relief import march_relief
from relight_core.lighting.sphere import directions, solid_angles
from relight_core.pipeline.per_light.catchlights import (
    Catchlight,
    LitEye,
    difference_of_lights,
    mirrored_key,
    mirrored_light,
    sky_over,
)
from relight_core.pipeline.per_photo.corneas import find_cornea

IRIS = Iris(100.0, 90.0, 30.0)
OPEN = LitEye(np.ones((16, 32), np.float32), np.zeros(3, np.float32))


@pytest.fixture(scope="module")
def cornea():
    # Wide open: no lid is in the way.
    photo = np.full((180, 200, 3), 0.5, np.float32)
    y, x = np.mgrid[0:180, 0:200] + 0.5
    photo[np.hypot(x - 100, y - 90) < 30] = 0.03
    return find_cornea(photo, 1.0, IRIS)


def lamp(toward, radius_deg=4.0, colour=(1.0, 1.0, 1.0), behind=0.0, rows=128):
    toward = np.array(toward) / np.linalg.norm(toward)
    lit = directions(rows, 2 * rows) @ toward > np.cos(np.radians(radius_deg))
    radiance = np.where(lit[..., None], np.array(colour) * 100, behind)
    return Environment.from_radiance(radiance.astype(np.float32))


def middle_of(mirrored):
    grey = mirrored.sum(-1)
    y, x = np.mgrid[0 : len(grey), 0 : len(grey)] + 0.5 - len(grey) / 2
    return (grey * x).sum() / grey.sum(), (grey * y).sum() / grey.sum()


@pytest.mark.parametrize("toward", [(0, 0, 1), (0.6, 0.5, 1), (-0.8, 0.3, 0.7), (0.2, -0.4, 1)])
def test_a_lamp_is_seen_where_a_ball_mirrors_it(cornea, toward):
    mirrored = mirrored_light(cornea, OPEN, lamp(toward), 0.0)
    halfway = np.array(toward) / np.linalg.norm(toward) + (0, 0, 1)
    halfway /= np.linalg.norm(halfway)
    across, down = middle_of(mirrored)
    # A ball of 7.8 mm whose iris is 5.9 mm, 30 pixels.
    assert across == pytest.approx(halfway[0] * 30 * 7.8 / 5.9, abs=0.7)
    assert down == pytest.approx(-halfway[1] * 30 * 7.8 / 5.9, abs=0.7)


def test_a_large_eye_shows_to_half_a_pixel_where_a_lamp_is_and_a_small_lamp_small():
    y, x = np.mgrid[0:360, 0:400] + 0.5
    photo = np.where(np.hypot(x - 200, y - 180) < 60, 0.03, 0.5)[..., None] * np.ones(3, np.float32)
    large = find_cornea(photo.astype(np.float32), 1.0, Iris(200.0, 180.0, 60.0))
    for toward in ((0, 0, 1), (0.3, 0.5, 1), (-0.5, -0.3, 0.9)):
        halfway = np.array(toward) / np.linalg.norm(toward) + (0, 0, 1)
        halfway *= 60 * 7.8 / 5.9 / np.linalg.norm(halfway)
        found = middle_of(mirrored_light(large, OPEN, lamp(toward, 3.0, rows=256), 0.0))
        assert found == pytest.approx((halfway[0], -halfway[1]), abs=0.4)
    grey = mirrored_light(large, OPEN, lamp((0.3, 0.3, 1), 2.0, rows=256), 0.0).sum(-1)
    # Four degrees are two of the ball's normals, 2.8 pixels, and the lens adds what it blurs.
    assert (grey > 0.5 * grey.max()).sum() < 35


@pytest.mark.parametrize("rows", [16, 64])
def test_it_does_not_matter_where_a_panorama_has_its_seam(cornea, rows):
    """It lies where the camera is, of which eyes mirror most."""
    radiance = np.random.default_rng(0).gamma(0.3, 1, (rows, 2 * rows, 3)).astype(np.float32)
    before, behind = Environment.from_radiance(radiance), Environment.from_radiance(rotate(radiance, 180.0))
    seen = mirrored_light(cornea, OPEN, before, 0.0)
    assert seen.max() > 0
    np.testing.assert_allclose(mirrored_light(cornea, OPEN, behind, -180.0), seen, atol=2e-3 * seen.max())


def test_eyes_mirror_a_light_that_was_turned_many_times_where_it_is(cornea):
    aside = lamp((-np.sin(np.radians(80)), 0.3, np.cos(np.radians(80))))
    seen = mirrored_light(cornea, OPEN, aside, -80.0)
    assert seen.max() > 1
    # Of turns by 360 degrees 2,777,778.
    np.testing.assert_allclose(mirrored_light(cornea, OPEN, aside, 1e9), seen, rtol=1e-5, atol=1e-5)


def test_it_follows_a_turn_of_the_light(cornea):
    turned = mirrored_light(cornea, OPEN, lamp((0, 0.3, 1)), -40.0)
    angle = np.radians(-40)
    there = mirrored_light(cornea, OPEN, lamp((-np.sin(angle), 0.3, np.cos(angle))), 0.0)
    assert middle_of(turned) == pytest.approx(middle_of(there), abs=0.7)


def test_a_small_lamp_that_turns_does_not_flicker_in_a_small_eye():
    y, x = np.mgrid[0:60, 0:60] + 0.5
    photo = np.where(np.hypot(x - 30, y - 30) < 10, 0.03, 0.5)[..., None] * np.ones(3, np.float32)
    small, light = find_cornea(photo.astype(np.float32), 1.0, Iris(30.0, 30.0, 10.0)), lamp((1, 0.3, 0.6), 2.5)
    sums = [mirrored_light(small, OPEN, light, float(yaw)).sum() for yaw in range(-10, 10)]
    np.testing.assert_allclose(sums, np.mean(sums), rtol=0.1)


@pytest.mark.parametrize("toward", [(0, 0, -1), (0.9, 0.1, -1)])
def test_no_lamp_behind_the_head_is_mirrored(cornea, toward):
    assert mirrored_light(cornea, OPEN, lamp(toward), 0.0).max() < 1e-3


def test_an_even_light_is_not_mirrored(cornea):
    even = Environment.from_radiance(np.ones((32, 64, 3), np.float32))
    evenly = LitEye(OPEN.seen, np.ones(3, np.float32))
    assert np.abs(mirrored_light(cornea, evenly, even, 0.0)).max() < 1e-5


def test_it_is_two_and_a_half_percent_of_what_is_before_it(cornea):
    window = Environment.from_radiance((directions(64, 128)[..., 2:] > 0.5) * np.ones(3, np.float32))
    mirrored = mirrored_light(cornea, OPEN, window, 0.0)
    middle = len(mirrored) // 2
    # A quarter of the sphere holds all of the light, whose mean is 1.
    np.testing.assert_allclose(mirrored[middle, middle], 4 * 0.025, rtol=0.05)


def test_what_does_not_reach_the_eye_is_not_mirrored(cornea):
    shadowed = replace(OPEN, seen=np.zeros((16, 32), np.float32))
    assert mirrored_light(cornea, shadowed, lamp((0.6, 0.5, 1)), 0.0).max() == 0


@pytest.mark.parametrize("roll_deg", [0.0, 90.0, -40.0])
def test_a_wall_at_the_right_of_the_photo_hides_what_comes_from_there_however_the_head_leans(cornea, roll_deg):
    view, size = Crop(100.0, 90.0, 400.0, roll_deg), 32
    places = view.to_photo(np.stack(np.meshgrid(*[np.arange(size) + 0.5] * 2), -1), size)
    wall = torch.from_numpy(np.where(places[..., 0] > 160, 0.5, 0.0).astype(np.float32))
    facing = torch.zeros(3, size, size)
    facing[2] = 1
    seen = sky_over(cornea, view, march_relief(wall, facing, torch.ones(size, size)), 64).seen
    x, _, z = np.moveaxis(directions(16, 32), -1, 0)
    right, left = (seen[(side * x > 0.7) & (z > 0.1)].mean() for side in (1, -1))
    assert right < 0.3
    assert left > 0.8


def test_it_has_the_lamps_colour(cornea):
    mirrored = mirrored_light(cornea, OPEN, lamp((0, 0.3, 1), colour=(1.0, 0.5, 0.1)), 0.0)
    at = np.unravel_index(mirrored[..., 0].argmax(), mirrored.shape[:2])
    np.testing.assert_allclose(mirrored[at] / mirrored[at][0], (1.0, 0.5, 0.1), rtol=0.02)


def test_a_panorama_of_any_size_gives_as_much_light(cornea):
    sums = [mirrored_light(cornea, OPEN, lamp((0.2, 0.3, 1), 12.0, rows=rows), 0.0).sum() for rows in (64, 128, 512)]
    np.testing.assert_allclose(sums, sums[1], rtol=0.1)


def test_it_ends_within_its_square(cornea):
    everything = Environment.from_radiance((directions(64, 128)[..., 2:] > 0) * np.ones(3, np.float32))
    mirrored = mirrored_light(cornea, OPEN, everything, 0.0)
    assert mirrored[0].max() < 1e-3 * mirrored.max()
    assert mirrored[:, -1].max() < 1e-3 * mirrored.max()


def test_a_light_is_another_by_where_it_comes_from_alone():
    light = np.random.default_rng(0).gamma(0.5, 1, (16, 32, 3)).astype(np.float32)
    assert difference_of_lights(light, light) == 0
    assert difference_of_lights(light * 7, light) < 1e-5
    assert difference_of_lights(np.roll(light, 8, axis=1), light) == 1
    slightly = [difference_of_lights(light + step * np.roll(light, 8, axis=1), light) for step in (0.01, 0.03, 0.05)]
    assert 0 < slightly[0] < slightly[1] < slightly[2] < 1
    black = np.zeros_like(light)
    assert np.isfinite([difference_of_lights(black, light), difference_of_lights(black, black)]).all()


def test_a_light_is_another_by_what_comes_from_elsewhere_and_not_by_how_many_texels_that_fills():
    light = np.ones((16, 32, 3), np.float32)
    share = float(solid_angles(16, 32)[0].sum() / (4 * np.pi))
    above = light.copy()
    above[0] += 0.02 / share
    # Two percent of it came anew, all but what was there in that direction before.
    assert difference_of_lights(above, light) == pytest.approx(0.02 / 1.02 * (1 - share) / 0.1, rel=1e-3)


def test_what_is_mirrored_is_named_by_what_the_light_looks_like_alone():
    radiance = np.random.default_rng(0).gamma(0.5, 1, (32, 64, 3)).astype(np.float32)
    light, other = Environment.from_radiance(radiance, "a"), Environment.from_radiance(radiance[:, ::-1], "a")
    assert mirrored_key(light) == mirrored_key(Environment.from_radiance(radiance, "b").at_level(7.0))
    assert mirrored_key(light) != mirrored_key(other)


@pytest.mark.parametrize("iris", [(103.0, 91.0, 3.0), (103.0, 91.0, 40.0), (100.0, 90.0, 0.1)])
def test_an_eye_lies_in_the_pixels_of_the_surface_that_its_iris_covers(cornea, iris):
    seen = replace(cornea, iris=Iris(*iris))
    facing = torch.zeros(3, 32, 32)
    facing[2] = 1
    flat = march_relief(torch.zeros(32, 32), facing, torch.ones(32, 32))
    sky = sky_over(seen, Crop(100.0, 90.0, 200.0, 0.0), flat, 64)
    weights = np.zeros((64, 64))
    weights[sky.place] = sky.weights
    assert weights.sum() == pytest.approx(1, abs=1e-5)
    # The view is of 200 pixels of the photo, from 0 across and from -10 down.
    y, x = np.mgrid[0:64, 0:64] + 0.5
    middle = (weights * x).sum() * 200 / 64, (weights * y).sum() * 200 / 64 - 10
    assert middle == pytest.approx(iris[:2], abs=0.6)


def test_the_photos_own_catchlight_goes_as_the_new_one_comes():
    photo = draw_eyes(((100.0, 90.0, 30.0),), (180, 200), specks=((108, 82, 5),))
    cornea = find_cornea(photo, 1.0, IRIS)
    new, gain = np.full_like(cornea.mirrored, 0.2), np.full_like(cornea.mirrored, 0.5)
    np.testing.assert_array_equal(Catchlight(cornea, new, 0.0).change(gain), 0)
    np.testing.assert_allclose(Catchlight(cornea, new, 1.0).change(gain), 0.2 - 0.5 * cornea.mirrored, atol=1e-6)
    np.testing.assert_allclose(Catchlight(cornea, new, 0.5).change(gain), 0.1 - 0.25 * cornea.mirrored, atol=1e-6)
