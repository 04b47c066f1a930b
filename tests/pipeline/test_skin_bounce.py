"""The light that lit skin throws into shadows beside it."""

import pytest
import torch

from relight_core.pipeline.per_light.skin_bounce import interreflection, skin_bounce
from relight_core.pipeline.stages import Surface

SIZE = 128
SKIN, LEFT_EYE, HAIR = 1, 4, 10


def cheek_beside_a_nose(label=SKIN, albedo=(0.6, 0.4, 0.3)):
    """A cheek that faces the camera, left, and the flank of a nose in the middle that looks at it."""
    x = (torch.arange(SIZE) + 0.5) / SIZE * 2 - 1
    relief = x.clamp(0, 0.25)[None, None, None].expand(1, 1, SIZE, SIZE).contiguous()
    flank = (x > 0) & (x < 0.25)
    normal = torch.zeros(1, 3, SIZE, SIZE)
    normal[:, 2] = 1
    normal[..., flank] = torch.tensor([-1.0, 0.0, 1.0])[None, :, None, None] / 2**0.5
    colour = torch.tensor(albedo)[None, :, None, None].expand(1, 3, SIZE, SIZE)
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, label] = 1
    person = torch.ones_like(relief)
    return Surface(colour, colour, normal, relief, parsing, person, torch.ones(1, 16, 32, 3)), flank


def thrown(surface, radiance):
    return interreflection(skin_bounce(surface), radiance, surface.albedo)


def lit_flank(surface, flank):
    radiance = torch.zeros_like(surface.albedo)
    radiance[..., flank] = 2 * surface.albedo[..., flank]
    return radiance


def test_a_lit_nose_lights_the_cheek_beside_it_in_the_colour_of_skin_and_less_farther_off():
    surface, flank = cheek_beside_a_nose()
    row = thrown(surface, lit_flank(surface, flank))[0, :, SIZE // 2]
    near, far = row[:, 58], row[:, 16]
    assert 0.02 < near[0] < 2 * 0.6 * 0.6
    assert (near > 4 * far).all()
    assert far.min() > 0
    assert near[0] / near[2] == pytest.approx((0.6 / 0.3) ** 2, rel=0.01)


def test_twice_the_light_throws_twice_and_no_light_nothing():
    surface, flank = cheek_beside_a_nose()
    radiance = lit_flank(surface, flank)
    torch.testing.assert_close(thrown(surface, 2 * radiance), 2 * thrown(surface, radiance))
    assert thrown(surface, torch.zeros_like(radiance)).max() == 0


@pytest.mark.parametrize("label", [HAIR, LEFT_EYE])
def test_hair_and_eyes_get_none(label):
    surface, flank = cheek_beside_a_nose(label)
    assert thrown(surface, lit_flank(surface, flank)).max() == 0


def test_white_skin_throws_no_more_than_it_gets():
    surface, _ = cheek_beside_a_nose(albedo=(1.0, 1.0, 1.0))
    white = torch.ones_like(surface.albedo)
    assert 0 < thrown(surface, white).max() <= 1.0


def test_what_skin_sends_out_has_its_colour_already():
    surface, _ = cheek_beside_a_nose(albedo=(0.1, 0.05, 0.04))
    assert torch.equal(skin_bounce(surface).reflecting, torch.ones(1, 3, 32, 32))


def test_rough_skin_gets_as_much_as_smooth_skin_does():
    """Pixels that look to all sides look ahead together."""
    surface, flank = cheek_beside_a_nose()
    radiance = lit_flank(surface, flank)
    smooth = thrown(surface, radiance)
    up = torch.ones(SIZE, SIZE)
    up[::2] = -1
    rough = torch.stack([0 * up, up, 0 * up])[None] * ~flank
    surface.normal.copy_(torch.nn.functional.normalize(surface.normal + rough, dim=1))
    near = (..., slice(8, 120), slice(56, 62))
    torch.testing.assert_close(thrown(surface, radiance)[near], smooth[near], rtol=0.05, atol=1e-3)
