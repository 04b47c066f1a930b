"""How much of a mixed pixel is person, by its colour."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from drawn_portrait import CROP, make_matte, portrait

from relight_core.imaging.photo import Photo
from relight_core.pipeline.per_photo.mixed_pixels import MixedPixels
from relight_core.pipeline.per_photo.person import canvas_of, whole_person

SHIRT, LAWN = np.float32([0.65, 0.7, 0.85]), np.float32([0.08, 0.1, 0.04])


def refined(pixels, shares, person=SHIRT, behind=LAWN, crisp=1.0):
    """The shares (n,) of a row of pixels (n, 3)."""
    row, share = np.float32(pixels)[None], np.float32(shares)[None]
    sides = (np.broadcast_to(np.float32(side), row.shape) for side in (person, behind))
    return MixedPixels.of(row, share, *sides).refined(share, np.full_like(share, crisp))[0]


def mixed(shares, person=SHIRT, behind=LAWN):
    share = np.float32(shares)[:, None]
    return share * person + (1 - share) * behind


def test_lawn_that_was_taken_for_a_ninth_of_shirt_is_lawn_and_keeps_its_light_where_the_shirt_loses_it():
    pixel, share = LAWN[None], refined([LAWN], [0.11])
    assert share[0] < 0.02
    colour = MixedPixels.of(pixel, share, SHIRT[None], LAWN[None]).own_colour(pixel, share)
    darkened = pixel - 0.9 * share[:, None] * colour
    assert (darkened > 0.8 * LAWN).all()


def test_shares_that_explain_their_pixels_stay():
    truth = np.linspace(0, 1, 11)
    np.testing.assert_allclose(refined(mixed(truth), truth), truth, atol=1e-4)


@pytest.mark.parametrize("off", [-0.1, 0.1])
def test_shares_that_are_somewhat_off_come_nearer_and_not_beyond(off):
    truth = np.linspace(0.2, 0.8, 7)
    left = refined(mixed(truth), truth + off) - truth
    assert (np.abs(left) < 0.03).all()
    assert (left * off > -1e-4).all()


def test_what_is_all_person_or_none_stays_and_what_nearly_is_stays_nearly():
    assert refined(mixed([0.5, 0.5]), [0.0, 1.0]).tolist() == [0, 1]
    # A dark stripe of the shirt, or a flower in the lawn.
    np.testing.assert_allclose(refined([LAWN, SHIRT], [0.98, 0.02]), [0.98, 0.02], atol=0.03)


def test_colours_say_nothing_about_a_wide_outline_nor_between_sides_that_are_alike():
    share = np.linspace(0.1, 0.9, 9)
    pixels = mixed(1 - share)
    np.testing.assert_array_equal(refined(pixels, share, crisp=0.0), np.float32(share))
    nearly = SHIRT * np.float32(0.97)
    np.testing.assert_allclose(refined(mixed(1 - share, behind=nearly), share, behind=nearly), share, atol=0.03)


def test_a_colour_that_neither_side_has_is_not_believed():
    orange = np.float32([0.7, 0.3, 0.05])
    assert abs(refined([orange], [0.4])[0] - 0.4) < 0.12
    green_of_same_sum = np.float32([0.08, 0.9, 0.04])
    assert abs(refined([green_of_same_sum], [0.4])[0] - 0.4) < 0.12


@pytest.mark.parametrize("factor", [0.0, 1e-30, 1e-6, 1e15])
def test_any_exposure_gives_shares_between_none_and_all(factor):
    share = np.linspace(0, 1, 9)
    pixels, person, behind = (np.float32(factor) * one for one in (mixed(share[::-1]), SHIRT, LAWN))
    found = refined(pixels, share, person, behind)
    assert np.isfinite(found).all()
    assert found.min() >= 0
    assert found.max() <= 1
    if factor >= 1e-6:
        np.testing.assert_allclose(found, refined(mixed(share[::-1]), share), atol=1e-3)


@pytest.mark.parametrize("share", [0.8, 0.9, 0.97])
def test_a_rim_of_another_colour_darkens_with_the_ear_it_belongs_to(share):
    skin, rim, lawn = np.float32([[0.5, 0.3, 0.25]]), np.float32([[0.6, 0.6, 0.7]]), LAWN[None]
    alpha = np.float32([share])
    own = MixedPixels.of(rim, alpha, skin, lawn).own_colour(rim, alpha)
    # With none of its light left, the ear leaves the lawn's share of lawn, and hardly any of its own rim.
    left = rim - share * own
    np.testing.assert_allclose(left, (1 - share) * lawn, atol=0.08 * (1 - share) + 0.025)


def test_sides_that_are_off_are_both_changed_until_their_mix_is_the_pixel():
    person, behind, alpha = SHIRT[None], LAWN[None], np.float32([0.5])
    pixel = 0.5 * (person + behind) + np.float32([[0.04, 0.02, 0.03]])
    own = MixedPixels.of(pixel, alpha, person, behind).own_colour(pixel, alpha)
    np.testing.assert_allclose(own - person, [[0.04, 0.02, 0.03]], atol=1e-6)
    np.testing.assert_allclose((pixel - 0.5 * own) / 0.5 - behind, [[0.04, 0.02, 0.03]], atol=1e-6)


def before_a_lawn(blur_px, texture=1.0):
    """Somebody in a striped shirt in front of a lawn, linear, the true matte, and the one that is found."""
    truth, rng = portrait()[1], np.random.default_rng(3)
    soft = cv2.GaussianBlur(truth, (0, 0), blur_px)
    stripes = np.where(np.sin(0.8 * np.arange(len(truth))) > 0, 1 - 0.6 * texture, 1.0)[:, None, None]
    blades = np.exp(0.3 * texture * rng.normal(size=(*truth.shape, 1)))
    linear = soft[..., None] * SHIRT * stripes + (1 - soft[..., None]) * LAWN * blades
    linear = np.ascontiguousarray(linear, np.float32)
    return linear, soft, make_matte(linear, [[(CROP.extract(truth, 32), CROP)]])


def test_less_of_a_lawn_beside_a_shirt_is_taken_for_shirt():
    linear, truth, matte = before_a_lawn(0.6)
    beside = cv2.dilate(np.uint8(truth > 0.5), np.ones((5, 5))) > truth * 2

    def error(matte):
        return np.abs(whole_person(canvas_of(Photo(linear)), matte).share - truth)[:110][beside[:110]].mean()

    by_filters = error(replace(matte, crisp=None))
    assert by_filters > 0.04
    assert error(matte) < 0.7 * by_filters


def test_outlines_in_focus_are_crisp_and_those_out_of_focus_and_all_else_are_not():
    in_focus, out_of_focus = (before_a_lawn(blur_px, texture=0.0)[2].crisp for blur_px in (0.6, 6.0))
    outline = np.s_[60:100, 60:64]
    assert in_focus[outline].mean() > 0.9
    assert out_of_focus[outline].mean() < 0.1
    assert in_focus[80:100, 90:110].max() == in_focus[:20].max() == 0
