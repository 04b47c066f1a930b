"""Small lamps found in panoramas: direction, size and strength, and that nothing about them jumps."""

import numpy as np
import pytest

from relight_core.lighting.environment import Environment, network_light
from relight_core.lighting.lamps import Lamp, bright_places, footprint, lamps_of
from relight_core.lighting.panorama import rotate
from relight_core.lighting.roll import roll_light
from relight_core.lighting.sphere import directions, solid_angles


def unit(x, y, z):
    return np.array([x, y, z]) / np.linalg.norm([x, y, z])


def panorama(discs, fill=0.3, height=256):
    """Discs of (direction, radius in degrees, radiance) before an even light."""
    toward = directions(height, 2 * height)
    image = np.full((height, 2 * height, 3), fill, np.float32)
    for direction, radius_deg, radiance in discs:
        image[toward @ unit(*direction) > np.cos(np.radians(radius_deg))] += radiance
    return image


def light(*discs, **how):
    return Environment.from_radiance(panorama(discs, **how))


def test_a_lamp_is_found_where_it_is_as_large_as_it_is():
    sun = ((0.5, 0.4, 0.7), 2.5, 900.0)
    environment = light(sun)
    (lamp,) = lamps_of(environment)
    assert np.dot(lamp.toward, unit(*sun[0])) > np.cos(np.radians(0.3))
    assert lamp.radius_deg == pytest.approx(2.5, abs=0.4)
    assert lamp.hardness == 1
    solid_angle = 2 * np.pi * (1 - np.cos(np.radians(2.5)))
    assert lamp.irradiance * environment.level == pytest.approx(900 * solid_angle / np.pi, rel=0.06)


@pytest.mark.parametrize("height", [128, 256, 512, 1024])
@pytest.mark.parametrize("zenith_deg", [1.0, 3.0, 12.0, 60.0])
def test_a_lamp_is_as_strong_as_its_map_wherever_it_stands(zenith_deg, height):
    """Texels near the zenith are slivers: a lamp of a few of them is worth what they cover of the sphere."""
    row = int(height * zenith_deg / 180)
    image = np.zeros((height, 2 * height, 3), np.float32)
    image[row : row + max(1, height // 128), 5 : 5 + height // 64] = 1
    (lamp,) = lamps_of(Environment.from_radiance(image))
    # All of a light whose mean radiance is 1, 4 pi of it, over pi.
    assert lamp.irradiance == pytest.approx(4, rel=0.02)


@pytest.mark.parametrize("discs", [(), (((1, 0, 1), 25.0, 40.0),), (((0, 1, 0), 90.0, 3.0),)])
def test_even_light_windows_and_skies_have_none(discs):
    assert lamps_of(light(*discs)) == ()


def test_light_without_any_light_has_none():
    assert lamps_of(Environment.from_radiance(np.zeros((16, 32, 3)))) == ()


def test_a_map_of_few_texels_has_none():
    """A light that was estimated from a portrait can't tell a sun from a window."""
    texels = np.full((16, 32, 3), 0.3, np.float32)
    texels[5, 20] = 200
    assert lamps_of(Environment.from_radiance(texels)) == ()


def test_several_lamps_come_by_brightness():
    lamps = lamps_of(light(((1, 0, 0.3), 2.0, 400.0), ((-1, 0.5, 0.3), 2.0, 1500.0), ((0, 1, 0.2), 2.0, 800.0)))
    assert [round(lamp.toward[0], 1) for lamp in lamps] == [-0.9, 0.0, 1.0]


def test_the_haze_around_a_sun_is_not_that_sun_again():
    toward = directions(128, 256)
    off_deg = np.degrees(np.arccos(np.clip(toward @ unit(0.4, 0.6, -0.5), -1, 1)))
    haze = 25 * np.exp(-((off_deg / 14) ** 2)) + 0.3
    image = np.where(off_deg < 3, 1500, haze)[..., None] * np.ones(3)
    (sun,) = lamps_of(Environment.from_radiance(image))
    assert 0 < sun.irradiance <= 4, "a light of mean luminance 1 has no more to give"


def test_an_enlarged_lamp_loses_its_hardness_evenly():
    radii = np.linspace(3, 9, 13)
    power = 25.0
    found = [lamps_of(light(((0.4, 0.3, 1), radius, power * (9 / radius) ** 2))) for radius in radii]
    hardness = [lamps[0].hardness if lamps else 0.0 for lamps in found]
    assert hardness[0] == 1
    assert hardness[-1] == 0
    assert np.diff(hardness).max() < 0.02
    assert np.diff(hardness).min() > -0.3


def test_a_dimmed_lamp_loses_its_hardness():
    hardness = [max((lamp.hardness for lamp in lamps_of(light(((1, 0, 1), 2.0, r)))), default=0) for r in (600, 40, 5)]
    assert hardness[0] == 1 > hardness[1] > 0 == hardness[2]


@pytest.mark.parametrize(("radius_deg", "radiance"), [(4.0, 10.0), (5.0, 10.0), (6.0, 10.0), (6.0, 4.0)])
def test_a_bulb_that_is_no_brighter_than_a_lit_wall_is_a_lamp_if_it_gives_some_of_the_light(radius_deg, radiance):
    environment = light(((0.4, 0.3, 1), radius_deg, radiance))
    (lamp,) = lamps_of(environment)
    solid_angle = 2 * np.pi * (1 - np.cos(np.radians(radius_deg)))
    assert lamp.irradiance * environment.level == pytest.approx(radiance * solid_angle / np.pi, rel=0.15)
    assert lamp.hardness > 0.1


@pytest.mark.parametrize("yaw_deg", [45.0, -120.0, 360.0])
def test_lamps_turn_with_their_panorama(yaw_deg):
    image = panorama([((0.3, 0.5, 0.8), 3.0, 500.0)])
    (turned,) = lamps_of(Environment.from_radiance(image), yaw_deg)
    (found,) = lamps_of(Environment.from_radiance(rotate(image, yaw_deg)))
    assert np.dot(turned.toward, found.toward) > np.cos(np.radians(0.5))


def test_a_lamp_turned_twice_is_one_turned_by_both():
    (lamp,) = lamps_of(light(((0.3, 0.5, 0.8), 3.0, 500.0)))
    twice, once = lamp.turned(20.0).turned(-65.0), lamp.turned(-45.0)
    np.testing.assert_allclose(twice.toward, once.toward, atol=1e-9)
    np.testing.assert_allclose(footprint(twice), footprint(once), atol=1e-6)


def test_haze_ten_degrees_off_makes_a_sun_hardly_larger():
    toward = directions(256, 512)
    off_deg = np.degrees(np.arccos(np.clip(toward @ unit(0.4, 0.6, 0.5), -1, 1)))
    clear = np.where(off_deg < 2, 900.0, 0.3)[..., None] * np.ones(3)
    hazy = clear + ((off_deg > 10.5) & (off_deg < 11.9))[..., None]
    (sun,), (in_haze,) = (lamps_of(Environment.from_radiance(each)) for each in (clear, hazy))
    assert in_haze.radius_deg == pytest.approx(sun.radius_deg, abs=0.1)
    assert in_haze.hardness == 1


def test_lamps_come_by_what_they_give_with_an_edge():
    """A bulb nearly as large as a window gives more light than a sun here, and next to none of it has an edge."""
    lamps = lamps_of(light(((1, 0, 0.3), 2.0, 300.0), ((-1, 0, 0.3), 7.0, 60.0)))
    assert lamps[0].toward[0] > 0.9
    assert max(lamp.irradiance for lamp in lamps[1:]) > lamps[0].irradiance


@pytest.mark.parametrize("roll_deg", [30.0, -70.0])
def test_a_rolled_lamp_lies_where_the_rolled_light_has_it(roll_deg):
    environment = light(((0.2, 0.7, 0.6), 3.0, 3000.0), fill=0.0)
    (lamp,) = lamps_of(environment)
    rolled = roll_light(network_light(environment), roll_deg).mean(-1)
    power = (rolled * solid_angles(16, 32))[..., None] * directions(16, 32)
    assert np.dot(lamp.rolled(roll_deg).toward, unit(*power.sum((0, 1)))) > np.cos(np.radians(6))


@pytest.mark.parametrize("yaw_deg", [0.0, 3.0, 97.0])
def test_the_footprint_is_what_the_networks_see_of_it(yaw_deg):
    environment = light(((0.6, 0.33, 0.7), 2.0, 2000.0), fill=0.0)
    (lamp,) = lamps_of(environment, yaw_deg)
    seen = network_light(environment, yaw_deg).mean(-1)
    assert np.abs(footprint(lamp) - seen / seen.sum()).max() < 0.08


@pytest.mark.parametrize("toward", [(0.06, 1.0, 0.03), (0.2, 1.0, 0.25), (0.6, 0.33, 0.7)])
def test_a_turning_sun_leaves_the_networks_light_whole_wherever_it_stands(toward):
    environment = light((toward, 1.5, 3000.0), fill=0.0)
    areas = solid_angles(16, 32)
    for yaw_deg in (0.0, 3.0, 5.6, 8.0):
        (lamp,) = lamps_of(environment, yaw_deg)
        seen = network_light(environment, yaw_deg).mean(-1) * areas / np.pi
        assert np.minimum(footprint(lamp) * lamp.irradiance, seen).sum() > 0.98 * lamp.irradiance


@pytest.mark.parametrize("roll_deg", [10.0, 20.0, 45.0, -70.0])
@pytest.mark.parametrize("yaw_deg", [0.0, 13.0])
@pytest.mark.parametrize("toward", [(0.6, 0.33, 0.7), (0.1, 0.98, 0.2)])
def test_a_rolled_footprint_lies_in_the_texels_of_the_rolled_light(toward, yaw_deg, roll_deg):
    environment = light((toward, 2.0, 2000.0), fill=0.0)
    (lamp,) = lamps_of(environment, yaw_deg)
    power = roll_light(network_light(environment, yaw_deg), roll_deg).mean(-1) * solid_angles(16, 32)
    shared = np.minimum(footprint(lamp, roll_deg), power / power.sum()).sum()
    assert shared > 0.9


def test_the_footprint_wraps_around_behind_the_camera():
    share = footprint(Lamp((0.0, 0.0, 1.0), 1.0, 1.0, 1.0))
    assert share.sum() == pytest.approx(1)
    assert share[:, 0].sum() == pytest.approx(share[:, -1].sum(), abs=0.1)


@pytest.mark.parametrize("height", [1.0, -1.0])
@pytest.mark.parametrize("beside", [0.0, 0.02, 0.15])
def test_the_footprint_of_a_disc_at_a_pole_lies_about_it(height, beside):
    x, y, z = unit(beside, height, beside)
    share = footprint(Lamp((float(x), float(y), float(z)), 1.0, 1.0, 1.0))
    assert share.min() >= 0
    assert share.sum() == pytest.approx(1)
    at_pole = share[:2] if height > 0 else share[-2:]
    assert at_pole.sum() == pytest.approx(1)


@pytest.mark.parametrize(("radius_deg", "ratio"), [(1.5, 1.0), (2.5, 0.7), (4.0, 1.0)])
def test_two_lamps_that_come_near_each_other_lose_their_hardness_evenly(radius_deg, ratio):
    """As one they are a larger lamp; a step of a quarter of a degree must not be the one that makes them so."""
    hard = []
    for apart_deg in np.arange(24.0, 6.0, -0.25):
        angle = np.radians(apart_deg)
        other = (np.sin(angle), 0.3, np.cos(angle))
        lamps = lamps_of(light(((0, 0.3, 1), radius_deg, 900.0), (other, radius_deg, 900.0 * ratio), fill=0.2))
        hard.append(sum(lamp.irradiance * lamp.hardness for lamp in lamps))
    assert hard[0] > 2.2
    assert min(hard) < 1.2
    assert np.abs(np.diff(hard)).max() < 0.35


@pytest.mark.parametrize("apart_deg", [12.5, 10.5, 8.5])
def test_of_two_lamps_near_each_other_none_is_first(apart_deg):
    def pair(ratio):
        angle = np.radians(apart_deg / 2)
        left, right = ((side * np.sin(angle), 0.3, np.cos(angle)) for side in (-1, 1))
        lamps = lamps_of(light((left, 2.0, 900.0), (right, 2.0, 900.0 * ratio), fill=0.2))
        return sorted(lamps, key=lambda lamp: lamp.toward[0])

    for alike in (0.99, 1.01):
        one, other = pair(alike)
        assert one.hardness == pytest.approx(other.hardness, abs=0.06)
        assert one.irradiance == pytest.approx(other.irradiance, rel=0.06)
        assert one.toward[0] == pytest.approx(-other.toward[0], abs=0.01)


@pytest.mark.parametrize("side_deg", [18.0, 20.0, 22.0, 24.0, 26.0])
def test_the_corners_of_a_window_are_no_lamps(side_deg):
    toward = directions(128, 256)
    across = np.degrees(np.arctan2(toward[..., 0], -toward[..., 2]))
    up = np.degrees(np.arcsin(toward[..., 1]))
    image = np.full((128, 256, 3), 0.1, np.float32)
    image[(np.abs(across - 40) < side_deg / 2) & (np.abs(up - 20) < side_deg / 2)] = 20.0
    assert all(lamp.hardness < 0.25 for lamp in lamps_of(Environment.from_radiance(image)))


def test_specks_that_are_brighter_than_the_sun_leave_its_shadow_alone():
    sun = (0.5, 0.5, 0.7), 2.5, 150.0
    specks = [((x, -0.2, 0.6), 0.6, 200.0) for x in (-0.9, -0.5, -0.1, 0.3)]
    (found,) = (lamp for lamp in lamps_of(light(sun, *specks)) if lamp.irradiance > 0.2)
    assert found.hardness == pytest.approx(1, abs=0.01)


def test_a_fifth_lamp_takes_hardness_from_the_others_evenly():
    places = [(-0.9, 0.1, 0.4), (0.9, 0.1, 0.4), (-0.4, 0.6, 0.7), (0.4, 0.6, 0.7), (0.0, -0.4, 0.9)]
    before = None
    for percent in range(50, 130, 2):
        powers = [300.0, 303.0, 306.0, 309.0, 3.0 * percent]
        lamps = lamps_of(light(*((place, 2.5, power) for place, power in zip(places, powers, strict=True))))
        assert len(lamps) <= 4
        hardness = np.zeros(5)
        for lamp in lamps:
            hardness[int(np.argmax([np.dot(lamp.toward, unit(*place)) for place in places]))] = lamp.hardness
        if before is not None:
            assert np.abs(hardness - before).max() < 0.25
        before = hardness
    assert before[4] == 1


def test_of_five_lamps_alike_none_has_an_edge_and_all_are_bright_places():
    places = [(-0.9, 0.1, 0.4), (0.9, 0.1, 0.4), (-0.4, 0.6, 0.7), (0.4, 0.6, 0.7), (0.0, -0.4, 0.9)]
    alike = light(*((place, 2.0, 900.0) for place in places))
    assert all(lamp.hardness < 0.2 for lamp in lamps_of(alike))
    assert [round(lamp.hardness, 3) for lamp in bright_places(alike)] == [1.0] * 5
