"""Photos of lit heads: whatever the radiance, a picture in range."""

import cv2
import numpy as np
import pytest
from synthetic_heads import ball

from relight_core.dataset.camera import camera_gain, metered_gain, photograph
from relight_core.dataset.painting.texture import fractal_noise, look_up


def covered():
    return ball(32).covered


HOSTILE = {
    "black": 0.0,
    "dim": 1e-12,
    "ordinary": 0.3,
    "sun": 6e4,
    "beyond half floats": 1e30,
}


@pytest.mark.parametrize("name", HOSTILE)
@pytest.mark.parametrize("seed", range(8))
def test_photo_is_finite_and_in_range(pool, name, seed):
    rng = np.random.default_rng(seed)
    radiance = (np.float32(HOSTILE[name]) * rng.random((32, 32, 3), np.float32)) * covered()[..., None]
    light = rng.random((16, 32, 3)).astype(np.float32) * (seed % 3)
    photo = photograph(radiance, covered(), light, float(radiance.mean()), pool, rng)
    assert photo.shape == (32, 32, 3)
    assert photo.dtype == np.float32
    assert np.isfinite(photo).all()
    assert ((photo >= 0) & (photo <= 1)).all()


def test_an_empty_frame_is_only_background(pool):
    nothing = np.zeros((32, 32), bool)
    photo = photograph(
        np.zeros((32, 32, 3), np.float32),
        nothing,
        np.ones((16, 32, 3), np.float32),
        0.5,
        pool,
        np.random.default_rng(1),
    )
    assert np.isfinite(photo).all()
    assert photo.std() > 0.01


def test_same_seed_same_photo_and_radiance_untouched(pool):
    radiance = np.full((32, 32, 3), 0.4, np.float32)
    photos = [
        photograph(radiance, covered(), np.ones((16, 32, 3), np.float32), 0.5, pool, np.random.default_rng(5))
        for _ in range(2)
    ]
    np.testing.assert_array_equal(*photos)
    assert (radiance == np.float32(0.4)).all()


def test_a_brighter_left_half_stays_the_brighter_one(pool):
    radiance = np.full((32, 32, 3), 0.1, np.float32)
    radiance[:, :16] = 0.4
    left, right = covered().copy(), covered().copy()
    left[:, 14:], right[:, :18] = False, False
    for seed in range(10):
        light = np.ones((16, 32, 3), np.float32)
        photo = photograph(radiance, covered(), light, 0.5, pool, np.random.default_rng(seed))
        assert photo[left].mean() > photo[right].mean()


def test_noise_has_no_mean_and_unit_deviation_and_tiles():
    noise = fractal_noise(np.random.default_rng(2), 64, 1.2)
    assert abs(noise.mean()) < 1e-4
    assert noise.std() == pytest.approx(1, abs=1e-3)
    across_the_seam = np.abs(noise[:, 0] - noise[:, -1]).mean()
    assert across_the_seam < 2 * np.abs(np.diff(noise, axis=1)).mean()


def test_look_up_reads_texels_with_v_upward_and_wraps():
    texture = np.arange(16, dtype=np.float32).reshape(4, 4)
    uv = np.array([[0.125, 0.875], [0.625, 0.375], [1.125, -0.125]], np.float32)
    np.testing.assert_allclose(look_up(texture, uv), [0, 10, 0], atol=1e-4)
    assert look_up(texture, np.empty((0, 2), np.float32)).shape == (0,)
    assert look_up(np.zeros((4, 4, 3), np.float32), np.zeros((5000, 2), np.float32)).shape == (5000, 3)


def test_meter_by_hand():
    """Grey 0.07 asks for a gain of 4, white at 0.2 too; at 0.1 it asks for 8."""
    grey = np.full((32, 32, 3), 0.07, np.float32) * covered()[..., None]
    for share in (0.0, 0.3, 1.0):
        assert metered_gain(grey, covered(), 0.2, share) == pytest.approx(4.0, rel=1e-4)
        assert metered_gain(grey * 3, covered(), 0.6, share) == pytest.approx(4.0 / 3, rel=1e-4)
        assert np.isfinite(metered_gain(grey * 0, covered(), 0.0, share))
    assert metered_gain(grey, covered(), 0.1, 0.0) == pytest.approx(8.0, rel=1e-4)
    assert metered_gain(grey, covered(), 0.1, 0.5) == pytest.approx(4.0 * 2**0.5, rel=1e-4)
    assert np.isfinite(metered_gain(grey, np.zeros((32, 32), bool), 0.2, 0.45))


def test_a_meter_looks_as_much_at_the_brighter_parts_as_at_the_mean():
    """Three in ten pixels are at 0.35 and the rest at 0.05: a mean of 0.14, and 0.35 four fifths of the way up."""
    two_tone = np.full((10, 10, 3), 0.05, np.float32)
    two_tone[:3] = 0.35
    gain = metered_gain(two_tone, np.ones((10, 10), bool), 1.0, 1.0)
    assert gain == pytest.approx(0.28 / (0.5 * 0.14 + 0.5 * 0.35), rel=1e-4)


def test_dark_skin_is_shown_darker_than_pale_skin():
    pale = np.full((32, 32, 3), 0.5, np.float32) * covered()[..., None]
    shown = [(skin * metered_gain(skin, covered(), 1.0, 0.45))[covered()].mean() for skin in (pale * 0.1, pale)]
    assert shown[0] < 0.5 * shown[1]


def test_a_camera_takes_the_colour_of_a_light_from_all_of_the_sphere():
    """Rows at the poles are as many texels as those at the horizon, and next to nothing of the sphere."""
    plain, poles = np.ones((16, 32, 3), np.float32), np.ones((16, 32, 3), np.float32)
    poles[[0, -1]] = [1.0, 1.0, 9.0]
    radiance = np.full((32, 32, 3), 0.2, np.float32) * covered()[..., None]
    gains = [camera_gain(radiance, covered(), each, 1.0, np.random.default_rng(4)) for each in (plain, poles)]
    np.testing.assert_allclose(gains[0], gains[1], rtol=0.12)


def inner(mask):
    """Far enough inside that no lens blurs anything else into it."""
    return cv2.erode(mask.astype(np.uint8), np.ones((11, 11), np.uint8)) > 0


@pytest.mark.parametrize("colour", range(3))
def test_a_red_head_is_red_in_every_photo_and_a_black_one_black_before_any_background(colour, pool):
    red, white = np.zeros((32, 32, 3), np.float32), np.ones((16, 32, 3), np.float32)
    red[covered()] = 0.4 * np.eye(3)[colour]
    for seed in range(12):
        photos = [photograph(one, covered(), white, 0.5, pool, np.random.default_rng(seed)) for one in (red, 0 * red)]
        shown, black = (photo[inner(covered())].mean(0) for photo in photos)
        assert shown.argmax() == colour
        assert shown[colour] > black.max() + 0.1
        assert black.max() < 0.25


def test_a_brighter_head_in_the_same_light_is_brighter_in_the_photo(pool):
    """Metering evens out less than all of it."""
    head = np.full((32, 32, 3), 0.05, np.float32) * covered()[..., None]
    for seed in range(12):
        rng = (np.random.default_rng(seed) for _ in range(2))
        dark, light = (photograph(head * k, covered(), np.ones((16, 32, 3)), 0.5, pool, next(rng)) for k in (1, 6))
        assert light[inner(covered())].mean() > dark[inner(covered())].mean() + 0.02


def test_a_dimmer_head_in_as_much_dimmer_a_light_is_exposed_for_longer(pool):
    head, white = np.full((32, 32, 3), 0.2, np.float32) * covered()[..., None], np.ones((16, 32, 3), np.float32)
    for seed in range(12):
        bright, dim = (
            photograph(head / k, covered(), white / k, 0.5 / k, pool, np.random.default_rng(seed)) for k in (1, 8)
        )
        assert np.abs(bright - dim).mean() < 0.01


def test_what_stands_before_the_camera_shows_nothing_of_the_head_behind_it(pool):
    hidden, white = np.zeros((32, 32), bool), np.ones((16, 32, 3), np.float32)
    hidden[:, 10:] = True
    for seed in range(12):
        photos = []
        for colour in range(2):
            head = 0.4 * np.eye(3, dtype=np.float32)[colour] * covered()[..., None]
            photos.append(photograph(head, covered(), white, 0.5, pool, np.random.default_rng(seed), hidden=hidden))
        off = np.abs(photos[0] - photos[1]).max(-1)
        # JPEG's blocks are 16 pixels wide where colours are halved.
        assert off[:, 18:].mean() < 0.02
        assert off[8:24, 5:8].mean() > 0.1


def test_cameras_neutralise_some_of_a_light_s_colour_and_seldom_add_to_it():
    blue = np.full((16, 32, 3), (0.5, 1.0, 2.0), np.float32)
    head = np.full((32, 32, 3), 0.2, np.float32) * covered()[..., None]
    gains = [camera_gain(head, covered(), blue, 1.0, np.random.default_rng(seed)) for seed in range(40)]
    ratios = np.array([gain[0] / gain[2] for gain in gains])
    assert 1.5 < np.median(ratios) < 3
    assert ratios.min() > 0.8
    assert ratios.max() < 5
