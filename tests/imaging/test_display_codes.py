"""Linear light to 8-bit codes."""

import numpy as np
import pytest

from relight_core.imaging.colour import srgb_decode_integers, srgb_encode
from relight_core.imaging.display_codes import codes_8_bit
from relight_core.imaging.formats.icc import MatrixProfile, matrix_profile
from relight_core.imaging.formats.icc_making import DISPLAY_P3, primaries_profile

ALL = np.repeat(np.arange(256, dtype=np.uint8)[None, :, None], 3, axis=2)


def gamma(power):
    return MatrixProfile(np.tile(np.linspace(0, 1, 4096) ** power, (3, 1)), np.eye(3))


def test_every_code_comes_back():
    np.testing.assert_array_equal(codes_8_bit(srgb_decode_integers(ALL), None), ALL)


@pytest.mark.parametrize("profile", [matrix_profile(primaries_profile(DISPLAY_P3), 3), gamma(1.8), gamma(2.2)])
def test_every_code_of_a_profile_comes_back(profile):
    linear = np.stack([np.interp(ALL[..., i] / 255, np.linspace(0, 1, 4096), profile.curves[i]) for i in range(3)], -1)
    np.testing.assert_array_equal(codes_8_bit(linear.astype(np.float32), profile), ALL)


def test_each_channel_follows_its_own_curve():
    profile = MatrixProfile(np.stack([np.linspace(0, 1, 4096) ** power for power in (1.0, 2.0, 3.0)]), np.eye(3))
    codes = codes_8_bit(np.full((1, 1, 3), 0.125, np.float32), profile)
    np.testing.assert_array_equal(codes[0, 0], (32, 90, 127))
    codes = codes_8_bit(np.float32([[[0.5, 0.125, 0.008]]]), profile)
    np.testing.assert_array_equal(codes[0, 0], (128, 90, 51))


def test_codes_are_the_nearest():
    linear = np.random.default_rng(0).random((200, 200, 3), np.float32) ** 3
    error = codes_8_bit(linear, None) - srgb_encode(linear) * 255
    assert np.abs(error).max() < 0.5 + 1 / 150


def test_the_ends_stay_the_ends():
    ends = np.array([[[0.0, 1e-30, 1e-7], [1.0, 0.99999994, 1.0000001]]], np.float32)
    np.testing.assert_array_equal(codes_8_bit(ends, None), [[[0, 0, 0], [255, 255, 255]]])
