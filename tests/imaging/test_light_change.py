"""Taking a relit view apart into gain and offset, and enlarging both along the photo's edges."""

import numpy as np
import pytest

from relight_core.face.parsing import SURELY
from relight_core.imaging.joint_upsampling import JointUpsampler
from relight_core.imaging.light_change import LightChange
from relight_core.imaging.resampling import resize_area
from relight_core.imaging.view_of_photo import Materials, ViewOfPhoto


def checked_photo(size=64, dark=0.05, bright=0.8):
    """Two halves of different colour with some texture."""
    rng = np.random.default_rng(0)
    photo = np.full((size, size, 3), dark, np.float32)
    photo[:, size // 2 :] = bright
    return photo * rng.uniform(0.9, 1.1, (size, size, 1)).astype(np.float32)


NO_GLOSS = np.zeros((16, 16, 3), np.float32)


def made_of(patterned=0.0, evenly_lit=0.0, textured=0.0, skin=0.0, mouth=0.0, worn=0.0, size=16):
    shares = patterned, evenly_lit, textured, skin, mouth, worn
    return Materials(*(np.full((size, size), share, np.float32) for share in shares))


def fit_light_change(photo, relit, gloss, materials):
    return ViewOfPhoto(photo, materials, SURELY).change_to(relit, gloss)


def test_a_constant_change_is_found_and_keeps_every_texture():
    photo = checked_photo()
    small = resize_area(photo, (16, 16))
    change = fit_light_change(small, small * 2.5, NO_GLOSS, made_of())
    gain = JointUpsampler(small, photo)(change.gain)
    np.testing.assert_allclose(gain * photo, 2.5 * photo, rtol=0.06)


def test_gloss_is_added_and_not_multiplied():
    photo = np.full((16, 16, 3), 0.2, np.float32)
    gloss = np.zeros((16, 16, 3), np.float32)
    gloss[4:8, 4:8] = 0.5
    change = fit_light_change(photo, photo + gloss, gloss, made_of())
    np.testing.assert_allclose(change.gain, 1.0, atol=1e-3)
    np.testing.assert_allclose(change.offset, gloss, atol=1e-3)


def test_a_pupil_that_the_network_blurred_stays_dark_where_contrast_is_colour():
    photo = np.full((16, 16, 3), 0.5, np.float32)
    photo[8, 8] = 0.01
    blurred = np.full((16, 16, 3), 0.5, np.float32)
    blurred[8, 8] = 0.3
    milky = fit_light_change(photo, blurred, NO_GLOSS, made_of()).apply(photo)[8, 8]
    dark = fit_light_change(photo, blurred, NO_GLOSS, made_of(patterned=1)).apply(photo)[8, 8]
    assert milky.min() > 0.1
    assert dark.max() < 0.03


def test_a_shadow_edge_that_the_photo_lacks_survives():
    photo = np.full((16, 16, 3), 0.4, np.float32)
    relit = photo.copy()
    relit[:, 8:] *= 0.1
    result = fit_light_change(photo, relit, NO_GLOSS, made_of(patterned=1)).apply(photo)
    np.testing.assert_allclose(result, relit, atol=0.01)


def test_teeth_that_the_network_lit_one_by_one_get_the_light_around_them():
    photo = np.full((16, 16, 3), 0.6, np.float32)
    relit = 0.5 * photo
    relit[6:9, 6:9] = 0.0
    relit[6:9, 10:12] = 0.6
    spotted = fit_light_change(photo, relit, NO_GLOSS, made_of()).apply(photo)[7, 5:12]
    even = fit_light_change(photo, relit, NO_GLOSS, made_of(evenly_lit=1)).apply(photo)[7, 5:12]
    assert even.min() > spotted.min() + 0.03
    assert np.ptp(even) < 0.7 * np.ptp(spotted)


def test_an_open_mouth_gets_no_gloss_and_own_light_gives_the_photo_back():
    photo = np.full((16, 16, 3), 0.3, np.float32)
    photo[4:12, 4:12] = 0.005
    gloss = np.full((16, 16, 3), 0.004, np.float32)
    change = fit_light_change(photo, photo, gloss, made_of(evenly_lit=1))
    assert change.offset.max() == 0
    assert change.veil.max() == 0
    assert change.shine.min() > 0
    np.testing.assert_allclose(change.apply(photo), photo, atol=1e-3)


def test_pores_break_a_highlight_on_skin_but_not_one_on_what_is_wet():
    photo = np.full((16, 16, 3), 0.3, np.float32)
    gloss = np.full((16, 16, 3), 0.6, np.float32)
    pores = photo * np.where(np.indices((16, 16)).sum(0) % 2, 0.8, 1.2)[..., None].astype(np.float32)

    def contrast(textured):
        shown = fit_light_change(photo, photo + gloss, gloss, made_of(textured=textured)).apply(pores)
        np.testing.assert_allclose(shown.mean(), 0.9, rtol=0.01)
        return (shown.max() - shown.min()) / shown.mean()

    assert contrast(1.0) > 0.3
    assert contrast(0.0) < 0.15


def test_a_gain_at_its_limit_keeps_its_colour():
    photo = np.full((16, 16, 3), 0.01, np.float32)
    relit = photo * np.float32([60, 30, 12])
    gain = fit_light_change(photo, relit, NO_GLOSS, made_of()).gain[8, 8]
    assert gain.max() <= 16
    np.testing.assert_allclose(gain[1:] / gain[0], [0.5, 0.2], rtol=0.1)


IN_SHADOW = (0.02, 0.005, 0.001)


def lit_strongly(photo, **made):
    """Something that hardly shows, and is skin with gloss in the new light; how that comes out, (3,)."""
    photo, relit, gloss = (np.full((16, 16, 3), value, np.float32) for value in (photo, (0.76, 0.38, 0.25), 0.2))
    return fit_light_change(photo, relit, gloss, made_of(**{"textured": 1.0, "skin": 1.0} | made)).apply(photo)[8, 8]


def test_skin_comes_out_of_a_deep_shadow_in_its_own_colour():
    np.testing.assert_allclose(lit_strongly(IN_SHADOW), (0.76, 0.38, 0.25), rtol=0.15)


def test_what_is_black_beside_skin_or_of_a_pattern_gets_no_haze():
    black = np.float32([0.002, 0.002, 0.0025])
    assert (lit_strongly(black) < 0.12).all()
    assert (lit_strongly(IN_SHADOW, patterned=1.0) - 0.2 < 16 * np.float32(IN_SHADOW) + 0.02).all()


def test_a_mouth_comes_out_of_a_deep_shadow_whatever_its_colour_but_an_eye_by_no_more_than_its_gain():
    for dark in (IN_SHADOW, (0.004, 0.004, 0.005)):
        mouth = lit_strongly(dark, skin=0.0, patterned=1.0, evenly_lit=1.0, mouth=1.0)
        np.testing.assert_allclose(mouth, (0.76, 0.38, 0.25), rtol=0.01)
        eye = lit_strongly(dark, skin=0.0, patterned=1.0, evenly_lit=1.0)
        assert (eye < 16 * np.float32(dark) + 0.02).all()


def test_what_is_worn_comes_out_of_a_shadow_in_which_the_photo_shows_it_but_black_gets_no_haze():
    worn = {"skin": 0.0, "patterned": 1.0, "worn": 1.0}
    np.testing.assert_allclose(lit_strongly((0.008, 0.006, 0.004), **worn), (0.76, 0.38, 0.25), rtol=0.15)
    black = np.float32((0.001, 0.001, 0.0008))
    assert (lit_strongly(black, **worn) - 0.2 < 16 * black + 0.02).all()


@pytest.mark.parametrize("grey", np.linspace(0.001, 0.008, 8))
def test_what_is_worn_comes_out_of_its_shadow_little_by_little(grey):
    worn = {"skin": 0.0, "patterned": 1.0, "worn": 1.0}
    one, other = (lit_strongly((grey * more,) * 3, **worn) for more in (1.0, 1.01))
    np.testing.assert_allclose(one, other, atol=0.01)


def test_what_is_not_skin_gets_no_more_than_its_gain():
    assert (lit_strongly(IN_SHADOW, skin=0.0) - 0.2 < 16 * np.float32(IN_SHADOW) + 0.02).all()


PALE, GREY = (0.30, 0.26, 0.24), (0.25, 0.25, 0.25)


def beside_lit_skin(dark, lit, skin_there=1.0):
    """How something dark, in the new light bright skin, comes out beside skin that the photo shows lit, (3,)."""
    photo, relit, skin = np.empty((16, 16, 3), np.float32), np.full((16, 16, 3), 0.5, np.float32), np.ones((16, 16))
    photo[:, :8], photo[:, 8:] = dark, lit
    skin[:, 8:] = skin_there
    made = Materials(np.zeros((16, 16)), np.zeros((16, 16)), np.ones((16, 16)), skin, *np.zeros((2, 16, 16)))
    return fit_light_change(photo, relit, NO_GLOSS, made).apply(photo)[8, 3]


def test_skin_in_a_deep_shadow_need_be_no_warmer_than_most_of_the_face():
    dim = (0.0043, 0.0038, 0.0035)
    np.testing.assert_allclose(beside_lit_skin(dim, PALE), 0.5, rtol=0.01)
    np.testing.assert_allclose(beside_lit_skin((0.004,) * 3, GREY), 0.5, rtol=0.01)
    assert (beside_lit_skin(dim, (0.4, 0.25, 0.12)) < 0.12).all()
    assert (beside_lit_skin(dim, PALE, skin_there=0.0) < 0.12).all()


def test_black_beside_pale_skin_stays_black_and_blue_light_on_a_face_changes_nothing_of_that():
    black = (0.002, 0.002, 0.0025)
    assert (beside_lit_skin(black, PALE) < 0.12).all()
    assert (beside_lit_skin((0.002, 0.002, 0.003), (0.1, 0.2, 0.4)) < 0.12).all()


@pytest.mark.parametrize("red", np.linspace(0.003, 0.02, 12))
def test_skin_comes_out_of_its_shadow_little_by_little(red):
    one, other = (lit_strongly((red * more, 0.003, 0.002)) for more in (1.0, 1.01))
    np.testing.assert_allclose(one, other, rtol=0.06)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -1.0, 1e30])
def test_hostile_values_stay_finite_and_positive(bad):
    photo, relit = np.full((2, 16, 16, 3), 0.3, np.float32)
    relit[3, 3] = bad
    photo[9, 9] = bad
    change = fit_light_change(photo, relit, np.full((16, 16, 3), bad, np.float32), made_of(1, 0.5, 1))
    for part in (change.gain, change.offset, change.shine, change.veil):
        assert np.isfinite(part).all()
        assert part.min() >= 0
    assert change.gain.max() <= 16


def test_light_that_a_weaker_shadow_lets_through_keeps_the_strands_of_dark_hair():
    strands = np.where(np.indices((16, 16)).sum(0) % 2, 0.004, 0.012)[..., None].repeat(3, -1).astype(np.float32)
    change = fit_light_change(strands, 0.5 * strands, NO_GLOSS, made_of(patterned=1, textured=1))
    all_kept, lifted = np.ones_like(strands), np.full_like(strands, 0.004)
    gain, offset = change.moved(all_kept, np.zeros_like(strands), lifted)
    shown, before = (gain * strands + offset)[4:12, 4:12], change.apply(strands)[4:12, 4:12]
    assert shown.mean() == pytest.approx(before.mean() + 0.004, rel=0.15)
    assert shown.max() / shown.min() > 0.9 * before.max() / before.min()


def test_without_detail_all_that_is_added_is_an_offset():
    nothing = np.zeros((4, 4, 3), np.float32)
    change = LightChange(nothing, nothing + 0.3, nothing, nothing + 1)
    gain, offset = change.moved(nothing + 0.5, nothing + 0.1, nothing + 0.2)
    assert gain.max() == 0
    np.testing.assert_allclose(offset, 0.5 * 0.3 + 0.1 + 0.2, rtol=1e-6)


@pytest.mark.parametrize("textured", [0.0, 1.0])
def test_a_deeper_shadow_and_more_gloss_change_the_picture_by_what_they_are(textured):
    photo, gloss = np.full((16, 16, 3), 0.3, np.float32), np.full((16, 16, 3), 0.2, np.float32)
    change = fit_light_change(photo, photo + gloss, gloss, made_of(textured=textured))
    gain, offset = change.moved(np.full_like(photo, 0.5), np.full_like(photo, 0.1), np.zeros_like(photo))
    np.testing.assert_allclose(gain * photo + offset, 0.5 * 0.5 + 0.1, rtol=0.01)


def test_light_that_is_lifted_never_takes_the_gain_beyond_its_limit():
    photo = np.full((16, 16, 3), 0.02, np.float32)
    change = fit_light_change(photo, 4 * photo, NO_GLOSS, made_of())
    gain, _ = change.moved(np.ones_like(photo), np.zeros_like(photo), np.full_like(photo, 1.0))
    np.testing.assert_allclose(gain, 16.0, rtol=1e-5)


def test_what_is_nearly_black_comes_out_as_the_networks_lit_it():
    photo = np.full((16, 16, 3), 0.002, np.float32)
    np.testing.assert_allclose(fit_light_change(photo, 10 * photo, NO_GLOSS, made_of()).apply(photo), 0.02, rtol=0.01)


def test_edges_of_shadows_are_as_even_over_teeth_as_their_light_and_stay_on_skin():
    photo = np.full((16, 16, 3), 0.5, np.float32)
    share = np.float32(np.indices((16, 16)).sum(0) % 2)
    np.testing.assert_allclose(ViewOfPhoto(photo, made_of(), SURELY).evened(share), share, atol=1e-6)
    np.testing.assert_allclose(
        ViewOfPhoto(photo, made_of(evenly_lit=1), SURELY).evened(share)[4:12, 4:12], 0.5, atol=0.02
    )


def test_lifted_light_never_takes_shine_away():
    photo, gloss = np.full((16, 16, 3), 0.05, np.float32), np.full((16, 16, 3), 0.6, np.float32)
    change = fit_light_change(photo, photo + gloss, gloss, made_of(textured=1))
    kept = np.ones_like(photo)
    (without, _), (lifted, _) = (change.moved(kept, gloss, lit) for lit in (0 * photo, np.full_like(photo, 1e-6)))
    np.testing.assert_allclose(lifted, without, rtol=1e-3)


def test_gloss_on_what_is_nearly_black_needs_no_more_gain_than_there_may_be():
    photo, relit = np.full((8, 8, 3), 0.005, np.float32), np.full((8, 8, 3), 0.205, np.float32)
    change = fit_light_change(photo, relit, np.full_like(relit, 0.2), made_of(textured=1.0, size=8))
    np.testing.assert_allclose(change.apply(photo), relit, rtol=0.02)


def nostril(size=64):
    """Skin with a small dark place in it, and where that is."""
    photo = np.full((size, size, 3), (0.5, 0.3, 0.25), np.float32)
    hole = np.zeros((size, size), bool)
    hole[size // 2 : size // 2 + 3, size // 2 : size // 2 + 5] = True
    photo[hole] = (0.08, 0.03, 0.03)
    return photo, hole


def test_a_nostril_stays_dark_where_a_weaker_shadow_gives_light_back_to_skin():
    photo, hole = nostril()
    change = fit_light_change(photo, 0.5 * photo, np.zeros_like(photo), made_of(textured=1, size=64))
    lifted = np.full_like(photo, 0.3)
    gain, offset = change.moved(np.ones_like(photo), np.zeros_like(photo), lifted)
    shown = gain * photo + offset
    np.testing.assert_allclose(shown[~hole], (0.5 * photo + lifted)[~hole], rtol=0.02)
    assert shown[hole].max() < 0.2 * shown[~hole].max()


def test_light_that_a_weaker_shadow_gives_back_to_a_mouth_leaves_the_dark_between_lips_dark():
    photo = np.full((32, 32, 3), (0.4, 0.2, 0.15), np.float32)
    photo[15:17] = (0.02, 0.004, 0.004)
    change = fit_light_change(photo, 0.5 * photo, np.zeros_like(photo), made_of(patterned=1, evenly_lit=1, size=32))
    lifted = np.full_like(photo, (0.4, 0.2, 0.15))
    gain, offset = change.moved(np.ones_like(photo), np.zeros_like(photo), lifted)
    shown = gain * photo + offset
    np.testing.assert_allclose(shown[4], (1.5 * photo)[4], rtol=0.03)
    assert shown[15:17].max() < 0.12


def test_light_that_is_given_back_keeps_its_colour_where_the_gain_has_little_room():
    view = np.full((4, 4, 3), 15.5, np.float32)
    nothing = np.zeros_like(view)
    change = LightChange(view, nothing, nothing, nothing, lambda lifted: 10 * lifted)
    gain, _ = change.moved(np.ones_like(view), nothing, np.full_like(view, (0.4, 0.2, 0.1)))
    np.testing.assert_allclose(gain, np.full_like(view, (16.0, 15.75, 15.625)), rtol=1e-5)


def test_of_more_gloss_than_there_is_light_no_more_is_added():
    photo, gloss = np.full((16, 16, 3), 0.3, np.float32), np.full((16, 16, 3), 0.5, np.float32)
    relit = np.full((16, 16, 3), 0.2, np.float32)
    np.testing.assert_allclose(fit_light_change(photo, relit, gloss, made_of()).apply(photo), relit, atol=2e-3)


@pytest.mark.parametrize("level", [0.06, 0.1, 0.6])
def test_four_fifths_of_a_highlight_follow_the_texture_of_skin_that_is_not_dark(level):
    photo, gloss = np.full((16, 16, 3), level, np.float32), np.full((16, 16, 3), 0.05, np.float32)
    change = fit_light_change(photo, photo + gloss, gloss, made_of(textured=1, skin=1))
    np.testing.assert_allclose(change.offset, 0.2 * gloss, rtol=0.05)
    np.testing.assert_allclose(change.gain, 1 + 0.8 * gloss / photo, rtol=0.01)


@pytest.mark.parametrize(("side_px", "share", "is_hole"), [(3, 0.1, True), (3, 0.6, False), (9, 0.1, False)])
def test_only_what_is_small_and_far_darker_than_all_around_it_is_a_hole(side_px, share, is_hole):
    photo = np.full((64, 64, 3), 0.5, np.float32)
    start = 32 - side_px // 2
    photo[start : start + side_px, start : start + side_px] = 0.5 * share
    change = fit_light_change(photo, photo, np.zeros_like(photo), made_of(textured=1, skin=1, size=64))
    lifted = np.full_like(photo, 0.1)
    brightened_by = 0.5 if is_hole else 0.5 * share
    np.testing.assert_allclose(change.lift(lifted)[32, 32], 0.1 / brightened_by, rtol=0.03)


def test_light_given_back_to_teeth_is_as_even_as_that_around_them_and_next_to_none_where_all_is_black():
    lifted = np.full((16, 16, 3), 0.02, np.float32)
    lifted[::2, ::2] = 0.1
    for level, most in ((0.4, 0.12), (0.002, 1.0)):
        photo = np.full((16, 16, 3), level, np.float32)
        more = fit_light_change(photo, photo, NO_GLOSS, made_of(evenly_lit=1, mouth=1)).lift(lifted)[4:-4, 4:-4]
        assert np.ptp(more) < 0.1 * more.mean()
        assert 0.5 * most < more.mean() < most
