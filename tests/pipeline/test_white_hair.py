"""White hair on a skull, which parsing takes for a scalp: hair where it has the colour of the light."""

import torch

from relight_core.pipeline.per_photo.white_hair import with_white_hair
from relight_core.pipeline.stages import Surface

SIZE, SKIN, LEFT_BROW, LEFT_EYE, NECK, HAIR, HAT = 24, 1, 2, 4, 9, 10, 11
SKIN_ALBEDO = torch.tensor([0.5, 0.3, 0.2])[:, None, None]
PINK = torch.tensor([0.7, 0.5, 0.42])[:, None, None]


def head(scalp, light=(1.0, 1.0, 1.0), eyes=LEFT_EYE):
    """A face with eyes in the middle, below a scalp of some albedo that was found to be pink, in a coloured light."""
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, NECK, : SIZE // 3] = 1
    parsing[:, SKIN, SIZE // 3 :] = 1
    if eyes:
        parsing[:, :, SIZE // 2, 4:12] = 0
        parsing[:, eyes, SIZE // 2, 4:12] = 1
    truth = SKIN_ALBEDO.expand(3, SIZE, SIZE).clone()
    truth[:, : SIZE // 3] = torch.as_tensor(scalp)
    found = SKIN_ALBEDO.expand(3, SIZE, SIZE).clone()
    found[:, : SIZE // 3] = PINK
    one = torch.ones(1, 1, SIZE, SIZE)
    photo = 0.8 * truth * torch.tensor(light)[:, None, None]
    return Surface(photo[None], found[None], one.repeat(1, 3, 1, 1), one, parsing, one, torch.ones(1, 16, 32, 3))


def red_over_blue(surface):
    return float((surface.albedo[0, 0] / surface.albedo[0, 2])[: SIZE // 3].median())


def test_a_scalp_of_no_colour_is_white_hair_of_the_brightness_it_was_found_to_have():
    before = head(0.6)
    after = with_white_hair(before)
    assert float(after.parsing[0, HAIR, : SIZE // 3].min()) > 0.95
    torch.testing.assert_close(after.parsing.sum(1), before.parsing.sum(1))
    assert abs(red_over_blue(after) - 1) < 0.05
    grey = (after.albedo[0] * torch.tensor([0.2126, 0.7152, 0.0722])[:, None, None]).sum(0)[: SIZE // 3]
    assert abs(float(grey.mean()) / float((PINK[:, 0, 0] * torch.tensor([0.2126, 0.7152, 0.0722])).sum()) - 1) < 0.01
    torch.testing.assert_close(after.albedo[:, :, SIZE // 3 :], before.albedo[:, :, SIZE // 3 :])


def test_in_a_coloured_light_too():
    after = with_white_hair(head(0.5, light=(1.0, 0.8, 0.6)))
    assert float(after.parsing[0, HAIR, : SIZE // 3].min()) > 0.95
    assert abs(red_over_blue(after) - 1) < 0.05


def test_a_bald_head_stays_bald_even_with_a_white_highlight():
    bald = SKIN_ALBEDO.expand(3, SIZE // 3, SIZE).clone()
    bald[:, :, : SIZE // 3] += 0.5
    before = head(bald)
    assert with_white_hair(before) is before


def test_a_face_whose_eyes_are_not_seen_is_left_as_it_is():
    before = head(0.6, eyes=None)
    assert with_white_hair(before) is before


def test_brows_show_where_the_scalp_is_when_the_eyes_are_hidden():
    assert float(with_white_hair(head(0.6, eyes=LEFT_BROW)).parsing[0, HAIR, : SIZE // 3].min()) > 0.95


def test_a_face_whose_skin_is_covered_is_left_as_it_is():
    before = head(0.6)
    before.parsing[:, [SKIN, HAT]] = before.parsing[:, [HAT, SKIN]]
    assert with_white_hair(before) is before


def test_a_hint_of_another_tint_makes_no_hair_of_a_scalp_at_once():
    """A limit on the scalp's middle colour alone would turn all of it, or none."""
    grey, skin = torch.full((3, SIZE // 3, SIZE), 0.5), SKIN_ALBEDO.expand(3, SIZE // 3, SIZE)
    mixtures = (torch.lerp(grey, skin, float(part)) for part in torch.linspace(0, 1, 51))
    shares = [float(with_white_hair(head(scalp)).parsing[0, HAIR].mean()) for scalp in mixtures]
    steps = [abs(after - before) for before, after in zip(shares, shares[1:], strict=False)]
    assert max(shares) - min(shares) > 0.3
    assert max(steps) < 0.25 * (max(shares) - min(shares))
