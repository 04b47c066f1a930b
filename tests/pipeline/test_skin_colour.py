"""Colours that other lights gave to skin, on flat pictures whose colours are known."""

import pytest
import torch

from relight_core.pipeline.per_photo.skin_colour import deep_shadow, in_one_colour
from relight_core.pipeline.stages import Surface

SIZE, SKIN = 32, 1
TONE = (0.5, 0.3, 0.2)
CHEEK = slice(10, 22)


def face(cheek=TONE, cheek_seen=0.3, width=CHEEK):
    """A surface and its skin: one tone but for a cheek, which the photo shows at a luminance of its own."""
    albedo = torch.tensor(TONE)[None, :, None, None].expand(1, 3, SIZE, SIZE).clone()
    albedo[..., width, width] = torch.tensor(cheek)[None, :, None, None]
    photo = torch.full((1, 3, SIZE, SIZE), 0.3)
    photo[..., width, width] = cheek_seen
    one, parsing = torch.ones(1, 1, SIZE, SIZE), torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, SKIN] = 1
    normal = torch.tensor([0.0, 0, 1])[None, :, None, None].expand(1, 3, SIZE, SIZE)
    return Surface(photo, albedo, normal, 0 * one, parsing, one, torch.ones(1, 16, 32, 3)), one


def ratios(albedo, row=16, column=16):
    """Logs of red and of blue over green at a pixel, beside those of the tone."""
    red, green, blue = albedo[0, :, row, column].tolist()
    of_tone = torch.tensor([TONE[0] / TONE[1], TONE[2] / TONE[1]]).log()
    return (torch.tensor([red / green, blue / green]).log() - of_tone).tolist()


def test_bluer_skin_that_is_no_less_red_is_lit_so_but_pale_skin_may_be_bluer():
    bluer, _ = ratios(in_one_colour(*face((0.5, 0.3, 0.24))).albedo)[::-1]
    paler = ratios(in_one_colour(*face((0.455, 0.3, 0.224))).albedo)
    assert 0.03 < bluer < 0.1
    assert paler == pytest.approx([-0.094, 0.113], abs=0.03)


def test_a_cheek_may_be_as_much_redder_as_flush_makes_it():
    red, blue = ratios(in_one_colour(*face((0.675, 0.3, 0.2))).albedo)
    assert red == pytest.approx(0.15, abs=0.04)
    assert blue == pytest.approx(0.0, abs=0.02)


def test_a_spot_of_the_skin_s_own_colour_in_a_green_cheek_stays_as_it_is():
    surface, skin = face((0.335, 0.3, 0.2))
    surface.albedo[..., 15:17, 15:17] = torch.tensor(TONE)[:, None, None]
    evened = in_one_colour(surface, skin).albedo
    assert ratios(evened) == pytest.approx([0, 0], abs=0.02)
    assert ratios(evened, 12, 12)[0] > -0.35


def test_in_deep_shadow_even_a_spot_has_the_skins_colour_and_in_light_a_mole_keeps_its_own():
    spot = slice(15, 17)
    purple = (0.45, 0.25, 0.35)
    in_shadow, in_light = (in_one_colour(*face(purple, seen, spot)).albedo for seen in (0.04, 0.3))
    assert ratios(in_shadow)[1] == pytest.approx(0.05, abs=0.02)
    assert ratios(in_light)[1] > 0.5


def test_where_the_photo_is_black_skin_has_the_colour_of_the_rest():
    red = ratios(in_one_colour(*face((0.5, 0.1, 0.02), 0.005)).albedo)
    assert red == pytest.approx([0, 0], abs=0.02)


def test_plain_skin_keeps_its_colour_beside_a_red_collar_that_is_half_taken_for_a_neck():
    surface, skin = face()
    surface.albedo[..., 20:, :] = torch.tensor((0.5, 0.05, 0.1))[:, None, None]
    skin[..., 20:, :] = 0.5
    beside = ratios(in_one_colour(surface, skin).albedo, row=19)
    assert beside == pytest.approx([0, 0], abs=0.02)


def test_luminance_stays():
    surface, skin = face((0.35, 0.25, 0.4), 0.03)
    weights = torch.tensor([0.2126, 0.7152, 0.0722])[None, :, None, None]
    evened = in_one_colour(surface, skin).albedo
    torch.testing.assert_close((evened * weights).sum(1), (surface.albedo * weights).sum(1), rtol=1e-4, atol=1e-5)


def test_a_shadow_is_deep_beside_the_rest_of_the_skin_and_not_by_itself():
    surface, skin = face(cheek_seen=0.03)
    shadow = deep_shadow(surface.photo, skin)
    assert shadow[0, 0, 16, 16] == 1
    assert shadow[0, 0, 2, 2] == 0
    torch.testing.assert_close(deep_shadow(surface.photo / 20, skin), shadow)
    assert not deep_shadow(surface.photo, 0 * skin).any()


@pytest.mark.parametrize("photo", [torch.zeros(1, 3, SIZE, SIZE), torch.full((1, 3, SIZE, SIZE), 1e4)])
def test_black_and_blinding_photos_stay_finite(photo):
    surface, skin = face((0.0, 0.0, 0.0))
    surface.photo[:] = photo
    evened = in_one_colour(surface, skin).albedo
    assert torch.isfinite(evened).all()
    assert 0 <= evened.min() <= evened.max() <= 1


def blue_spot(soft_px):
    """How blue a large blue spot on plain skin is, whose edge is sharp or so many pixels wide; as log ratios."""
    surface, skin = face(width=slice(0, 0))
    axis = torch.arange(SIZE) - 15.5
    distance = (axis[:, None].square() + axis.square()).sqrt()
    share = ((6 + soft_px / 2 - distance) / max(soft_px, 1)).clamp(0, 1)
    colour = torch.tensor([0.5, 1.0, 5.0])[:, None, None]
    surface.albedo[0] *= colour**share
    return ratios(in_one_colour(surface, skin).albedo)


def test_paint_ends_at_an_edge_and_stays_and_a_lamps_colour_fades_into_the_skin_and_goes():
    assert blue_spot(0) == pytest.approx([-0.69, 1.61], abs=0.02)
    assert blue_spot(20)[1] < 0.8
