"""Haze over a photo: nothing in it is dark, and its darkest places are alike."""

import cv2
import numpy as np
import pytest

from relight_core.imaging.black_level import haze_of
from relight_core.imaging.photo import Photo, with_black

HAZE = np.float32([0.12, 0.15, 0.2])
EVERYWHERE = np.ones((240, 240), bool)


def portrait(pupils=0.004, coat=0.02):
    """A face before a striped wall, in a coat and a scarf."""
    image = np.full((240, 240, 3), (0.5, 0.6, 0.7), np.float32)
    image[:, ::12] = 0.9
    cv2.circle(image, (120, 90), 60, (0.6, 0.4, 0.3), -1)
    image[160:] = coat
    image[160:, 100:140] = (0.7, 0.6, 0.4)
    for x in (98, 142):
        cv2.circle(image, (x, 80), 8, (pupils, pupils, pupils), -1)
    return image


def hazy(haze=HAZE):
    return haze + (1 - haze) * portrait()


@pytest.mark.parametrize("haze", [HAZE, np.float32([0.4, 0.4, 0.4]), np.float32([0.16, 0.13, 0.1])])
def test_nearly_all_of_a_haze_is_found_and_never_more(haze):
    found = haze_of(hazy(haze), EVERYWHERE)
    assert (found > 0.85 * haze).all()
    assert (found <= haze + 0.01).all()


def test_noise_and_compression_leave_it_what_it_is():
    codes = 255 * hazy() ** (1 / 2.2)
    grainy = codes + np.random.default_rng(0).normal(0, 4, codes.shape)
    as_asked = [cv2.IMWRITE_JPEG_QUALITY, 70, cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444]
    jpeg = cv2.imdecode(cv2.imencode(".jpg", codes.round().astype(np.uint8), as_asked)[1], cv2.IMREAD_COLOR)
    for seen in (grainy, jpeg):
        found = haze_of((seen.clip(0, 255) / 255).astype(np.float32) ** np.float32(2.2), EVERYWHERE)
        np.testing.assert_allclose(found, HAZE, rtol=0.2)


@pytest.mark.parametrize("exposure_ev", [-2, 0, 3])
def test_there_is_none_where_something_is_dark(exposure_ev):
    assert not haze_of((portrait() * np.float32(2.0**exposure_ev)).clip(0, 1), EVERYWHERE).any()


def test_there_is_none_where_the_darkest_differ_as_in_a_bright_photo():
    assert haze_of(portrait(pupils=0.2, coat=0.21), EVERYWHERE).min() > 0.15
    assert not haze_of(portrait(pupils=0.1, coat=0.21), EVERYWHERE).any()


def test_a_blurred_photo_has_no_dark_places_either_and_no_haze():
    bright = portrait(pupils=0.2, coat=0.2)
    assert haze_of(bright, EVERYWHERE).min() > 0.15
    assert not haze_of(cv2.GaussianBlur(bright, (0, 0), 8), EVERYWHERE).any()


def test_mere_noise_is_as_bright_everywhere_and_not_hazy():
    noise = np.random.default_rng(0).uniform(0, 1, (240, 240, 3)).astype(np.float32) ** 3
    assert not haze_of(noise, EVERYWHERE).any()


@pytest.mark.parametrize("level", [1e-6, 0.3, 1.0])
def test_one_colour_is_no_haze(level):
    assert not haze_of(np.full((240, 240, 3), level, np.float32), EVERYWHERE).any()
    photo = Photo(np.full((240, 240, 3), level, np.float32))
    assert np.isfinite(photo.above_black.linear).all()


def test_what_is_all_but_white_has_none_that_leaves_nothing_of_it():
    assert haze_of(hazy(np.float32([0.5, 0.5, 0.5])), EVERYWHERE).min() > 0.45
    assert not haze_of(hazy(np.float32([0.9, 0.9, 0.9])), EVERYWHERE).any()


@pytest.mark.parametrize("unit", [1e-3, 64.0])
def test_it_is_a_share_of_the_photos_own_white(unit):
    np.testing.assert_allclose(
        haze_of(hazy() * np.float32(unit), EVERYWHERE, unit), unit * haze_of(hazy(), EVERYWHERE), rtol=1e-3
    )


def test_only_what_counts_has_a_say():
    image = hazy()
    image[:20] = 0
    assert not haze_of(image, EVERYWHERE).any()
    below = EVERYWHERE.copy()
    below[:30] = False
    assert haze_of(image, below).min() > 0.1
    assert haze_of(image, np.zeros_like(below)).tolist() == [0, 0, 0]


@pytest.mark.parametrize("alpha", [None, np.float32(EVERYWHERE)])
def test_above_it_a_photo_is_what_it_was(alpha):
    if alpha is not None:
        alpha[:, :3] = 0
    above = Photo(np.ascontiguousarray(hazy()), alpha).above_black
    assert np.abs(above.linear - portrait()).max() < 0.03
    np.testing.assert_allclose(with_black(above.linear, above.black), hazy(), atol=0.01)
    clear = Photo(portrait(pupils=0.0005))
    assert clear.above_black is clear
