"""Colours where the photo is blown out: skin takes those of the skin around it, anything else is white."""

import pytest
import torch

from relight_core.pipeline.per_photo.blown import clipped_share, fill_in, mend_blown

SIZE = 24
SKIN, LEFT_BROW, LIPS, CLOTH = 1, 2, 8, 13
SKIN_COLOUR = torch.tensor([0.6, 0.4, 0.3])[None, :, None, None]


def parsing_of(label):
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, label] = 1
    return parsing


def flat(colour):
    return torch.tensor(colour)[None, :, None, None].expand(1, 3, SIZE, SIZE).clone()


def with_middle(image, colour):
    image[:, :, 8:16, 8:16] = torch.tensor(colour)[None, :, None, None]
    return image


def with_brow_in_the_middle(parsing):
    parsing[:, :, 8:16, 8:16] = 0
    parsing[:, LEFT_BROW, 8:16, 8:16] = 1
    return parsing


def test_blown_skin_takes_the_colour_of_the_skin_around():
    photo = with_middle(flat((0.6, 0.4, 0.3)), (1.0, 1.0, 1.0))
    albedo = with_middle(SKIN_COLOUR.expand(1, 3, SIZE, SIZE).clone(), (0.9, 0.95, 0.7))
    mended = mend_blown(clipped_share(photo), albedo, parsing_of(SKIN))
    torch.testing.assert_close(mended, SKIN_COLOUR.expand_as(mended), atol=0.01, rtol=0)


def test_blown_lips_take_the_colour_of_what_is_left_of_them():
    parsing = parsing_of(SKIN)
    parsing[:, :, 6:18, 6:18] = 0
    parsing[:, LIPS, 6:18, 6:18] = 1
    photo = with_middle(flat((0.6, 0.4, 0.3)), (1.0, 1.0, 1.0))
    albedo = SKIN_COLOUR.expand(1, 3, SIZE, SIZE).clone()
    albedo[:, :, 6:18, 6:18] = torch.tensor((0.5, 0.2, 0.2))[None, :, None, None]
    mended = mend_blown(clipped_share(photo), with_middle(albedo.clone(), (0.8, 0.8, 0.9)), parsing)
    torch.testing.assert_close(mended[0, :, 12, 12], torch.tensor((0.5, 0.2, 0.2)), atol=0.03, rtol=0)


def test_between_blown_brows_there_is_skin():
    parsing = with_brow_in_the_middle(parsing_of(SKIN))
    photo = with_middle(flat((0.6, 0.4, 0.3)), (1.0, 1.0, 1.0))
    albedo = with_middle(SKIN_COLOUR.expand(1, 3, SIZE, SIZE).clone(), (0.9, 0.95, 1.0))
    red, _, blue = mend_blown(clipped_share(photo), albedo, parsing)[0, :, 12, 12]
    assert red / blue == pytest.approx(2.0, rel=0.05)


def test_skin_whose_red_alone_is_clipped_is_not_yellow():
    photo = with_middle(flat((0.6, 0.4, 0.3)), (1.0, 0.8, 0.6))
    albedo = with_middle(SKIN_COLOUR.expand(1, 3, SIZE, SIZE).clone(), (0.6, 0.5, 0.37))
    red, green, blue = mend_blown(clipped_share(photo), albedo, parsing_of(SKIN))[0, :, 12, 12]
    assert red / green == pytest.approx(1.5, rel=0.04)
    assert green / blue == pytest.approx(4 / 3, rel=0.04)


def test_a_clipped_channel_is_lifted_and_never_lowered():
    photo, reds = with_middle(flat((0.6, 0.4, 0.3)), (1.0, 0.8, 0.6)), []
    for red in (0.75, 0.95):
        albedo = with_middle(SKIN_COLOUR.expand(1, 3, SIZE, SIZE).clone(), (red, 0.5, 0.375))
        reds.append(float(mend_blown(clipped_share(photo), albedo, parsing_of(SKIN))[0, 0, 12, 12]))
    assert reds[1] > reds[0] + 0.05


def test_other_things_that_are_blown_are_white_and_keep_their_brightness():
    photo = with_middle(flat((0.3, 0.3, 0.3)), (1.0, 1.0, 1.0))
    albedo = with_middle(flat((0.3, 0.2, 0.3)), (0.7, 0.6, 0.9))
    mended = mend_blown(clipped_share(photo), albedo, parsing_of(CLOTH))
    blown = mended[0, :, 12, 12]
    torch.testing.assert_close(blown, blown[:1].expand(3))
    assert blown[0] == pytest.approx(0.2126 * 0.7 + 0.7152 * 0.6 + 0.0722 * 0.9, abs=1e-3)
    torch.testing.assert_close(mended[..., :6], albedo[..., :6])


@pytest.mark.parametrize("label", [SKIN, CLOTH])
def test_a_photo_that_is_not_blown_keeps_its_albedo(label):
    albedo = torch.rand(1, 3, SIZE, SIZE, generator=torch.Generator().manual_seed(0))
    assert torch.equal(mend_blown(clipped_share(flat((0.89, 0.5, 0.4))), albedo, parsing_of(label)), albedo)


def test_a_face_that_is_blown_throughout_stays_finite():
    albedo = torch.rand(1, 3, SIZE, SIZE, generator=torch.Generator().manual_seed(1))
    mended = mend_blown(clipped_share(flat((1.0, 1.0, 1.0))), albedo, parsing_of(SKIN))
    assert torch.isfinite(mended).all()
    assert mended.min() >= 0
    assert mended.max() <= 1


@pytest.mark.parametrize("size", [1, 5, 24])
def test_what_is_known_stays_and_gaps_are_filled_with_it(size):
    image = torch.rand(1, 2, size, size, generator=torch.Generator().manual_seed(2))
    torch.testing.assert_close(fill_in(image, torch.ones(1, 1, size, size)), image)
    weight = torch.zeros(1, 1, size, size)
    weight[..., 0, 0] = 1
    filled = fill_in(image, weight)
    torch.testing.assert_close(filled, image[..., :1, :1].expand_as(filled), atol=1e-4, rtol=0)
