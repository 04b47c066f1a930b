"""Redness that skin has by itself and redness that lamps give it, on a ball whose normals are known."""

from types import SimpleNamespace

import torch

from relight_core.pipeline.per_light.hints import Effects
from relight_core.pipeline.per_light.residual import add_residual, find_residual
from relight_core.pipeline.per_photo.own_redness import own_redness
from relight_core.pipeline.stages import Composed

SIZE, SKIN, NECK = 64, 1, 9
TONE = torch.tensor([0.4, 0.25, 0.2])[None, :, None, None]
AXIS = (torch.arange(SIZE) - 31.5) / 40
ACROSS, DOWN = AXIS[None].expand(SIZE, SIZE), AXIS[:, None].expand(SIZE, SIZE)
STAIN = torch.exp(-((ACROSS - 0.3) ** 2 + DOWN**2) / 0.05)
"""Of a cheek, to the right; it ends little by little."""


def ball(photo, label=SKIN):
    """The surface of a photo (1, 3, S, S) of a ball of skin in one tone."""
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, label] = 1
    normal = torch.stack([ACROSS, -DOWN, (1 - ACROSS**2 - DOWN**2).clamp_min(0.01).sqrt()])[None]
    normal = normal / normal.norm(dim=1, keepdim=True)
    albedo = TONE.expand(1, 3, SIZE, SIZE)
    return SimpleNamespace(photo=photo, albedo=albedo, normal=normal, person=0 * photo[:, :1] + 1, parsing=parsing)


def redness_of(red, blue=0.0, brightness=1.0, label=SKIN):
    """(S, S) how surely skin is red by itself, of log ratios of red and blue to green that a photo shows."""
    ratios = torch.stack([red, torch.zeros_like(red), blue * torch.ones_like(red)])[None]
    seen = ball(TONE * torch.exp(ratios) * brightness, label)
    return own_redness(seen, ratios, torch.ones(1, 1, SIZE, SIZE))[0, 0]


def test_a_stain_on_one_cheek_is_the_skins_own_and_a_red_lamp_from_that_side_is_not():
    of_stain, of_lamp = redness_of(0.6 * STAIN), redness_of(0.5 * ACROSS + 0.3 * ACROSS**2)
    assert of_stain[32, 44] > 0.9
    assert of_stain[:, :24].max() < 0.05
    assert of_lamp.max() < 0.05


def test_what_is_greener_than_most_of_a_face_is_not_red():
    assert redness_of(-0.6 * STAIN).max() < 0.05


def test_what_is_less_blue_as_it_is_redder_is_warm_light_and_no_blood():
    assert redness_of(0.6 * STAIN, -0.6 * STAIN).max() < 0.05
    assert redness_of(0.6 * STAIN, 0.1 * STAIN)[32, 44] > 0.9


def test_neither_a_red_ear_nor_deep_shadow_nor_a_face_between_two_lamps_counts():
    assert redness_of(0.6 * STAIN, label=NECK).max() == 0
    assert redness_of(0.6 * STAIN, brightness=(1 - 0.95 * STAIN))[32, 44] < 0.1
    assert redness_of(0.6 * STAIN + 1.5 * ACROSS).max() < 0.05


def red_over_green(stained):
    """Log, beside the tone's, of the middle of a stain in a dimmer light from elsewhere; its photo shows 0.6."""
    plain = TONE.expand(1, 3, SIZE, SIZE)
    photo = plain * torch.exp(torch.stack([0.1 * stained, -0.5 * stained, -0.5 * stained])[None])
    light, other = torch.full((1, 16, 32, 3), 0.01), torch.full((1, 16, 32, 3), 0.01)
    light[:, 8, 2], other[:, 8, 18] = 20.0, 20.0
    residual = find_residual(ball(photo), photo, light, lambda own: Composed(plain, torch.ones_like(plain)))
    none = torch.zeros(1, 1, SIZE, SIZE)
    dim = Composed(0.2 * plain, torch.full_like(plain, 0.2))
    image, _ = add_residual(residual, dim, Effects(none, none), other)
    return float((image[0, 0, 32, 44] / image[0, 1, 32, 44]).log() - torch.tensor(0.4 / 0.25).log())


def test_a_port_wine_stain_that_the_albedo_has_as_plain_skin_stays_in_another_light_and_a_red_crease_fades():
    crease = torch.exp(-((ACROSS - 0.3) ** 2) / 0.004)
    assert red_over_green(STAIN) > 0.4
    assert red_over_green(crease) < 0.1
    assert abs(red_over_green(0 * STAIN)) < 0.05
