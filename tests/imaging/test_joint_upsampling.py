"""Small maps enlarged along the edges of a picture."""

import numpy as np
import pytest

from relight_core.imaging.joint_upsampling import JointUpsampler
from relight_core.imaging.resampling import resize_area

SKIN = np.ones((32, 32), np.float32)


def shadow_across(width_px, slant=0.6):
    """A shadow at 0.05 beside light at 0.6, linear, whose edge runs aslant and is some pixels wide."""
    down, across = np.mgrid[:256, :256]
    lit = np.clip((across + slant * down - 200) / width_px, 0, 1)
    return np.float32(0.05 + 0.55 * lit**2 * (3 - 2 * lit))[..., None].repeat(3, -1)


def relit_evenly(photo, shadow, skin):
    """The photo (256, 256, 3) as it comes out where the small picture is to be 0.5 all over, on its texture."""
    small = resize_area(photo, (32, 32))
    return (JointUpsampler(small, photo, skin)(0.5 / resize_area(shadow, (32, 32))) * photo)[16:-16, 16:-16, 1]


@pytest.mark.parametrize(("dark", "bright"), [(0.02, 0.9), (0.0005, 0.05)])
def test_enlarged_maps_keep_to_the_side_of_an_edge_that_small_pixels_straddle(dark, bright):
    """The edge lies within a small pixel; bilinear enlargement would blur across it."""
    photo = np.full((64, 64, 3), dark, np.float32)
    photo[:, 34:] = bright
    small = resize_area(photo, (16, 16))
    maps = np.where(np.arange(16)[None, :, None] < 8, 1.0, 5.0).astype(np.float32) * np.ones((16, 1, 1), np.float32)
    large = JointUpsampler(small, photo)(maps)[..., 0]
    assert large[:, :32].max() < 1.2
    assert large[:, 40:].min() > 4.8


def test_a_soft_shadow_that_light_takes_out_leaves_no_line_along_its_edge():
    """A face that is lit evenly again: the gain is one over the photo, whose shadow ends within two small pixels."""
    across = np.clip((np.arange(256) - 120) / 16, 0, 1)
    shade = np.float32(0.05 + 0.55 * across**2 * (3 - 2 * across))
    photo = np.broadcast_to(shade[None, :, None], (256, 256, 3)).copy()
    small = resize_area(photo, (32, 32))
    relit = (JointUpsampler(small, photo)(0.5 / small) * photo)[128, :, 1]
    np.testing.assert_allclose(relit[:112], 0.5, rtol=0.01)
    np.testing.assert_allclose(relit[144:], 0.5, rtol=0.01)
    assert relit.min() > 0.44
    assert relit.max() < 0.7


@pytest.mark.parametrize("width_px", [2, 8, 16, 24])
def test_a_shadow_that_light_takes_out_leaves_no_line_on_skin(width_px):
    """Without a word of skin its edge leaves lines up to twice and down to a quarter of the light around them."""
    photo = shadow_across(width_px)
    relit = relit_evenly(photo, photo, SKIN)
    np.testing.assert_allclose(relit.mean(), 0.5, rtol=0.01)
    assert relit.std() < 0.008
    assert relit_evenly(photo, photo, 0 * SKIN).std() > 0.025


def test_freckles_stay_at_the_edge_of_a_shadow_that_light_takes_out():
    shadow = shadow_across(16, slant=0.0)
    photo = shadow.copy()
    for top in range(40, 220, 30):
        photo[top : top + 3, 207:210] *= 0.6
    relit = relit_evenly(photo, shadow, SKIN)
    speck, beside = relit[24:200:30, 191:194], relit[40:216:30, 191:194]
    assert 0.55 < speck.mean() / beside.mean() < 0.8


@pytest.mark.parametrize("side_px", [16, 32])
def test_a_nostril_that_the_small_picture_fills_stays_dark(side_px):
    photo = np.full((256, 256, 3), 0.4, np.float32)
    photo[120 : 120 + side_px, 96 : 96 + side_px] = 0.03
    small = resize_area(photo, (32, 32))
    with_skin, without = (JointUpsampler(small, photo, skin)(0.4 / small) for skin in (SKIN, None))
    np.testing.assert_allclose(with_skin, without, rtol=1e-5)


def test_a_bar_of_shadow_that_is_wider_than_a_nostril_leaves_no_line():
    photo = np.full((256, 256, 3), 0.6, np.float32)
    photo[:, 98:146] = 0.05
    assert relit_evenly(photo, photo, SKIN).std() < 0.014
    assert relit_evenly(photo, photo, 0 * SKIN).std() > 0.02


def test_a_sharp_shadow_leaves_no_line_on_a_lattice_but_twice_as_fine_and_pores_stay():
    photo = resize_area(shadow_across(2), (64, 64))
    assert relit_evenly(photo, photo, SKIN).std() < 0.012
    porous = photo.copy()
    porous[24:48:6, 24:48:6] *= 0.6
    speck = (relit_evenly(porous, photo, SKIN) / relit_evenly(photo, photo, SKIN))[8:32:6, 8:32:6]
    assert speck.mean() < 0.68


@pytest.mark.parametrize(("bright", "follows"), [(0.25, False), (0.37, True)])
def test_faint_steps_of_skin_are_no_shadows_ends(bright, follows):
    photo = np.full((256, 256, 3), 0.2, np.float32)
    photo[:, 131:] = bright
    small = resize_area(photo, (32, 32))
    with_skin, without = (JointUpsampler(small, photo, skin)(0.5 / small) for skin in (SKIN, None))
    assert (np.abs(with_skin - without).max() > 0.02) == follows


def test_only_where_skin_lies_do_maps_follow_the_luminance_of_a_step():
    photo = shadow_across(8, slant=0.0)
    half = SKIN.copy()
    half[16:] = 0
    small = resize_area(photo, (32, 32))
    everywhere, above, nowhere = (JointUpsampler(small, photo, skin)(0.5 / small) for skin in (SKIN, half, None))
    np.testing.assert_allclose(above[:128], everywhere[:128], rtol=1e-5)
    np.testing.assert_allclose(above[128:], nowhere[128:], rtol=1e-5)
    assert np.abs(everywhere - nowhere).max() > 1
    halfway = JointUpsampler(small, photo, SKIN / 2)(0.5 / small)
    np.testing.assert_allclose(halfway, (everywhere + nowhere) / 2, rtol=1e-4)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_enlarging_keeps_constants_range_and_order(share):
    rng = np.random.default_rng(1)
    photo = rng.random((32, 32, 3), np.float32)
    small = resize_area(photo, (16, 16))
    upsample = JointUpsampler(small, photo, np.full((16, 16), share, np.float32))
    np.testing.assert_allclose(upsample(np.full((16, 16, 2), 3.0, np.float32)), 3.0, rtol=1e-5)
    low = rng.random((16, 16, 1), np.float32)
    high = low + rng.random((16, 16, 1), np.float32)
    assert (upsample(high) >= upsample(low) - 1e-6).all()
    assert upsample(low).min() >= low.min() - 1e-6
    assert upsample(low).max() <= low.max() + 1e-6


def test_each_small_pixel_lands_on_its_own_place():
    photo = np.full((12, 12, 3), 0.5, np.float32)
    maps = np.zeros((4, 4, 1), np.float32)
    maps[1, 2] = 1
    large = JointUpsampler(np.full((4, 4, 3), 0.5, np.float32), photo)(maps)[..., 0]
    down, across = (float((np.arange(12) * large.sum(axis)).sum() / large.sum()) for axis in (1, 0))
    assert (down, across) == pytest.approx((4, 7), abs=1e-4)


def test_sizes_must_be_whole_multiples():
    with pytest.raises(ValueError, match="multiple"):
        JointUpsampler(np.zeros((16, 16, 3), np.float32), np.zeros((40, 40, 3), np.float32))


def test_a_map_ends_at_an_edge_that_is_one_of_colour_alone():
    photo = np.full((32, 32, 3), (0.3, 0.3, 0.3), np.float32)
    photo[:, 16:] = 0.6, 0.2107, 0.3
    small, gain = resize_area(photo, (8, 8)), np.ones((8, 8, 1), np.float32)
    gain[:, 4:] = 3
    np.testing.assert_allclose(JointUpsampler(small, photo)(gain)[16, :, 0], [1.0] * 16 + [3.0] * 16, rtol=0.02)


@pytest.mark.parametrize("beside", [0.0, 40.0, np.nan, np.inf])
def test_an_even_map_stays_even_whatever_the_photo_holds(beside):
    photo = np.full((32, 32, 3), 0.2, np.float32)
    photo[:, 13:] = beside
    upsample = JointUpsampler(photo[2::4, 2::4], photo, np.ones((8, 8), np.float32))
    np.testing.assert_allclose(upsample(np.full((8, 8, 1), 3, np.float32)), 3, rtol=1e-5)


def test_a_slope_of_light_over_a_slope_of_the_photo_has_no_steps():
    across = np.linspace(0.2, 1.0, 128, dtype=np.float32)
    photo = np.broadcast_to((across**2)[None, :, None], (128, 128, 3)).copy()
    small = resize_area(photo, (16, 16))
    gain = np.broadcast_to(np.linspace(1, 5, 16, dtype=np.float32)[None, :, None], (16, 16, 1))
    row = JointUpsampler(small, photo)(gain)[64, 16:-16, 0]
    steps = np.diff(row)
    np.testing.assert_allclose(steps, steps.mean(), rtol=0.2)
