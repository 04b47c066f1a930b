"""The light as the networks read it: turned and raised evenly, with all its energy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from panoramas import ANGLES, lamp, noise, quick

from relight_core.lighting.environment import Environment, network_light
from relight_core.lighting.panorama import mean_luminance, rotate, shrink
from relight_core.lighting.sphere import solid_angles


@quick
@given(ANGLES)
def test_network_light_of_its_own_resolution_is_only_turned(yaw_deg):
    environment = Environment.from_radiance(noise(16))
    light = network_light(environment, yaw_deg)
    assert light.dtype == np.float32
    np.testing.assert_allclose(light, rotate(environment.shape, yaw_deg), atol=2e-5)


@quick
@given(st.integers(1, 70), ANGLES)
def test_network_light_keeps_the_mean_at_any_angle(height, yaw_deg):
    light = network_light(Environment.from_radiance(noise(height)), yaw_deg)
    assert mean_luminance(light) == pytest.approx(1.0, rel=1e-5)


@pytest.mark.parametrize("row", [0, 100, 128, 255])
def test_half_a_degree_moves_a_one_texel_sun_by_half_a_degree(row):
    """It crosses evenly from one new texel, 11.25 degrees wide, into the next, and stands still nowhere."""
    environment = Environment.from_radiance(lamp(256, row, 511))
    angles = np.arange(0, 24, 0.5)
    lights = np.stack([network_light(environment, yaw) for yaw in angles])
    steps = np.abs(np.diff(lights, axis=0)).max(axis=(1, 2, 3))
    assert steps.max() <= 1.05 * lights[0].sum(1).max() * 0.5 / 11.25
    assert steps.min() >= 0.3 * steps.max()
    assert (lights >= 0).all()


@pytest.mark.parametrize("height", [32, 48, 64])
def test_a_sun_of_a_coarse_map_stands_still_and_leaps_nowhere_either(height):
    environment = Environment.from_radiance(lamp(height, height // 2, 3))
    lights = np.stack([network_light(environment, yaw) for yaw in np.arange(0, 24, 0.5)])
    steps = np.abs(np.diff(lights, axis=0)).sum(axis=(1, 2, 3))
    assert steps.min() > 0.4 * steps.max()


@pytest.mark.parametrize("height", [24, 32, 48, 64, 256])
def test_a_lamp_of_any_map_rises_evenly(height):
    """By as much as it rises in the map, within what a texel's height of 11.25 degrees makes of a cosine."""
    rows = np.arange(round(0.3 * height), round(0.7 * height))
    found = []
    for row in rows:
        light = network_light(Environment.from_radiance(lamp(height, row, 5)))[..., 1]
        power = (light * solid_angles(16, 32)).sum(1)
        found.append(float(power @ (np.arange(16) + 0.5)) / power.sum() * 180 / 16)
    np.testing.assert_allclose(np.diff(found), 180 / height, rtol=0.3)
    np.testing.assert_allclose(found, (rows + 0.5) * 180 / height, atol=1.0)


@quick
@given(st.sampled_from([16, 17, 31, 64, 256]), st.floats(-40, 40))
def test_the_mean_direction_of_a_sun_is_right_to_a_tenth_of_a_texel(height, yaw_deg):
    column = height // 2
    light = network_light(Environment.from_radiance(lamp(height, height // 2, column)), yaw_deg)
    share = light[..., 0].sum(0)
    true_centre = ((column + 0.5) / (2 * height) + yaw_deg / 360) % 1 * 32 - 0.5
    assert (share @ np.arange(32)) / share.sum() == pytest.approx(true_centre, abs=0.1)


@pytest.mark.parametrize("height", [64, 256])
@pytest.mark.parametrize("from_pole", [0.0, 0.01, 0.03, 0.06])
@pytest.mark.parametrize("below", [False, True])
def test_near_a_pole_it_is_too(height, from_pole, below):
    row, column = int(from_pole * height), height // 3
    row = height - 1 - row if below else row
    light = network_light(Environment.from_radiance(lamp(height, row, column)))[..., 1].astype(float)

    def toward(rows, columns, count):
        polar, azimuth = (np.asarray(rows) + 0.5) * np.pi / count, (np.asarray(columns) + 0.5) * np.pi / count
        return np.stack([np.sin(polar) * np.cos(azimuth), np.cos(polar), np.sin(polar) * np.sin(azimuth)], -1)

    power = (light * solid_angles(16, 32))[..., None]
    mean = (toward(*np.mgrid[:16, :32], 16) * power).sum((0, 1))
    cosine = mean @ toward(row, column, height) / np.linalg.norm(mean)
    assert np.degrees(np.arccos(np.clip(cosine, -1, 1))) < 1.125


def test_a_sun_that_passes_over_the_zenith_does_not_leap():
    before, after = (network_light(Environment.from_radiance(lamp(256, 0, column))) for column in (40, 40 + 256))
    assert np.abs(before - after).max() < 0.2 * before.max()


def test_network_light_moves_right_and_wraps():
    environment = Environment.from_radiance(lamp(64, 32, 126))
    columns = [network_light(environment, yaw)[..., 0].sum(0).argmax() for yaw in (0, 11.25, 90, -90, 360)]
    assert columns == [31, 0, 7, 23, 31]


def test_callers_may_write_into_the_networks_light():
    environment = Environment.from_radiance(noise(16))
    network_light(environment)[:] = -1
    assert (network_light(environment) >= 0).all()


def test_a_small_lamp_rises_evenly_and_loses_nothing():
    def seen(row):
        lamp = np.full((256, 512, 3), 1e-3, np.float32)
        lamp[row - 3 : row + 3, 100:106] = 100.0
        light = network_light(Environment.from_radiance(lamp))
        power = (light[..., 1] * solid_angles(16, 32)).sum(1)
        assert power.sum() == pytest.approx(4 * np.pi, rel=1e-4)
        return float(power @ (np.arange(16) + 0.5)) / power.sum() * 16

    steps = np.diff([seen(row) for row in range(80, 112, 2)])
    assert steps.min() > 0.8 * steps.max() > 0


def test_even_light_stays_even_in_the_light_of_the_networks():
    light = network_light(Environment.from_radiance(np.ones((256, 512, 3), np.float32)))
    np.testing.assert_allclose(light, 1, atol=1e-4)


@pytest.mark.parametrize("brightness", [0.01, 1.0, 50.0])
def test_a_light_of_several_parts_reaches_the_networks_without_its_level(brightness):
    fine, coarse = brightness * noise(64), brightness * noise(32)
    light = Environment.of_parts(fine + shrink(coarse, 64), [fine, coarse])
    assert mean_luminance(network_light(light, 20.0)) == pytest.approx(1.0, rel=1e-5)
    (part,) = light.coarser_parts
    np.testing.assert_allclose(light.level * part, coarse, rtol=1e-5)
