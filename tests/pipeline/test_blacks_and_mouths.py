"""What of a tint is the light's alone: of black hair and cloth its colour, and of a mouth too much blue."""

import pytest
import torch

from relight_core.pipeline.per_photo.black_colour import off_black
from relight_core.pipeline.per_photo.mouth_colour import too_blue
from relight_core.pipeline.stages import Surface

SIZE = 4
BACKGROUND, SKIN, INNER_MOUTH, LIPS, HAIR, HAT, CLOTH = 0, 1, 7, 8, 10, 11, 13
GREY, WARM = (0.1, 0.1, 0.1), (0.14, 0.1, 0.05)


def evenly(colour):
    return torch.tensor(colour)[None, :, None, None].expand(1, 3, SIZE, SIZE).clone()


def surface_of(label, photo, albedo=GREY, share=1.0):
    parsing, one = torch.zeros(1, 14, SIZE, SIZE), torch.ones(1, 1, SIZE, SIZE)
    parsing[:, label], parsing[:, BACKGROUND] = share, 1 - share
    return Surface(evenly(photo), evenly(albedo), evenly((0.0, 0.0, 1.0)), 0 * one, parsing, one, None)


def taken(part_of, surface, tint):
    return part_of(surface, evenly(tint))[0, :, 1, 1]


def log_colour(colour):
    logarithm = (torch.tensor(colour) + 0.005).log()
    return logarithm - logarithm.mean()


@pytest.mark.parametrize("label", [HAIR, HAT, CLOTH])
@pytest.mark.parametrize("shown", [(0.0, 0.0, 0.0), (0.007, 0.004, 0.001)])
def test_what_is_shown_nearly_black_is_left_the_colour_that_it_is_shown_in(label, shown):
    tint = torch.tensor([-0.6, 0.0, 0.6])
    left = log_colour(WARM) + tint - taken(off_black, surface_of(label, shown, WARM), (-0.6, 0.0, 0.6))
    torch.testing.assert_close(left, log_colour(shown))


@pytest.mark.parametrize("shown", [GREY, (0.001, 0.001, 0.05), (0.05, 0.001, 0.001)])
def test_a_tint_of_what_is_bright_enough_to_have_a_colour_stays(shown):
    assert taken(off_black, surface_of(HAIR, shown), (-0.6, 0.0, 0.6)).abs().max() == 0


@pytest.mark.parametrize(("label", "share"), [(SKIN, 1.0), (LIPS, 1.0), (HAIR, 0.4)])
def test_skin_and_what_is_hardly_hair_keep_theirs_in_the_dark(label, share):
    assert taken(off_black, surface_of(label, (0.002, 0.002, 0.002), share=share), (-0.6, 0.0, 0.6)).abs().max() == 0


@pytest.mark.parametrize("label", [INNER_MOUTH, LIPS])
@pytest.mark.parametrize("share", [1.0, 0.8])
def test_from_a_mouth_that_is_shown_without_blue_all_is_taken_but_a_tenth_and_no_other_hue(label, share):
    """An even grey with a tint of -0.3, -0.1 and 0.4 has a log ratio of blue to green of 0.5."""
    part = taken(too_blue, surface_of(label, WARM, share=share), (-0.3, -0.1, 0.4))
    assert float(part[2] - part[1]) == pytest.approx(0.4, abs=1e-5)
    assert float(part.sum()) == pytest.approx(0, abs=1e-6)
    assert float(part[0]) == pytest.approx(float(part[1]), abs=1e-6)


def test_a_mouth_that_is_shown_blue_is_left_as_blue():
    part = taken(too_blue, surface_of(LIPS, (0.1, 0.1, 0.13)), (-0.3, -0.1, 0.4))
    assert float(part[2] - part[1]) == pytest.approx(0.5 - float(torch.tensor(0.135 / 0.105).log()), abs=1e-5)


@pytest.mark.parametrize(("albedo", "tint"), [(GREY, (0.3, 0.1, -0.4)), ((0.1, 0.1, 0.3), (0.3, 0.1, -0.4))])
def test_a_tint_that_makes_a_mouth_less_blue_stays_whole(albedo, tint):
    assert taken(too_blue, surface_of(LIPS, WARM, albedo), tint).abs().max() == 0


def test_no_more_is_taken_than_the_tint_adds():
    part = taken(too_blue, surface_of(LIPS, WARM, (0.1, 0.1, 0.3)), (-0.05, -0.05, 0.1))
    assert float(part[2] - part[1]) == pytest.approx(0.15, abs=1e-5)


@pytest.mark.parametrize(("label", "share"), [(SKIN, 1.0), (CLOTH, 1.0), (LIPS, 0.4)])
def test_what_is_no_mouth_or_hardly_one_may_be_as_blue_as_the_tint_says(label, share):
    assert taken(too_blue, surface_of(label, WARM, share=share), (-0.3, -0.1, 0.4)).abs().max() == 0
