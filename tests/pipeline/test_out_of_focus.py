"""Outlines that are out of focus in the photo, and so in its matte."""

import cv2
import numpy as np
import pytest

from relight_core.pipeline.per_photo import out_of_focus
from relight_core.pipeline.per_photo.matte import DraftMatte, finish_matte
from relight_core.pipeline.per_photo.person import Canvas, whole_person

SIZE = 240
DARK, BRIGHT = 0.2, 0.8
ACROSS = np.s_[SIZE // 2]


def left_part(end_px=SIZE / 2):
    return (np.mgrid[:SIZE, :SIZE][1] + 0.5 < end_px).astype(np.float32)


def blurred(image, blur_px):
    return cv2.GaussianBlur(image, (0, 0), blur_px) if blur_px else image


def drawn(share, dark=DARK, bright=BRIGHT):
    """Brightness of somebody before a wall as it is displayed; the lens blurs light, not what is displayed."""
    return np.sqrt(share * dark**2 + (1 - share) * bright**2)


def softened(share, guide):
    return out_of_focus.softened(share, guide)[0]


def softness_px(share):
    """The standard deviation of the blur that a matte ends by to the right, from its slope."""
    slope = np.maximum(-np.diff(share[ACROSS].astype(np.float64)), 0)
    place = np.arange(slope.size)
    middle = (slope * place).sum() / slope.sum()
    return np.sqrt((slope * (place - middle) ** 2).sum() / slope.sum())


@pytest.mark.parametrize("blur_px", [3.0, 4.0, 6.0])
@pytest.mark.parametrize(("dark", "bright"), [(DARK, BRIGHT), (BRIGHT, DARK), (0.1, 0.25), (0.05, 1.0)])
def test_an_outline_out_of_focus_ends_as_softly_as_the_lens_drew_it(blur_px, dark, bright):
    matte = softened(blurred(left_part(), 1.0), drawn(blurred(left_part(), blur_px), dark, bright))
    assert softness_px(matte) == pytest.approx(blur_px, rel=0.25)
    np.testing.assert_allclose(matte[ACROSS], blurred(left_part(), blur_px)[ACROSS], atol=0.08)


def test_softer_outlines_get_softer_mattes():
    mattes = [softened(left_part(), drawn(blurred(left_part(), blur_px))) for blur_px in (2.0, 3.0, 5.0, 8.0)]
    assert (np.diff([softness_px(matte) for matte in mattes]) > 0.7).all()


@pytest.mark.parametrize("blur_px", [0.0, 0.7, 1.2])
def test_an_outline_in_focus_stays_as_it_is(blur_px):
    share = blurred(left_part(), 0.8)
    np.testing.assert_array_equal(softened(share, drawn(blurred(left_part(), blur_px))), share)


def test_an_outline_that_is_soft_already_stays_so():
    share = blurred(left_part(), 4.0)
    np.testing.assert_allclose(softened(share, drawn(share)), share, atol=0.02)


def test_where_the_matte_misses_the_edge_by_two_pixels_a_sharp_one_stays():
    share = blurred(left_part(SIZE / 2 + 2), 1.0)
    np.testing.assert_array_equal(softened(share, drawn(blurred(left_part(), 1.0))), share)


def test_an_outline_without_contrast_stays_as_it_is():
    share = left_part()
    np.testing.assert_array_equal(softened(share, drawn(blurred(share, 5.0), 0.5, 0.51)), share)


def test_noise_of_an_even_wall_softens_nothing():
    share = left_part()
    noise = np.random.default_rng(0).normal(0.5, 0.012, share.shape).astype(np.float32)
    np.testing.assert_array_equal(softened(share, noise), share)


def test_noise_on_a_soft_outline_hardly_matters():
    noise = np.random.default_rng(0).normal(0, 0.012, (SIZE, SIZE)).astype(np.float32)
    assert softness_px(softened(left_part(), drawn(blurred(left_part(), 4.0)) + noise)) == pytest.approx(4.0, rel=0.25)


def test_strands_in_focus_keep_their_matte():
    share = left_part()
    share[:, SIZE // 2 : SIZE // 2 + 40][::6] = 1
    share = blurred(share, 0.8)
    np.testing.assert_allclose(softened(share, drawn(share)), share, atol=0.02)


def test_a_shoulder_out_of_focus_leaves_the_sharp_face_above_it_alone():
    sharp, soft = blurred(left_part(), 0.8), blurred(left_part(), 5.0)
    upper = np.mgrid[:SIZE, :SIZE][0] < SIZE / 2
    matte = softened(sharp, drawn(np.where(upper, sharp, soft)))
    np.testing.assert_allclose(matte[: SIZE // 4], sharp[: SIZE // 4], atol=0.02)
    assert softness_px(np.roll(matte, -SIZE // 4, axis=0)) == pytest.approx(5.0, rel=0.25)


def test_what_is_person_and_what_is_none_stay_so_away_from_the_outline():
    matte = softened(left_part(), drawn(blurred(left_part(), 4.0)))
    np.testing.assert_array_equal(matte[:, : SIZE // 2 - 30], 1)
    np.testing.assert_array_equal(matte[:, SIZE // 2 + 30 :], 0)
    assert matte.mean() == pytest.approx(0.5, abs=0.002)


def test_a_mirrored_photo_has_the_mirrored_matte():
    y, x = np.mgrid[:SIZE, :SIZE]
    share = (np.hypot(x - 110, y - 130) < 70).astype(np.float32)
    guide = drawn(blurred(share, 4.0))
    for turned in (np.fliplr, np.flipud, np.transpose):
        matte = softened(np.ascontiguousarray(turned(share)), np.ascontiguousarray(turned(guide)))
        np.testing.assert_allclose(matte, turned(softened(share, guide)), atol=0.01)


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (2, 3), (5, 300)])
def test_the_smallest_pictures_have_finite_mattes(shape):
    rng = np.random.default_rng(1)
    matte = softened(rng.random(shape).astype(np.float32), rng.random(shape).astype(np.float32))
    assert matte.shape == shape
    assert matte.min() >= 0
    assert matte.max() <= 1


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_a_matte_without_an_outline_stays_as_it_is(share):
    even = np.full((40, 50), share, np.float32)
    np.testing.assert_array_equal(softened(even, np.random.default_rng(2).random((40, 50))), even)


def test_what_is_handed_in_is_left_alone():
    share, guide = left_part(), drawn(blurred(left_part(), 4.0))
    before = share.copy(), guide.copy()
    assert softened(share, guide)[ACROSS].std() != share[ACROSS].std()
    np.testing.assert_array_equal(share, before[0])
    np.testing.assert_array_equal(guide, before[1])


def person_before_a_wall(blur_px, times=1, inside=None, grain=0.0):
    """The matte of a grainy photo whose sides are some times as long as those of the copy in which it is made."""
    light = np.repeat(blurred(np.where(left_part() > 0, DARK, BRIGHT), blur_px)[..., None], 3, axis=-1) ** 2
    size = (times * SIZE, times * SIZE)
    large = np.float32(cv2.resize(light, size, interpolation=cv2.INTER_LINEAR))
    large *= 1 + grain * np.random.default_rng(3).standard_normal((*size, 1)).astype(np.float32)
    share = np.zeros((SIZE, SIZE), np.float32)
    share[inside or ...] = left_part()[inside or ...]
    draft = DraftMatte(share, np.float32(light), np.float32(np.sqrt(light)), size, inside=inside, ends=inside)
    return whole_person(Canvas(large, None, size), finish_matte(draft))


@pytest.mark.parametrize("times", [1, 3])
def test_a_portraits_matte_is_as_soft_as_the_photo_at_any_size(times):
    share = person_before_a_wall(4.0, times).share
    assert softness_px(share[::times, ::times]) == pytest.approx(4.0, rel=0.25)
    assert softness_px(person_before_a_wall(0.7, times).share[::times, ::times]) < 1.5


def test_grain_does_not_show_in_the_matte_of_an_outline_out_of_focus():
    shares = [person_before_a_wall(4.0, 3, grain=grain).share for grain in (0.0, 0.1)]
    np.testing.assert_allclose(shares[1], shares[0], atol=0.01)


def test_outlines_are_told_to_be_out_of_focus_or_not():
    for blur_px, out in ((4.0, 1), (0.7, 0)):
        soft = out_of_focus.softened(left_part(), drawn(blurred(left_part(), blur_px)))[1]
        np.testing.assert_allclose(soft[:, SIZE // 2 - 20 : SIZE // 2 + 20], out, atol=0.01)


def test_nobody_gets_softly_into_a_frame():
    frame = np.s_[20:220, 20:220]
    share = person_before_a_wall(4.0, inside=frame).share
    outside = np.ones_like(share)
    outside[frame] = 0
    np.testing.assert_array_equal(share[outside > 0], 0)
    np.testing.assert_array_equal(share[22:218, 22:90], 1)
