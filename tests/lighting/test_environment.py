"""Environment maps: shape and level, turning, shrinking, and what broken files do to them."""

import warnings

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from panoramas import ANGLES, lamp, noise, quick

from relight_core.errors import InputError
from relight_core.lighting.environment import Environment, network_light, read_environment
from relight_core.lighting.panorama import mean_luminance, rotate, shrink

HEIGHTS = st.integers(1, 40)


def energy(panorama: np.ndarray) -> np.ndarray:
    height, width = panorama.shape[:2]
    bands = -np.diff(np.cos(np.pi * np.arange(height + 1) / height)) * 2 * np.pi / width
    return np.einsum("hwc,h->c", panorama.astype(np.float64), bands)


# Shape and level


def test_a_uniform_map_has_shape_one_and_its_radiance_as_level():
    environment = Environment.from_radiance(np.full((8, 16, 3), 2.5), "even")
    np.testing.assert_allclose(environment.shape, 1.0, rtol=1e-6)
    assert environment.level == pytest.approx(2.5)
    assert environment.shape.dtype == np.float32
    assert environment.name == "even"


def test_level_is_the_mean_over_the_sphere_not_over_the_pixels():
    upper_third = np.zeros((3, 6, 3), np.float32)
    upper_third[0] = 1.0
    # The cap above 60 degrees of latitude from the pole: (1 - cos 60) / 2 of the sphere.
    assert Environment.from_radiance(upper_third).level == pytest.approx(0.25)


def test_level_weighs_channels_as_the_eye_does():
    green = np.zeros((4, 8, 3), np.float32)
    green[..., 1] = 1.0
    assert Environment.from_radiance(green).level == pytest.approx(0.7152)


@pytest.mark.parametrize("scale", [1e-30, 1e-8, 1e-3, 1.0, 1e8, 1e30])
def test_the_shape_does_not_depend_on_the_level(scale):
    panorama = noise(12)
    reference = Environment.from_radiance(panorama)
    scaled = Environment.from_radiance(panorama * np.float32(scale))
    np.testing.assert_allclose(scaled.shape, reference.shape, rtol=1e-5)
    assert scaled.level == pytest.approx(reference.level * scale, rel=1e-5)
    assert mean_luminance(scaled.shape) == pytest.approx(1.0, rel=1e-5)


def test_the_faintest_light_float32_can_hold_is_still_a_light():
    environment = Environment.from_radiance(lamp(8, 4, 4, 1e-44))
    assert environment.level > 0
    assert mean_luminance(environment.shape) == pytest.approx(1.0, rel=1e-5)


def test_a_map_without_light_is_all_zero():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        environment = Environment.from_radiance(np.zeros((8, 16, 3)))
        light = network_light(environment, 37.0)
    assert environment.level == 0.0
    assert not environment.shape.any()
    assert light.shape == (16, 32, 3)
    assert not light.any()


def test_grey_maps_become_colour():
    grey = noise(6)[..., 0]
    for variant in (grey, grey[..., None]):
        shape = Environment.from_radiance(variant).shape
        assert shape.shape == (6, 12, 3)
        assert (shape[..., 0] == shape[..., 2]).all()


def test_integers_are_radiance_too():
    assert Environment.from_radiance(np.full((4, 8, 3), 7, np.uint8)).level == pytest.approx(7.0)


@pytest.mark.parametrize("level", [np.nan, -1.0])
def test_a_level_that_no_light_has_is_refused(level):
    light = Environment.from_radiance(noise(6), "a lamp")
    with pytest.raises(InputError, match="a lamp: a light's level is a number from 0 on"):
        light.at_level(level)


def test_the_callers_array_stays_as_it_was():
    panorama = noise(6)
    panorama[2, 3, 1] = np.nan
    before = panorama.copy()
    with pytest.warns(UserWarning):
        environment = Environment.from_radiance(panorama)
    panorama_after = np.nan_to_num(panorama, nan=-1)
    np.testing.assert_array_equal(panorama_after, np.nan_to_num(before, nan=-1))
    with pytest.raises(ValueError, match="read-only"):
        environment.shape[0, 0, 0] = 1.0


def test_large_maps_are_shrunk_and_keep_their_level():
    panorama = noise(50)
    small = Environment.from_radiance(panorama, max_height=20)
    assert small.shape.shape == (20, 40, 3)
    assert Environment.from_radiance(panorama, max_height=49).shape.shape == (49, 98, 3)
    assert small.level == pytest.approx(Environment.from_radiance(panorama).level, rel=1e-5)


def test_fingerprints_tell_contents_apart():
    panorama = noise(6)
    first = Environment.from_radiance(panorama, "a")
    assert first.fingerprint == Environment.from_radiance(panorama, "b").fingerprint
    assert first.fingerprint != Environment.from_radiance(panorama * 2).fingerprint
    assert first.fingerprint != Environment.from_radiance(panorama[:, ::-1]).fingerprint


def test_what_is_found_of_a_shape_is_found_once_for_all_its_levels():
    light, asked = Environment.from_radiance(noise(6)), []
    brighter = light.at_level(8 * light.level)
    for one in (brighter, light, brighter.at_level(1.0)):
        assert one.of_shape("rows", lambda shape: asked.append(1) or len(shape)) == 6
    assert len(asked) == 1
    assert (brighter.shape is light.shape, brighter.level) == (True, 8 * light.level)
    assert brighter.fingerprint != light.fingerprint == brighter.at_level(light.level).fingerprint


# Broken maps


def test_broken_values_are_counted_and_replaced():
    panorama = np.ones((8, 16, 3), np.float32)
    panorama[0, 0] = np.nan
    panorama[1, 1, 0] = -4.0
    panorama[2, 2, 1] = -np.inf
    panorama[3, 3, :2] = np.inf
    panorama[4, 4, 0] = 50.0
    with pytest.warns(UserWarning, match=r"window\.hdr: 3 NaN and 2 negative .* 2 infinite ones to 50"):
        environment = Environment.from_radiance(panorama, "window.hdr")
    radiance = environment.shape * environment.level
    assert np.isfinite(environment.shape).all()
    assert not radiance[0, 0].any()
    np.testing.assert_allclose(radiance[1, 1], [0, 1, 1], rtol=1e-5)
    np.testing.assert_allclose(radiance[2, 2], [1, 0, 1], rtol=1e-5)
    np.testing.assert_allclose(radiance[3, 3], [50, 50, 1], rtol=1e-5)


def test_doubles_beyond_float32_count_as_infinite():
    panorama = np.ones((4, 8, 3))
    panorama[0, 0, 0] = 1e200
    with pytest.warns(UserWarning, match="1 infinite ones to 1"):
        environment = Environment.from_radiance(panorama)
    np.testing.assert_allclose(environment.shape, 1.0, rtol=1e-6)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_map_with_no_finite_value_is_refused(value):
    with pytest.raises(InputError, match="sky.exr: no finite value"):
        Environment.from_radiance(np.full((4, 8, 3), value), "sky.exr")


@pytest.mark.parametrize("shape", [(8, 8, 3), (16, 8, 3), (8, 15, 3), (0, 0, 3), (1, 1)])
def test_wrong_proportions_say_what_to_do(shape):
    with pytest.raises(InputError, match="twice as wide as high.*2:1") as caught:
        Environment.from_radiance(np.ones(shape), "photo.exr")
    assert "photo.exr" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("shape", [(8,), (8, 16, 2), (8, 16, 4), (1, 8, 16, 3)])
def test_wrong_channels_are_refused(shape):
    with pytest.raises(InputError, match="1 or 3 channels"):
        Environment.from_radiance(np.ones(shape))


@pytest.mark.parametrize("height", [1, 3, 5, 17])
def test_tiny_and_odd_maps_work(height):
    environment = Environment.from_radiance(noise(height))
    light = network_light(environment, 12.3)
    assert light.shape == (16, 32, 3)
    assert mean_luminance(light) == pytest.approx(1.0, rel=1e-5)
    assert light.max() <= environment.shape.max() * (1 + 1e-6)


def test_a_panorama_file_becomes_a_light(tmp_path):
    path = tmp_path / "lamp.hdr"
    assert cv2.imwrite(str(path), lamp(16, 8, 24, 512.0))
    environment = read_environment(path)
    assert environment.name == "lamp.hdr"
    # One texel of the row below the horizon: cos(pi/2) - cos(9 pi/16) = 0.19509 of 2 * 32 texels' worth.
    assert environment.level == pytest.approx(512 * 0.1950903 / 64, rel=0.01)
    assert environment.shape[..., 1].argmax() == 8 * 32 + 24


def test_files_that_are_no_light_get_one_line(tmp_path):
    square = tmp_path / "square.hdr"
    assert cv2.imwrite(str(square), np.ones((8, 8, 3), np.float32))
    (tmp_path / "empty.exr").touch()
    for name in ("square.hdr", "empty.exr", "none.hdr"):
        with pytest.raises(InputError) as caught:
            read_environment(tmp_path / name)
        assert name in str(caught.value)
        assert "\n" not in str(caught.value)


# Turning


def test_positive_yaw_moves_content_to_the_right():
    turned = rotate(lamp(8, 4, 3), 90.0)
    assert turned[4, 7, 0] == 1e6
    assert np.count_nonzero(turned[..., 0]) == 1


def test_part_of_a_texel_is_shared_between_neighbours():
    turned = rotate(lamp(4, 2, 7, 1.0), 45.0 / 4)
    np.testing.assert_allclose(turned[2, :, 0], [0.25, 0, 0, 0, 0, 0, 0, 0.75])


@pytest.mark.parametrize("yaw_deg", [0.0, 360.0, -360.0, 720.0, 360000.0, -1e-300])
def test_whole_turns_are_the_identity(yaw_deg):
    panorama = noise(9)
    np.testing.assert_array_equal(rotate(panorama, yaw_deg), panorama)


@pytest.mark.parametrize("yaw_deg", [np.nan, np.inf, -np.inf])
def test_an_angle_that_is_none_is_refused(yaw_deg):
    with pytest.raises(ValueError, match="yaw_deg"):
        rotate(noise(4), yaw_deg)
    with pytest.raises(ValueError, match="yaw_deg"):
        network_light(Environment.from_radiance(noise(4)), yaw_deg)


@quick
@given(HEIGHTS, ANGLES)
def test_turning_keeps_every_rows_sum(height, yaw_deg):
    panorama = noise(height, 3)
    turned = rotate(panorama, yaw_deg)
    assert turned.shape == panorama.shape
    assert turned.dtype == np.float32
    np.testing.assert_allclose(turned.sum(1, np.float64), panorama.sum(1, np.float64), rtol=2e-6)


@quick
@given(HEIGHTS, ANGLES)
def test_turning_is_periodic(height, yaw_deg):
    panorama = noise(height)
    np.testing.assert_allclose(rotate(panorama, yaw_deg), rotate(panorama, yaw_deg + 360), atol=1e-4)


@quick
@given(HEIGHTS, st.integers(-100, 100), ANGLES)
def test_whole_texel_turns_add_up(height, texels, yaw_deg):
    panorama = noise(height)
    step = 180.0 / height * texels
    np.testing.assert_allclose(rotate(rotate(panorama, step), yaw_deg), rotate(panorama, step + yaw_deg), atol=1e-4)


@quick
@given(HEIGHTS, ANGLES)
def test_mirroring_turns_the_angle_round(height, yaw_deg):
    panorama = noise(height)
    np.testing.assert_allclose(rotate(panorama[:, ::-1], yaw_deg), rotate(panorama, -yaw_deg)[:, ::-1], atol=1e-4)


def test_turning_is_smooth_across_the_seam():
    """A wide soft lamp seen while it crosses the map's edge looks as anywhere else."""
    width = 64
    profile = np.exp(4 * np.cos(2 * np.pi * np.arange(width) / width))
    panorama = np.broadcast_to(profile[None, :, None], (32, width, 3)).astype(np.float32)
    steps = [np.abs(rotate(panorama, yaw + 1.0) - rotate(panorama, yaw)).max() for yaw in range(0, 360, 7)]
    texel = np.abs(np.diff(profile, append=profile[0])).max()
    assert max(steps) <= texel * width / 360 * 1.001


# Shrinking


@quick
@given(HEIGHTS, HEIGHTS)
def test_energy_is_kept_for_any_ratio(height, new_height):
    panorama = noise(height, 5)
    small = shrink(panorama, new_height)
    assert small.shape == (new_height, 2 * new_height, 3)
    np.testing.assert_allclose(energy(small), energy(panorama), rtol=2e-6)


@pytest.mark.parametrize("new_height", [1, 7, 16, 31])
@pytest.mark.parametrize(("row", "column"), [(0, 0), (0, 63), (31, 40), (16, 63), (7, 31)])
def test_a_one_texel_sun_keeps_its_energy_even_at_a_pole(row, column, new_height):
    sun = lamp(32, row, column, 1e6)
    np.testing.assert_allclose(energy(shrink(sun, new_height)), energy(sun), rtol=1e-6)


def test_shrinking_by_hand():
    panorama = np.zeros((2, 4, 3), np.float32)
    panorama[0] = np.arange(1, 5)[:, None]
    panorama[1] = np.arange(10, 50, 10)[:, None]
    # Both hemispheres weigh the same; the two texels of the result hold the left and the right half.
    np.testing.assert_allclose(shrink(panorama, 1)[0, :, 0], [(1.5 + 15) / 2, (3.5 + 35) / 2])


def test_bands_weigh_by_the_difference_of_cosines():
    panorama = np.zeros((4, 8, 3), np.float32)
    panorama[0] = 1.0
    # Latitudes 90..45 of 90..0: 1 - cos 45 degrees.
    np.testing.assert_allclose(shrink(panorama, 2)[0], 1 - np.sqrt(0.5), rtol=1e-6)
    assert not shrink(panorama, 2)[1].any()


def test_an_uneven_ratio_shares_a_column_by_its_overlap():
    panorama = np.zeros((3, 6, 3), np.float32)
    panorama[:, 1] = 1.0
    # Six columns into four: each new one covers 1.5 old ones; column 1 falls 0.5 and 0.5.
    np.testing.assert_allclose(shrink(panorama, 2)[0, :, 0], [1 / 3, 1 / 3, 0, 0], atol=1e-6)


def test_shrinking_to_the_same_size_changes_nothing():
    panorama = noise(13)
    np.testing.assert_allclose(shrink(panorama, 13), panorama, rtol=1e-6)


def test_maps_longer_than_one_block_of_rows_are_averaged_whole():
    panorama = noise(150)
    rows = panorama.astype(np.float64).mean(axis=1)
    bands = -np.diff(np.cos(np.pi * np.arange(151) / 150)) / 2
    np.testing.assert_allclose(shrink(panorama, 1).mean(axis=(0, 1)), bands @ rows, rtol=1e-6)
