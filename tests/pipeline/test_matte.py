"""The matte of people before a wall, beside the true one."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from drawn_portrait import CROP, make_matte, portrait

from relight_core.face.crop import Crop
from relight_core.imaging.photo import Photo
from relight_core.pipeline.per_photo.exposing import exposure_about_faces
from relight_core.pipeline.per_photo.matte import draft_matte
from relight_core.pipeline.per_photo.mixed_pixels import MixedPixels
from relight_core.pipeline.per_photo.person import canvas_of, whole_person


def refine_matte(linear, mask, crop, alpha=None):
    """The matte of one person at every pixel."""
    matte = make_matte(linear, [[(mask, crop)]], alpha)
    return whole_person(canvas_of(Photo(linear, alpha)), matte).share


def blurred_mask(matte, shift=0.0):
    """The coarse mask of a network: low resolution, soft, a little off."""
    return Crop(CROP.centre_x + shift, CROP.centre_y, CROP.side).extract(matte, 32)


@pytest.mark.parametrize("factor", [1e-5, 1e4])
def test_edges_are_found_in_whatever_units_a_photo_is(factor):
    linear, matte = portrait()
    people, scaled = [[(blurred_mask(matte), CROP)]], linear * np.float32(factor)
    shares = [
        whole_person(canvas_of(Photo(one)), make_matte(one, people, exposure=exposure)).share
        for one, exposure in ((linear, 1.0), (scaled, 1 / factor))
    ]
    np.testing.assert_allclose(*shares, atol=1e-3)


def test_of_two_people_each_is_outlined_at_an_exposure_of_their_own():
    linear, truth = portrait()
    width = linear.shape[1]
    crops = CROP, replace(CROP, centre_x=CROP.centre_x + width)
    people = [[(blurred_mask(truth), crop)] for crop in crops]
    dark = np.concatenate([linear * np.float32(0.02), linear], axis=1)
    exposure = exposure_about_faces((50.0, 1.0), crops, dark.shape[:2])
    share = whole_person(canvas_of(Photo(dark)), make_matte(dark, people, exposure=exposure)).share
    for found in (share[:, :width], share[:, width:]):
        assert np.abs(found - truth).mean() < 0.03
    assert exposure_about_faces((2.0, 2.0), crops, dark.shape[:2]) == 2.0


def test_edges_move_onto_the_photo_and_the_body_beyond_the_crop_is_found():
    linear, truth = portrait()
    matte = refine_matte(linear, blurred_mask(truth, shift=2.0), CROP)
    assert matte.shape == truth.shape
    assert matte.dtype == np.float32
    assert matte.min() >= 0.0
    assert matte.max() <= 1.0
    assert np.abs(matte - truth).mean() < 0.01
    assert matte[230, 60:140].mean() > 0.95
    assert matte[:20].mean() < 0.02


def test_the_photos_own_alpha_wins_unless_it_is_opaque():
    linear, truth = portrait()
    alpha = np.random.default_rng(1).random(truth.shape).astype(np.float32)
    np.testing.assert_array_equal(refine_matte(linear, blurred_mask(truth), CROP, alpha), alpha)
    opaque = refine_matte(linear, blurred_mask(truth), CROP, np.ones_like(alpha))
    assert opaque[5, 5] < 0.1


@pytest.mark.parametrize("value", [0.0, 0.5, 1.0, np.nan])
def test_masks_that_say_nothing_give_a_finite_matte(value):
    linear, _ = portrait()
    matte = refine_matte(linear, np.full((16, 16), value, np.float32), CROP)
    assert np.isfinite(matte).all()
    assert matte.min() >= 0.0
    assert matte.max() <= 1.0


@pytest.mark.parametrize("size", [(1, 1), (3, 90), (24, 24)])
def test_tiny_and_black_photos(size):
    black = np.zeros((*size, 3), np.float32)
    matte = refine_matte(black, np.ones((8, 8), np.float32), Crop(size[1] / 2, size[0] / 2, 4.0))
    assert matte.shape == size
    assert np.isfinite(matte).all()


def test_the_own_colour_of_a_mixed_pixel_is_the_persons():
    person, wall = np.float32([0.5, 0.25, 0.15]), np.float32([0.0, 0.1, 0.9])
    share = np.linspace(0, 1, 11, dtype=np.float32)[None].repeat(3, 0)
    mixed = share[..., None] * person + (1 - share[..., None]) * wall
    sides = (np.broadcast_to(side, mixed.shape) for side in (person, wall))
    own = MixedPixels.of(mixed, share, *sides).own_colour(mixed, share)
    np.testing.assert_allclose(own[:, 1:], np.broadcast_to(person, own[:, 1:].shape), atol=1e-5)
    np.testing.assert_array_equal(own[:, 0], mixed[:, 0])


def test_a_pixel_darker_than_both_sides_leaves_no_pure_colour_to_either():
    share = np.linspace(0.1, 0.9, 9, dtype=np.float32)[None]
    hair, skin, wall = np.float32([[0.03, 0.02, 0.016], [0.3, 0.12, 0.07], [0.3, 0.25, 0.2]])
    pixels, *sides = (np.broadcast_to(one, (1, 9, 3)) for one in (hair, skin, wall))
    own = MixedPixels.of(pixels, share, *sides).own_colour(pixels, share)
    for part in (own, pixels - share[..., None] * own):
        assert (part.min(-1) > 0.1 * part.max(-1)).all()


@pytest.mark.parametrize("hair", [(0.03, 0.02, 0.016), (0.06, 0.02, 0.01), (0.0, 0.0, 0.0)])
def test_a_strand_of_which_the_matte_has_too_little_before_a_bright_sky_is_neither_black_nor_gaudy(hair):
    share = np.linspace(0.1, 0.9, 9, dtype=np.float32)[None]
    mean, sky = np.float32([0.03, 0.02, 0.016]), np.float32([0.6, 0.8, 0.9])
    pixels, *sides = (np.broadcast_to(np.float32(one), (1, 9, 3)) for one in (hair, mean, sky))
    own = MixedPixels.of(pixels, share, *sides).own_colour(pixels, share)
    assert (share[..., None] * own <= pixels + 1e-7).all()
    assert (own >= 0.5 * np.minimum(mean, pixels) - 1e-7).all()
    assert (own < 2.1 * mean).all()


def test_a_hard_matte_keeps_the_photo():
    linear, truth = portrait()
    hard = MixedPixels.of(linear, truth, linear, linear)
    np.testing.assert_array_equal(hard.own_colour(linear, truth), linear)
    np.testing.assert_array_equal(hard.refined(truth, np.ones_like(truth)), truth)


def test_a_large_photo_gets_sharp_edges_from_small_maps():
    linear, truth = portrait()
    large, sharp = (np.repeat(np.repeat(image, 6, 0), 6, 1) for image in (linear, truth))
    crop = Crop(600.0, 510.0, 780.0)
    matte = make_matte(np.ascontiguousarray(large), [[(crop.extract(sharp, 64), crop)]])
    assert max(matte.level.shape) <= 1024
    share = whole_person(canvas_of(Photo(np.ascontiguousarray(large))), matte).share
    assert np.abs(share - sharp).mean() < 0.01


def test_nobody_is_looked_for_who_was_cut_out_already():
    assert draft_matte(Photo(*portrait()), lambda: pytest.fail("looked at")) is None


def test_two_people_are_one_matte():
    linear, truth = portrait()
    both, mask = np.concatenate([linear, linear], 1), blurred_mask(truth)
    second = Crop(CROP.centre_x + 200, CROP.centre_y, CROP.side)
    matte = make_matte(both, [[(mask, CROP)], [(mask, second)]])
    share = whole_person(canvas_of(Photo(both)), matte).share
    assert np.abs(share - np.concatenate([truth, truth], 1)).mean() < 0.02


def test_the_matte_is_the_same_in_whichever_order_the_people_come():
    linear, truth = portrait()
    both = np.concatenate([linear, linear], 1)
    wide, nearer = Crop(200.0, 110.0, 220.0), Crop(250.0, 110.0, 160.0)
    people = [[(crop.extract(np.concatenate([truth, truth], 1), 64), crop)] for crop in (wide, nearer)]
    one, other = (
        whole_person(canvas_of(Photo(both)), make_matte(both, looks)).share for looks in (people, people[::-1])
    )
    np.testing.assert_array_equal(one, other)


def test_a_trunk_that_the_mask_doubts_is_not_half_person():
    linear, truth = portrait()
    trunk = np.zeros_like(truth)
    trunk[40:120, 130:170] = 1 - truth[40:120, 130:170]
    bark = np.random.default_rng(1).normal(1.0, 0.3, (*truth.shape, 1)) * [0.3, 0.2, 0.25]
    linear = np.maximum(np.where(trunk[..., None] > 0, bark, linear), 0).astype(np.float32)
    inside = refine_matte(linear, CROP.extract(truth + 0.6 * trunk, 32), CROP)[50:112, 145:165]
    assert np.mean((inside > 0.15) & (inside < 0.85)) < 0.1


def widened(mask, reach_px):
    return cv2.dilate(mask, np.ones((2 * reach_px + 1,) * 2, np.uint8)) > 0


@pytest.mark.parametrize("before", [700, 0, 1400])
def test_what_is_a_small_persons_colour_and_stands_close_beside_them_is_not_theirs(before):
    """In a copy of all of this wide photo the gap of four pixels is half of one."""
    truth = np.zeros((240, 1600), np.float32)
    truth[:, before : before + 200] = portrait()[1]
    alike = widened(truth, 24) & ~widened(truth, 4)
    alike[115:] = False
    noise = np.random.default_rng(3).normal(1.0, 0.05, (*truth.shape, 1))
    linear = np.where(((truth > 0) | alike)[..., None], (0.5, 0.25, 0.15), (0.05, 0.1, 0.5)) * noise
    linear = np.maximum(linear, 0).astype(np.float32)
    crop = Crop(before + 100.0, 120.0, 236.0)
    share = refine_matte(linear, crop.extract(truth, 256), crop)
    assert share[alike].mean() < 0.25
    assert share[truth > 0].mean() > 0.97
    assert np.abs(share - truth).mean() < 0.005
