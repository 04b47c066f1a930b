"""What lies over all of a photo: lifted and coloured blacks."""

import numpy as np
import pytest

from relight_core.imaging.black_level import Black, black_level_of
from relight_core.imaging.photo import Photo, with_black, without_black

BLACK = np.float32([0.010, 0.012, 0.025])


def portrait(lifted=0.0):
    """Brightness as in photos: from black folds and pupils, a few in a thousand, to white."""
    rng = np.random.default_rng(0)
    linear = rng.uniform(0, 1, (160, 200, 1)) ** 3 * rng.uniform(0.7, 1, (160, 200, 3))
    return (lifted + (1 - lifted) * linear).astype(np.float32)


def test_nothing_lies_over_a_photo_with_blacks():
    assert black_level_of(portrait().reshape(-1, 3)).tolist() == [0, 0, 0]
    photo = Photo(portrait())
    assert photo.above_black is photo
    assert photo.black is None


def test_lifted_and_coloured_blacks_are_found_for_the_most_part_and_never_more():
    found = Photo(portrait(BLACK)).above_black.black.level
    assert (found > 0.6 * BLACK).all()
    assert (found <= BLACK * 1.001).all()


def test_one_channel_may_be_lifted_alone():
    found = black_level_of(portrait(np.float32([0, 0, 0.03])).reshape(-1, 3))
    assert found[:2].tolist() == [0, 0]
    assert found[2] > 0.018


@pytest.mark.parametrize("dimmest", [0.1, 0.3])
def test_a_photo_without_anything_dark_has_nothing_to_tell_by(dimmest):
    assert not black_level_of(portrait(dimmest).reshape(-1, 3)).any()


@pytest.mark.parametrize(("dimmest", "brightest"), [(0.11, 0.23), (0.08, 0.3), (0.3, 0.6)])
def test_a_flat_photo_has_nearly_all_of_its_darkest_over_it(dimmest, brightest):
    linear = dimmest + (brightest - dimmest) * portrait()
    found = black_level_of(linear.reshape(-1, 3))
    assert (found > 0.9 * dimmest).all()
    assert (found <= 1.001 * dimmest).all()
    linear[:3, :10] = 1
    assert (black_level_of(linear.reshape(-1, 3)) > 0.9 * dimmest).all(), "but for a few glints"


def test_a_dim_photo_is_not_flat_that_has_eight_times_its_darkest():
    assert not black_level_of((0.1 + 0.75 * portrait()).reshape(-1, 3)).any()


def test_grey_cloth_is_no_black_where_pupils_are_darker():
    linear = np.full((160, 200, 3), 0.4, np.float32)
    linear[80:] = 0.02
    assert black_level_of(linear.reshape(-1, 3)).max() > 0.01
    linear[20:25, 30:35] = 0.003
    assert not black_level_of(linear.reshape(-1, 3)).any()


def test_a_photo_in_units_of_its_own_has_it_in_those():
    one, other = (Photo(portrait(BLACK) * np.float32(unit), bits=32).above_black.black.level for unit in (1, 4096))
    assert one.min() > 0.004
    np.testing.assert_allclose(other, 4096 * one, rtol=1e-5)


@pytest.mark.parametrize("unit", [16, 40, 100, 4096])
def test_a_photo_in_units_of_its_own_keeps_its_white_and_all_else_too(unit):
    """What lies over it may be above 1: photos came out in false colours, or black."""
    one, other = (Photo(portrait(BLACK) * np.float32(times), bits=32).above_black for times in (1, unit))
    np.testing.assert_allclose(other.linear / unit, one.linear, atol=0.005)


def test_as_much_as_can_be_of_what_lies_far_beyond_a_photo_stays_there():
    far = np.full((160, 200, 3), -65504, np.float16)
    assert Photo(portrait(BLACK), bits=32, beyond=far).above_black.beyond.min() == -65504


@pytest.mark.parametrize("linear", [np.zeros((4, 4, 3), np.float32), np.full((1, 1, 3), 0.02, np.float32)])
def test_photos_of_nothing_and_of_one_pixel_are_as_they_are(linear):
    above = Photo(linear).above_black.linear
    assert np.isfinite(above).all()
    assert above.min() >= 0


def test_a_dim_picture_of_a_few_codes_has_none_that_tells_and_one_of_floats_has():
    dim = np.float32(0.02) * portrait(BLACK)
    assert Photo(dim).above_black.black is None
    assert Photo(dim, bits=32).above_black.black.level.max() > 0.0003


@pytest.mark.parametrize("left", [0.0, 0.4])
def test_what_an_alpha_hides_for_the_most_part_has_no_say(left):
    linear, alpha = portrait(BLACK), np.ones((160, 200), np.float32)
    linear[60:90, 60:90], alpha[60:90, 60:90] = 0, left
    assert (Photo(linear, alpha).above_black.black.level > 0.6 * BLACK).all()
    assert Photo(linear).above_black.black is None


def test_bars_around_a_picture_have_no_say():
    framed = np.zeros((200, 200, 3), np.float32)
    framed[20:180] = portrait(BLACK)
    assert (Photo(framed).above_black.black.level > 0.5 * BLACK).all()


def test_without_it_a_photo_has_blacks_and_keeps_its_white_and_all_else():
    lifted = Photo(portrait(BLACK), bits=16, icc=b"profile", beyond=np.full((160, 200, 3), 0.5, np.float16))
    above = lifted.above_black
    assert lifted.above_black is above
    assert (above.bits, above.icc) == (16, b"profile")
    assert np.percentile(above.linear, 0.1) < 0.005
    level = above.black.level
    np.testing.assert_allclose(above.linear, (lifted.linear - level) / (1 - level), atol=1e-6)
    np.testing.assert_allclose(above.beyond, 0.5 / (1 - level) * np.ones((160, 200, 1)), rtol=2e-3)


def test_taken_away_and_laid_over_again_it_changes_nothing():
    linear = portrait()
    for black in (Black(BLACK), Black(BLACK, 3.0)):
        np.testing.assert_allclose(with_black(without_black(linear, black), black), linear, atol=2e-7)
        assert without_black(linear, black).min() < 0
    assert with_black(linear, None) is linear
    assert without_black(linear, None) is linear


@pytest.mark.parametrize("unit", [1e-3, 1.0, 4096.0])
@pytest.mark.parametrize("linear", [portrait(BLACK), 0.08 + 0.22 * portrait()])
def test_what_is_found_is_of_the_photos_own_white(linear, unit):
    linear = linear.reshape(-1, 3).astype(np.float32)
    expected = black_level_of(linear)
    assert expected.max() > 0.01
    np.testing.assert_allclose(black_level_of(linear * np.float32(unit), unit), unit * expected, rtol=1e-4)


def test_a_few_hundredths_of_dark_pixels_tell_enough():
    linear = np.full((100, 100, 3), 0.5, np.float32)
    linear[:3] = 0.02
    np.testing.assert_allclose(black_level_of(linear.reshape(-1, 3)), 0.02, rtol=1e-3)


def test_a_darkest_hundredth_that_spreads_as_in_overexposed_photos_has_nothing_over_it():
    share = np.linspace(0, 1, 100_000)
    linear = np.minimum(0.02 * 2.3 ** (share / 0.01), 1.0)[:, None].repeat(3, -1).astype(np.float32)
    assert not black_level_of(linear).any()
    assert black_level_of(np.maximum(linear, 0.04)).min() > 0.03


@pytest.mark.parametrize("lifted", [(0.006, 0.006, 0.006), (0.002, 0.002, 0.03)])
def test_little_counts_and_counts_beside_much(lifted):
    found = black_level_of(portrait(np.float32(lifted)).reshape(-1, 3))
    assert (found > 0.6 * np.float32(lifted)).all()


def test_of_a_flat_photo_of_one_colour_each_channel_has_its_own():
    dimmest = np.float32([0.11, 0.11, 0.05])
    found = black_level_of((dimmest + 0.1 * portrait()).reshape(-1, 3))
    np.testing.assert_allclose(found, dimmest, rtol=0.1)


def test_a_flat_photo_that_lacks_a_colour_and_one_without_pixels():
    red = (np.float32([0.1, 0, 0]) + np.float32([0.1, 0, 0]) * portrait()).reshape(-1, 3)
    assert np.isfinite(black_level_of(red)).all()
    assert black_level_of(red)[1:].max() == 0
    assert black_level_of(np.zeros((0, 3), np.float32)).tolist() == [0, 0, 0]
