"""How bright a photo may have been where it is clipped, channel by channel, and which colour it is taken to have."""

import pytest
import torch

from relight_core.pipeline.per_photo.blown import at_least, mend_blown

SIZE, SKIN, LIPS = 24, 1, 8
SKIN_COLOUR = (0.6, 0.4, 0.3)


def spread(*channels):
    return torch.tensor(channels)[None, :, None, None].expand(1, 3, 4, 4)


@pytest.mark.parametrize(
    ("seen", "clipped", "skin", "may_be"),
    [
        ((-0.5, 0.1, 0.4), (0, 0, 0), 1, (-0.5, 0.1, 0.4)),
        ((0.0, 0.3, 0.3), (1, 0, 0), 1, (0.3, 0.3, 0.3)),
        ((0.0, 0.3, 0.3), (1, 0, 0), 0, (0.3, 0.3, 0.3)),
        ((0.5, 0.3, 0.1), (1, 0, 0), 1, (0.5, 0.3, 0.1)),
        ((0.0, 0.1, 0.4), (1, 1, 0), 1, (0.4, 0.4, 0.4)),
        ((-0.2, 0.1, 0.3), (1, 1, 1), 1, (0.3, 0.3, 0.3)),
        ((-0.3, -0.2, -0.1), (1, 1, 1), 1, (0.0, 0.0, 0.0)),
        ((-0.3, -0.2, -0.1), (1, 1, 1), 0, (-0.1, 0.0, 0.1)),
        ((0.1, 0.2, 0.3), (1, 1, 1), 0, (0.1, 0.2, 0.3)),
    ],
)
def test_a_clipped_channel_may_be_as_bright_as_the_others_and_what_is_all_clipped_as_its_model(
    seen, clipped, skin, may_be
):
    found = at_least(spread(*seen), spread(*map(float, clipped)), torch.full((1, 1, 4, 4), float(skin)))
    torch.testing.assert_close(found, spread(*may_be))


def mended(middle, clipped, lips=False):
    """Colour in the middle of skin, of an albedo there and how far each channel is clipped."""
    parsing, place = torch.zeros(1, 14, SIZE, SIZE), (Ellipsis, slice(8, 16), slice(8, 16))
    parsing[:, SKIN] = 1
    albedo, share = (torch.zeros(1, 3, SIZE, SIZE) for _ in range(2))
    albedo += torch.tensor(SKIN_COLOUR)[None, :, None, None]
    albedo[place] = torch.tensor(middle)[None, :, None, None]
    share[place] = torch.tensor(clipped)[None, :, None, None]
    if lips:
        parsing[place] = 0
        parsing[:, LIPS, 8:16, 8:16] = 1
    return mend_blown(share, albedo, parsing)[0, :, 12, 12].tolist()


def test_skin_with_two_clipped_channels_has_the_colour_around_it():
    red, green, blue = mended((0.9, 0.95, 0.3), (1.0, 1.0, 0.0))
    assert (red / green, green / blue) == pytest.approx((1.5, 4 / 3), rel=0.01)


def spot_beside(level):
    """How bright a blown spot comes out beside the skin around, by the level of what has lost its red alone between."""
    parsing, clipped = torch.zeros(1, 14, SIZE, SIZE), torch.zeros(1, 3, SIZE, SIZE)
    parsing[:, SKIN] = 1
    clipped[:, 0, 4:20, 4:20] = clipped[:, :, 8:16, 8:16] = 1
    skin = torch.tensor(SKIN_COLOUR)[None, :, None, None]
    albedo = skin.expand(1, 3, SIZE, SIZE).clone()
    albedo[..., 4:20, 4:20] *= level
    albedo[..., 8:16, 8:16] = 0.9
    return (mend_blown(clipped, albedo, parsing) / skin)[0, 1, 12, 12].item()


def test_a_blown_spot_is_about_as_bright_as_what_is_left_of_the_skin_beside_it():
    assert spot_beside(0.7) < 0.95 * spot_beside(1.0)
    assert spot_beside(1.3) > 1.05 * spot_beside(1.0)
    assert spot_beside(3.0) == pytest.approx(spot_beside(1.4), rel=3e-3)


def test_clipped_skin_has_no_albedo_above_1():
    for clipped in ((1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (1.0, 1.0, 1.0)):
        assert max(mended((0.9, 0.9, 0.9), clipped)) <= 1


def test_lips_of_which_nothing_is_left_have_the_colour_of_skin():
    red, green, blue = mended((0.8, 0.8, 0.9), (1.0, 1.0, 1.0), lips=True)
    assert (red / green, green / blue) == pytest.approx((1.5, 4 / 3), rel=0.1)
