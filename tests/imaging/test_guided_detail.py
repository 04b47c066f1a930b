"""A change at low resolution, carried to a photo with all its detail."""

import numpy as np
import pytest
import skimage.data

from relight_core.imaging.guided_detail import apply_detail, carry_detail, fit_detail
from relight_core.imaging.photo import Photo
from relight_core.imaging.resampling import resize_area
from relight_core.imaging.view_transform import apply_view


@pytest.fixture(scope="module")
def portrait():
    """(260, 260, 3) linear: a face with hair, eyes and a hard collar."""
    return np.ascontiguousarray(Photo.from_srgb(skimage.data.astronaut()[:260, 90:350]).linear)


def codes_apart(a, b):
    return np.abs(apply_view(a) - apply_view(b)).max() * 255


def test_the_same_light_gives_the_photo_back(portrait):
    small = resize_area(portrait, (64, 64))
    assert codes_apart(carry_detail(portrait, small, small), portrait) < 1.0


@pytest.mark.parametrize("gain", [0.1, 0.5, 2.0])
def test_a_brighter_light_brightens_texture_and_all(portrait, gain):
    small = resize_area(portrait, (64, 64))
    carried = carry_detail(portrait, small, small * gain)
    assert codes_apart(carried, portrait * gain) < 2.0


def test_a_shadow_that_the_photo_lacks_arrives(portrait):
    edge = 1.0 / (1.0 + np.exp(-(np.arange(260) - 130) / 6.0))
    lit = portrait * (0.1 + 0.9 * edge).astype(np.float32)[None, :, None]
    carried = carry_detail(portrait, resize_area(portrait, (64, 64)), resize_area(lit, (64, 64)))
    error = np.abs(apply_view(carried) - apply_view(lit))
    blocks = np.repeat(np.repeat(resize_area(lit, (65, 65)), 4, 0), 4, 1)
    enlarged = np.abs(apply_view(blocks) - apply_view(lit))
    assert error.mean() * 255 < 2.0
    assert error.mean() < 0.25 * enlarged.mean()


def test_no_halo_at_a_hard_edge():
    photo = np.full((256, 256, 3), 0.05, np.float32)
    photo[:, 133:] = 0.9
    relit = photo.copy()
    relit[:, 133:] *= 0.3
    relit[:, :133] *= 2.0
    carried = carry_detail(photo, resize_area(photo, (64, 64)), resize_area(relit, (64, 64)))
    assert carried.max() < 0.27 + 0.02
    assert carried.min() > 0.1 - 0.02
    assert np.abs(carried[:, :110] - 0.1).max() < 0.005
    assert np.abs(carried[:, 160:] - 0.27).max() < 0.005


def test_a_black_photo_does_not_explode():
    noise = np.random.default_rng(0).random((128, 128, 3)).astype(np.float32) * 1e-4
    relit = np.full((32, 32, 3), 0.5, np.float32)
    carried = carry_detail(noise, resize_area(noise, (32, 32)), relit)
    np.testing.assert_allclose(carried, 0.5, atol=0.01)


def test_highlights_above_one_survive(portrait):
    small = resize_area(portrait, (64, 64))
    highlight = np.zeros((64, 64, 1), np.float32)
    highlight[20:40, 20:40] = 5.0
    carried = carry_detail(portrait, small, small + highlight)
    inside = carried[100:140, 100:140]
    assert inside.mean() == pytest.approx(5.0 + portrait[100:140, 100:140].mean(), rel=0.1)
    assert inside.min() > 3.0


def test_hostile_numbers():
    photo = np.full((40, 40, 3), 0.5, np.float32)
    photo[3, 3], photo[20, 20], photo[30, 30] = np.nan, np.inf, -5.0
    relit = np.full((16, 16, 3), 1.0, np.float32)
    relit[2, 2], relit[9, 9], relit[5, 5] = np.nan, np.inf, -1e30
    carried = carry_detail(photo, photo[:16, :16], relit)
    assert np.isfinite(carried).all()
    assert carried.min() >= 0.0
    for size in (1, 2, 7):
        one = np.ones((size, size, 3), np.float32)
        np.testing.assert_allclose(carry_detail(one, one, one), 1.0, atol=1e-5)


def test_one_fit_serves_every_resolution(portrait):
    fit = fit_detail(resize_area(portrait, (64, 64)), 2.0 * resize_area(portrait, (64, 64)))
    for size in (40, 64, 150, 260):
        crop = resize_area(portrait, (size, size))
        assert codes_apart(apply_detail(fit, crop), 2.0 * crop) < 3.0
