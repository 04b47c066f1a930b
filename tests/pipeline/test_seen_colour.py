"""The albedo of what is not skin, from photos whose true colours are known."""

import pytest
import torch

from relight_core.imaging.tensor_colour import grey
from relight_core.pipeline.per_photo.seen_colour import with_seen_colours
from relight_core.pipeline.stages import Surface

SIZE = 24
SKIN, BROW, EYE, LIPS, NECK, HAIR, HAT, CLOTH = 1, 2, 4, 8, 9, 10, 11, 13
WARM = torch.tensor([1.5, 1.0, 0.6])[None, :, None, None]
FACE = torch.tensor([0.4, 0.25, 0.18])[None, :, None, None]
RED, GREY = (torch.tensor(colour)[None, :, None, None] for colour in ([0.5, 0.25, 0.2], [0.3, 0.3, 0.3]))


def evenly(colour):
    return colour.expand(1, 3, SIZE, SIZE).clone()


def seen(label, true, guess, level=0.4, gloss=0.0, row=2):
    """The upper half of a photo shows something, the lower half a face; the albedo (3,) that the former is given."""
    upper = torch.zeros(1, 1, SIZE, SIZE)
    upper[:, :, : SIZE // 2] = 1
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, label : label + 1], parsing[:, SKIN : SKIN + 1] = upper, 1 - upper
    albedo, irradiance = FACE + upper * (guess - FACE), evenly(WARM)
    photo = level * ((FACE + upper * (true - FACE)) * irradiance + gloss)
    one = torch.ones(1, 1, SIZE, SIZE)
    surface = Surface(photo.clamp(0, 1), albedo, evenly(0 * WARM), 0 * one, parsing, one, None)
    given = with_seen_colours(surface, irradiance, evenly(0 * WARM + gloss)).albedo
    assert torch.isfinite(given).all()
    return given[0, :, row, SIZE // 2], given[0, :, -2, SIZE // 2]


def ratios(colour):
    return colour / colour.mean()


@pytest.mark.parametrize("label", [LIPS, HAIR, HAT, CLOTH])
def test_what_may_be_of_any_colour_has_the_one_that_photo_and_light_give_it(label):
    given, face = seen(label, RED, GREY)
    torch.testing.assert_close(ratios(given), ratios(RED[0, :, 0, 0]), rtol=0.05, atol=0)
    torch.testing.assert_close(face, FACE[0, :, 0, 0])


@pytest.mark.parametrize("label", [LIPS, HAIR, CLOTH])
@pytest.mark.parametrize("channel", [0, 1, 2])
def test_a_pure_colour_is_as_bright_as_de_lighting_says(label, channel):
    pure = evenly(torch.full((1, 3, 1, 1), 0.03))
    pure[:, channel] = 0.6
    given, _ = seen(label, pure, grey(pure).expand_as(pure))
    assert given.argmax() == channel
    torch.testing.assert_close(grey(given[None, :, None, None]), grey(pure)[..., :1, :1], rtol=0.01, atol=0)


@pytest.mark.parametrize("label", [LIPS, HAIR, HAT, CLOTH])
def test_gloss_on_what_is_dark_is_not_taken_for_its_colour(label):
    given, _ = seen(label, RED / 10, RED / 10, gloss=0.1)
    torch.testing.assert_close(given, RED[0, :, 0, 0] / 10, rtol=1e-3, atol=0)


@pytest.mark.parametrize("label", [SKIN, EYE, NECK])
def test_skin_and_eyes_keep_what_de_lighting_says(label):
    given, _ = seen(label, RED, GREY)
    torch.testing.assert_close(given, GREY[0, :, 0, 0])


def test_brows_and_by_half_hats_are_as_dark_as_they_are_seen_but_cloth_is_left_as_bright_as_it_was():
    guess = evenly(FACE)
    cloth, hat = (seen(label, 0.5 * FACE, guess)[0].mean() / guess.mean() for label in (CLOTH, HAT))
    brow = seen(BROW, 0.5 * FACE, guess, row=SIZE // 2 - 1)[0].mean() / guess.mean()
    assert cloth == pytest.approx(1.0, abs=0.03)
    # The hat is half the picture, which so is three quarters as bright.
    assert hat == pytest.approx((0.5 / 0.75) ** 0.5, abs=0.03)
    assert brow == pytest.approx(0.5**0.8, abs=0.03)


def test_a_photo_s_level_says_nothing():
    one, other = (seen(CLOTH, RED, GREY, level)[0] for level in (0.2, 0.6))
    torch.testing.assert_close(ratios(one), ratios(other), rtol=0.05, atol=0)


def test_black_cloth_under_a_warm_light_is_not_blue():
    given, _ = seen(CLOTH, GREY / 60, GREY / 6)
    assert given[2] < 1.6 * given[0]


@pytest.mark.parametrize("level", [0.0, 1e4])
def test_of_a_black_or_blown_photo_nothing_is_learnt_that_is_not_finite(level):
    given, face = seen(HAT, RED, GREY, level)
    assert float(given.min()) >= 0
    assert float(given.max()) <= 1


def test_cloth_whose_red_is_clipped_alone_is_not_cyan():
    white = evenly(torch.full((1, 3, 1, 1), 0.8))
    given, _ = seen(CLOTH, white, white, level=0.95)
    torch.testing.assert_close(given, white[0, :, 0, 0], rtol=0.03, atol=0)


def test_black_hair_that_a_photo_in_warm_light_shows_grey_is_grey():
    """By the light that explains the face it would be two and a half times as blue as red."""
    shown_grey = torch.tensor([0.008, 0.012, 0.02])[None, :, None, None]
    given, _ = seen(HAIR, shown_grey, GREY / 6)
    torch.testing.assert_close(ratios(given), torch.ones(3), rtol=0.1, atol=0)


def test_lips_are_no_bluer_than_lips_are_or_the_photo_shows_them_and_cloth_may_be():
    """The blue of each is 0.9 of its green in the photo, whose light has 0.6, and of lipstick 1.8."""
    purple, lipstick = (torch.tensor(colour)[None, :, None, None] for colour in ([0.4, 0.2, 0.3], [0.3, 0.2, 0.6]))
    guess = torch.tensor([0.4, 0.22, 0.2])[None, :, None, None]
    lips, cloth, painted = (
        seen(label, true, guess)[0] for label, true in ((LIPS, purple), (CLOTH, purple), (LIPS, lipstick))
    )
    assert float(lips[2] / lips[1]) < 1.15
    assert float(cloth[2] / cloth[1]) == pytest.approx(1.5, rel=0.05)
    assert float(painted[2] / painted[1]) == pytest.approx(1.8, rel=0.1)
