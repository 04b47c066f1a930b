"""Shadows that a light takes out of the skin of a photo that is finer than the lattice of gains."""

import numpy as np
import pytest

from relight_core.imaging.joint_upsampling import JointUpsampler
from relight_core.imaging.resampling import resize_area, resize_smooth
from relight_core.imaging.shadow_steps import without_specks

SKIN = np.ones((16, 16), np.float32)


def shadowed(width_px=5):
    """(512, 512, 3) linear, 0.05 in shadow and 0.6 in light, between them an edge aslant."""
    down, across = np.mgrid[:512, :512]
    lit = np.clip((across + 0.6 * down - 400) / width_px, 0, 1)
    return np.float32(0.05 + 0.55 * lit)[..., None].repeat(3, -1)


def on_lattice(photo, relit_small, skin=SKIN):
    """The upsampler (16 to 128) of a photo (512, 512, 3), and the gain that makes it a small picture (16, 16, 3)."""
    small = resize_area(photo, (16, 16))
    upsample = JointUpsampler(small, resize_area(photo, (128, 128)), skin)
    return upsample, upsample(relit_small / small)


def relit(photo, gain, offset):
    return resize_smooth(gain, (512, 512)) * photo + resize_smooth(offset, (512, 512))


def evenly_lit(radiance):
    """A photo with a shadow under a light that takes it out, (448, 448, 3): by the gain alone, and with its steps."""
    photo = shadowed()
    upsample, gain = on_lattice(photo, np.full((16, 16, 3), radiance, np.float32))
    nothing = np.zeros_like(gain)
    changes = (gain, nothing), upsample.steps.taken_out(gain, nothing)
    return [relit(photo, *change)[32:-32, 32:-32] for change in changes]


def test_a_finer_photo_keeps_no_line_of_a_shadow_that_is_taken_out():
    before, after = evenly_lit(0.5)
    assert before.max() > 0.8
    assert after.max() < 0.7
    assert after.min() > 0.4
    assert after.std() < 0.35 * before.std()


def test_nor_does_it_in_a_dim_light():
    before, after = evenly_lit(0.01)
    assert after.std() < 0.35 * before.std()


def test_where_a_step_is_undone_the_light_says_and_no_slider():
    photo = shadowed()
    small = resize_area(photo, (16, 16))
    upsample = JointUpsampler(small, resize_area(photo, (128, 128)), SKIN)
    undoing, even, nothing = 0.5 / small, np.ones((16, 16, 3), np.float32), np.zeros((16, 16, 3), np.float32)
    gain, offset = upsample.change(undoing, nothing, even)
    np.testing.assert_array_equal(gain, upsample(undoing))
    assert not offset.any()
    gain, offset = upsample.change(even, nothing, undoing)
    assert gain.min() < 0.1
    assert offset.max() > 0.3
    np.testing.assert_allclose((gain * resize_area(photo, (128, 128)) + offset)[:20, :20], 0.05, rtol=0.01)


def test_pores_stay_where_a_shadow_ends_so_softly_that_the_lattice_holds_its_edge():
    down, across = np.mgrid[:512, :512]
    pores = np.float32(1 + 0.1 * ((down + across) % 2 * 2 - 1))[..., None]
    shade = 0.05 * 12 ** (1 / (1 + np.exp(-(across + 0.6 * down - 400) / 8)))
    photo = (np.float32(shade)[..., None] * pores).repeat(3, -1)
    upsample, gain = on_lattice(photo, np.full((16, 16, 3), 0.5, np.float32))
    change = gain, np.zeros_like(gain)
    if upsample.steps is not None:
        change = upsample.steps.taken_out(*change)
    even = relit(photo, *change)[32:-32, 32:-32]
    kept = np.abs(np.diff(even, axis=1)) / (even[:, 1:] + even[:, :-1])
    assert kept.min() > 0.06
    assert kept.max() < 0.14


def test_what_is_added_to_the_picture_stays():
    photo = shadowed()
    upsample, gain = on_lattice(photo, np.full((16, 16, 3), 0.5, np.float32))
    without, plus = (upsample.steps.taken_out(gain, np.full_like(gain, added))[1] for added in (0.0, 0.25))
    np.testing.assert_allclose(plus - without, 0.25, atol=1e-6)


@pytest.mark.parametrize("factor", [0.0, 1.0, 3.0])
def test_a_light_that_keeps_the_shadow_keeps_its_edge_as_the_photo_has_it(factor):
    photo = shadowed()
    upsample, gain = on_lattice(photo, factor * resize_area(photo, (16, 16)))
    kept, added = upsample.steps.taken_out(gain, np.zeros_like(gain))
    np.testing.assert_allclose(kept, factor, rtol=1e-5)
    np.testing.assert_allclose(added, 0, atol=1e-6)


def test_change_beyond_a_step_is_left_alone_and_arguments_are():
    photo = shadowed()
    upsample, gain = on_lattice(photo, np.full((16, 16, 3), 0.5, np.float32))
    offset, given = np.zeros_like(gain), gain.copy()
    changed, _ = upsample.steps.taken_out(gain, offset)
    np.testing.assert_array_equal(gain, given)
    assert not offset.any()
    np.testing.assert_array_equal(changed[:20, :20], gain[:20, :20])
    np.testing.assert_array_equal(changed[-20:, -20:], gain[-20:, -20:])


@pytest.mark.parametrize(("relit_in_shadow", "replaced"), [(0.055, False), (0.15, True)])
def test_a_gain_that_hardly_has_a_step_leaves_the_photos_edge(relit_in_shadow, replaced):
    photo = shadowed()
    small = resize_area(photo, (16, 16))
    lit = (small - 0.05) / 0.55
    upsample, gain = on_lattice(photo, relit_in_shadow * (1 - lit) + 0.6 * lit)
    _, added = upsample.steps.taken_out(gain, np.zeros_like(gain))
    assert (added.max() > 0.01) == replaced


def test_a_step_that_ends_amid_the_picture_is_replaced_alike_on_all_sides():
    photo = np.full((512, 512, 3), 0.6, np.float32)
    photo[130:382, 130:382] = 0.05
    upsample, gain = on_lattice(photo, np.full((16, 16, 3), 0.5, np.float32))
    kept, added = upsample.steps.taken_out(gain, np.zeros_like(gain))
    for part in (kept, added):
        np.testing.assert_allclose(part[::-1], part, rtol=1e-3, atol=1e-3)
        np.testing.assert_allclose(part[:, ::-1], part, rtol=1e-3, atol=1e-3)
    assert added.max() > 0.4


def test_where_skin_ends_is_no_step():
    """Hair beside a forehead: the lattice's pixels have some of both in them."""
    photo, skin = np.full((512, 512, 3), 0.5, np.float32), SKIN.copy()
    photo[:200] = 0.03
    skin[:6] = 0
    assert on_lattice(photo, np.ones((16, 16, 3), np.float32), skin)[0].steps is None
    skin[:] = 1
    assert on_lattice(photo, np.ones((16, 16, 3), np.float32), skin)[0].steps is not None


def test_nostrils_and_pores_are_no_steps():
    photo = np.full((512, 512, 3), 0.5, np.float32)
    photo[200:240, 200:260] = 0.02
    photo[40:500:60, 40:500:60] = 0.1
    assert on_lattice(photo, np.ones((16, 16, 3), np.float32))[0].steps is None


def test_there_are_no_steps_off_skin_in_even_light_or_without_enlargement():
    photo, even = shadowed(), np.full((512, 512, 3), 0.4, np.float32)
    assert on_lattice(photo, np.ones((16, 16, 3), np.float32), 0 * SKIN)[0].steps is None
    assert on_lattice(even, np.ones((16, 16, 3), np.float32))[0].steps is None
    small = resize_area(photo, (16, 16))
    assert JointUpsampler(small, small, SKIN).steps is None


@pytest.mark.parametrize("broken", [np.nan, np.inf, -1.0])
def test_broken_pixels_of_a_photo_give_finite_changes(broken):
    photo = shadowed()
    small, large = resize_area(photo, (16, 16)), resize_area(photo, (128, 128))
    large[::7, ::5] = broken
    upsample = JointUpsampler(small, large, SKIN)
    gain = upsample(0.5 / small)
    for part in upsample.steps.taken_out(gain, np.zeros_like(gain)):
        assert np.isfinite(part).all()
        assert part.min() >= 0


@pytest.mark.parametrize(("factor", "gone_px", "stays_px"), [(2, 1, 3), (3, 1, 3), (4, 3, 5), (8, 3, 5)])
def test_specks_are_as_large_as_the_lattice_is_fine(factor, gone_px, stays_px):
    even = np.full((48, 48), 2.0, np.float32)
    for width_px, stays in ((gone_px, False), (stays_px, True)):
        dark = even.copy()
        dark[20 : 20 + width_px, 20 : 20 + width_px] = 9
        assert (without_specks(dark, factor) > 8).any() == stays
