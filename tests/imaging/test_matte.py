import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.imaging.matte import foreground_colour, refine_matte, replace_background


def portrait(height=240, width=200, person_colour=(0.5, 0.25, 0.15), behind=(0.05, 0.1, 0.5)):
    """A head on shoulders before a plain wall, and its true matte."""
    y, x = np.mgrid[0:height, 0:width] + 0.5
    head = np.hypot((x - 100) / 38, (y - 80) / 50) < 1
    body = (y > 120) & (np.abs(x - 100) < 30 + 0.5 * (y - 120))
    matte = (head | body).astype(np.float32)
    noise = np.random.default_rng(0).normal(1.0, 0.05, (height, width, 1))
    linear = np.where(matte[..., None] > 0, person_colour, behind) * noise
    return np.maximum(linear, 0).astype(np.float32), matte


CROP = Crop(100.0, 85.0, 130.0)


def blurred_mask(matte, shift=0.0):
    """The coarse mask of a network: low resolution, soft, a little off."""
    return Crop(CROP.centre_x + shift, CROP.centre_y, CROP.side).extract(matte, 32)


def test_edges_move_onto_the_photo_and_the_body_beyond_the_crop_is_found():
    linear, truth = portrait()
    matte = refine_matte(linear, blurred_mask(truth, shift=2.0), CROP)
    assert matte.shape == truth.shape
    assert matte.dtype == np.float32
    assert matte.min() >= 0.0
    assert matte.max() <= 1.0
    assert np.abs(matte - truth).mean() < 0.005
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


def test_a_new_background_leaves_no_rim_of_the_old():
    person, wall = np.array([0.5, 0.25, 0.15]), np.array([0.0, 0.1, 0.9])
    matte = np.clip((np.arange(80, dtype=np.float32) - 35) / 10, 0, 1)[None].repeat(60, 0)
    mixed = (matte[..., None] * person + (1 - matte[..., None]) * wall).astype(np.float32)
    replaced = replace_background(mixed, matte, np.zeros(3))
    ideal = matte[..., None] * person
    naive = matte[..., None] * mixed
    assert np.abs(replaced - ideal).max() < 0.35 * np.abs(naive - ideal).max()


def test_a_hard_matte_keeps_both_sides_exactly():
    linear, truth = portrait()
    assert foreground_colour(linear, truth) is linear
    background = np.full_like(linear, 2.0)
    replaced = replace_background(linear, truth, background)
    np.testing.assert_array_equal(replaced[truth == 1], linear[truth == 1])
    np.testing.assert_array_equal(replaced[truth == 0], 2.0)
