"""The sRGB curve there and back, and luminance."""

import numpy as np
import pytest

from relight_core.imaging.colour import luminance, srgb_decode, srgb_decode_integers, srgb_encode, without_colour
from relight_core.imaging.photo import Photo


def test_known_points_of_the_srgb_curve():
    linear = np.array([0.0, 0.002, 0.18, 0.5, 1.0], np.float32)
    expected = [0.0, 0.02584, 0.46136, 0.73536, 1.0]
    np.testing.assert_allclose(srgb_encode(linear), expected, atol=2e-5)


def test_encode_and_decode_are_inverse_above_one_too():
    linear = np.concatenate([np.linspace(0, 1, 500), np.geomspace(1, 1000, 50)]).astype(np.float32)
    np.testing.assert_allclose(srgb_decode(srgb_encode(linear)), linear, rtol=2e-5, atol=1e-7)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_table_decode_equals_the_formula(kind):
    codes = np.arange(0, np.iinfo(kind).max + 1, 5).astype(kind)
    formula = srgb_decode(codes.astype(np.float64) / np.iinfo(kind).max)
    np.testing.assert_allclose(srgb_decode_integers(codes), formula, rtol=1e-5, atol=1e-7)


def test_luminance_of_white_is_one_and_green_weighs_most():
    assert luminance(np.ones(3)) == pytest.approx(1.0)
    red, green, blue = luminance(np.eye(3))
    assert green > red > blue > 0
    np.testing.assert_allclose([red, green, blue], [0.2126, 0.7152, 0.0722], rtol=1e-5)


def test_a_photo_refuses_what_is_no_photo():
    good = np.zeros((4, 5, 3), np.float32)
    Photo(good)
    for bad in (good[..., 0], good.astype(np.float64), good[:, ::-1], np.zeros((0, 5, 3), np.float32)):
        with pytest.raises(ValueError):
            Photo(bad)
    with pytest.raises(ValueError):
        Photo(good, alpha=np.zeros((5, 4), np.float32))


@pytest.mark.parametrize("value", [np.nan, np.inf, -0.1])
def test_a_photo_refuses_values_that_no_photo_has(value):
    values = np.ones((4, 5, 3), np.float32)
    values[2, 3, 1] = value
    with pytest.raises(ValueError, match="finite and not negative"):
        Photo(values)
    with pytest.raises(ValueError, match="alpha is from 0 to 1"):
        Photo(np.ones((4, 5, 3), np.float32), values[..., 1])


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_lies_beyond_a_photo_is_finite(value):
    linear, beyond = np.ones((4, 5, 3), np.float32), np.full((4, 5, 3), -0.1, np.float16)
    Photo(linear, beyond=beyond)
    beyond[2, 3, 1] = value
    with pytest.raises(ValueError, match="beyond is finite"):
        Photo(linear, beyond=beyond)


def test_photo_from_bytes_in_memory():
    srgb = np.array([[[0, 128, 255]]], np.uint8)
    photo = Photo.from_srgb(srgb)
    np.testing.assert_allclose(photo.linear, [[[0.0, 0.21586, 1.0]]], atol=1e-5)
    assert photo.bits == 8
    assert photo.alpha is None


def test_floats_from_memory_that_no_picture_has_count_as_the_nearest():
    srgb = np.array([[[np.nan, -1.0, 2.0], [np.inf, -np.inf, 0.5]]])
    np.testing.assert_allclose(Photo.from_srgb(srgb).linear, [[[0, 0, 1], [1, 0, 0.21404]]], atol=1e-5)


@pytest.mark.parametrize("kind", ["<u2", ">u2", "<f2", ">f4", "f8"])
def test_photo_from_memory_in_any_byte_order(kind):
    white = 65535 if "u" in kind else 1
    srgb = (np.array([[[0, 128 / 255, 1]]]) * white).astype(kind)
    photo = Photo.from_srgb(srgb)
    np.testing.assert_allclose(photo.linear, [[[0.0, 0.21586, 1.0]]], atol=2e-4)
    assert photo.bits == (16 if "u" in kind else 32)


@pytest.mark.parametrize("kind", [np.int32, np.int64, np.uint32, bool, complex])
def test_numbers_whose_white_nobody_knows_are_no_srgb(kind):
    """Numbers up to 255 of another type than a byte came out white."""
    with pytest.raises(ValueError, match="uint8, uint16 or floats"):
        Photo.from_srgb(np.ones((2, 2, 3), kind))


@pytest.mark.parametrize("shape", [(1000,), (10, 100), (10, 20, 5), (1, 1, 1000)])
def test_encoding_is_the_formula_whatever_the_shape_and_the_memory_layout(shape):
    linear = np.geomspace(1e-6, 6e4, 1000).astype(np.float32).reshape(shape)
    exact = linear.astype(np.float64)
    formula = np.where(exact <= 0.0031308, 12.92 * exact, 1.055 * exact ** (1 / 2.4) - 0.055)
    np.testing.assert_allclose(srgb_encode(linear), formula, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(srgb_encode(linear.T), formula.T, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(srgb_encode(linear[::2]), formula[::2], rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize(
    "codes", [np.zeros((0, 3), np.uint8), np.uint8(255), np.full((4, 5, 3), 255, np.uint8)[:, ::2]]
)
def test_codes_of_any_shape_are_decoded(codes):
    decoded = srgb_decode_integers(np.asarray(codes))
    assert decoded.shape == np.shape(codes)
    assert decoded.dtype == np.float32
    assert (decoded == 1).all()


def test_without_colour_luminance_is_left():
    colours = np.random.default_rng(0).random((4, 5, 3)).astype(np.float32)
    grey = without_colour(colours)
    assert grey.shape == colours.shape
    np.testing.assert_allclose(luminance(grey), luminance(colours), rtol=1e-5)
    assert np.ptp(grey, axis=-1).max() == 0


@pytest.mark.parametrize("curve", [srgb_encode, srgb_decode])
def test_a_single_value_and_none_have_their_shape_kept(curve):
    assert curve(np.float32(0.5)).shape == ()
    assert curve(np.zeros((0, 3))).shape == (0, 3)
    assert curve(np.zeros((3, 0, 3), np.uint8)).shape == (3, 0, 3)
