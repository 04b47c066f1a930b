"""The light a photo was taken under, found from a head of known surface."""

from dataclasses import replace

import pytest
import torch

from relight_core.lighting.reflection import ReflectionTable
from relight_core.pipeline import stages
from relight_core.pipeline.per_photo.source_light import explain_source_light, exposure_of_photo, level_over_person

SIZE, SKIN, NECK, HAIR = 32, 1, 9, 10
ALBEDO = (0.45, 0.27, 0.18)


def ball(albedo=ALBEDO):
    """A ball of skin, photographed in the dark."""
    y, x = torch.meshgrid(torch.linspace(1, -1, SIZE), torch.linspace(-1, 1, SIZE), indexing="ij")
    height = (0.9 - x * x - y * y).clamp_min(0.02).sqrt()
    normal = torch.nn.functional.normalize(torch.stack([x, y, height]), dim=0)[None]
    person = (x * x + y * y < 0.9).float()[None, None]
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, SKIN], parsing[:, 0] = person[:, 0], 1 - person[:, 0]
    colour = torch.tensor(albedo)[None, :, None, None].expand(1, 3, SIZE, SIZE)
    guess = torch.ones(1, 16, 32, 3)
    return stages.Surface(0 * colour, colour, normal, height[None, None] * person, parsing, person, guess)


def photographed(surface, light, saturation=1.0):
    """The ball's photo under a light, gloss and own shadows included, by a camera that saturates its colours."""
    reflector, relief = stages.reflector(ReflectionTable(), surface), stages.march(surface, 16)
    reflected = stages.reflect(reflector, light)
    hidden = torch.nn.functional.interpolate(relief.shadow_fraction(light), size=SIZE, mode="bilinear")
    seen = (surface.albedo * reflected[:, :3] + reflected[:, 3:]) * (1 - hidden) * surface.person
    brightness = seen.clamp_min(1e-6).log().mean(1, keepdim=True).exp()
    return replace(surface, photo=brightness * (seen / brightness) ** saturation), reflector, relief


AHEAD, BEHIND = (0, 1, 2, -3, -2, -1), (13, 14, 15, 16, 17, 18)
"""Columns of a light around the camera, which the ball's middle sees, and behind the ball, which nothing sees."""


def red_over_blue(light, columns=AHEAD):
    mean = light[:, 5:11, list(columns)].mean((0, 1, 2))
    return float(mean[0] / mean[2])


def coloured(red, green, blue):
    return 0.8 * torch.tensor([red, green, blue]).expand(1, 16, 32, 3)


def explained(light, **how):
    return explain_source_light(*photographed(ball(), light, **how))


def test_glossy_skin_in_a_white_light_is_not_taken_for_skin_in_a_blue_one():
    light = explained(coloured(1.0, 1.0, 1.0))
    assert abs(red_over_blue(light) - 1) < 0.03
    assert abs(float(light.mean()) / 0.8 - 1) < 0.1


def test_a_blue_light_is_found_blue():
    assert abs(red_over_blue(explained(coloured(0.7, 1.0, 1.3))) / (0.7 / 1.3) - 1) < 0.15


def test_a_camera_that_saturates_skin_makes_the_light_hardly_warmer():
    warmer = red_over_blue(explained(coloured(1.0, 1.0, 1.0), saturation=1.3))
    assert 1.0 < warmer < 1.08


def test_of_a_deeply_orange_light_most_is_left_to_the_light():
    found = red_over_blue(explained(coloured(2.0, 1.0, 0.3)))
    assert found > 5.0


@pytest.mark.parametrize(
    ("light", "ratio", "off"),
    [((1.15, 1.0, 0.8), 1.14, 0.02), ((1.4, 1.0, 0.6), 2.15, 0.08), ((2.0, 1.0, 0.3), 6.14, 0.3)],
)
def test_of_a_mild_cast_most_is_left_to_the_camera_and_the_less_the_deeper_it_is(light, ratio, off):
    found = explained(coloured(*light))
    assert red_over_blue(found) == pytest.approx(ratio, abs=off)
    luminance = found.mean((0, 1, 2)) @ torch.tensor([0.2126, 0.7152, 0.0722])
    assert float(luminance) == pytest.approx(0.8 * (0.2126 * light[0] + 0.7152 + 0.0722 * light[2]), rel=0.025)


def test_of_the_colour_that_the_guess_has_already_nothing_is_the_camera_s():
    warm = coloured(1.4, 1.0, 0.6)
    found = explain_source_light(*photographed(replace(ball(), source_light=warm), warm))
    assert red_over_blue(found) == pytest.approx(1.4 / 0.6, rel=0.02)


def test_dark_skin_that_shines_less_than_is_believed_still_tells_some_blue():
    """What the guess mirrors is more than all that is seen there; of most of it the surface must be the source."""
    surface, reflector, relief = photographed(ball((0.03, 0.02, 0.015)), coloured(1.0, 1.0, 1.0))
    matt = surface.albedo * stages.reflect(reflector, coloured(1.0, 1.0, 1.0))[:, :3] * surface.person
    assert red_over_blue(explain_source_light(replace(surface, photo=matt), reflector, relief)) < 5


def test_what_is_black_says_little_of_the_light():
    """The upper half of a ball is black cloth with some blue on it."""
    upper, bare = slice(0, 14), ball()
    bare = replace(bare, albedo=bare.albedo.clone())
    bare.albedo[..., upper, :] = 0.03
    seen, *rest = photographed(bare, coloured(1.0, 1.0, 1.0))
    seen.photo[..., upper, :] += torch.tensor([0.006, 0.006, 0.036])[:, None, None] * seen.person[..., upper, :]
    assert 0.85 < red_over_blue(explain_source_light(seen, *rest)) < 1


def test_hair_says_less_of_the_light_than_skin_does():
    """It is bluer than is believed."""
    upper, bare = slice(0, 14), ball()
    bare.parsing[0, HAIR, upper] = bare.parsing[0, SKIN, upper]
    bare.parsing[0, SKIN, upper] = 0
    seen, *rest = photographed(bare, coloured(1.0, 1.0, 1.0))
    seen.photo[..., upper, :] *= torch.tensor([0.5, 1.0, 3.0])[:, None, None]
    assert 0.65 < red_over_blue(explain_source_light(seen, *rest)) < 1


def test_a_photo_without_a_person_keeps_the_guess():
    surface = ball()
    nobody = replace(surface, photo=surface.albedo, person=0 * surface.person, parsing=0 * surface.parsing)
    reflector, relief = stages.reflector(ReflectionTable(), nobody), stages.march(nobody, 16)
    torch.testing.assert_close(explain_source_light(nobody, reflector, relief), torch.ones(1, 16, 32, 3))


def test_gloss_in_an_orange_light_is_orange():
    """White gloss taken off the photo would take most of its blue, and leave a far redder light."""
    assert abs(red_over_blue(explained(coloured(1.6, 1.0, 0.45))) / (1.6 / 0.45) - 1) < 0.15


def test_what_hardly_shows_of_an_orange_light_is_orange_too():
    """Left white, it would be mirrored by a nose, whose skin would then pass for yellow."""
    assert red_over_blue(explained(coloured(1.6, 1.0, 0.45)), BEHIND) > 1.8


@pytest.mark.parametrize("channels", [3, 1])
def test_what_is_blown_out_makes_no_light_brighter(channels):
    surface, reflector, relief = photographed(ball(), coloured(1.0, 1.0, 1.0))
    blown = surface.photo.clone()
    blown[:, :channels, 8:24, 20:28] = 1.0
    clean, found = (explain_source_light(one, reflector, relief) for one in (surface, replace(surface, photo=blown)))
    assert float((found - clean).abs().max()) < 0.1


def test_the_light_of_a_face_that_is_painted_blue_is_as_white_as_neck_and_hair_are_seen_in():
    bare = ball()
    person, face, neck, hair = bare.person[0, 0], slice(10, 22), slice(22, SIZE), slice(0, 10)
    bare.parsing[:, SKIN] = 0
    for label, rows in ((SKIN, face), (NECK, neck), (HAIR, hair)):
        bare.parsing[0, label, rows] = person[rows]
    believed = bare.albedo.clone()
    believed[..., hair, :] = torch.tensor([0.12, 0.08, 0.06])[:, None, None]
    painted = believed.clone()
    painted[..., face, :] = torch.tensor([0.1, 0.2, 0.6])[:, None, None]
    seen, *rest = photographed(replace(bare, albedo=painted), coloured(1.0, 1.0, 1.0))
    assert abs(red_over_blue(explain_source_light(replace(seen, albedo=believed), *rest)) - 1) < 0.15


@pytest.mark.parametrize("level", [0.15, 0.4])
def test_in_a_dim_light_what_hardly_shows_of_it_is_as_dim(level):
    light = explained(level * coloured(1.0, 1.0, 1.0))
    assert float(light[:, 5:11, list(BEHIND)].mean()) == pytest.approx(0.8 * level, rel=0.2)
    assert abs(red_over_blue(light) - 1) < 0.03


def test_paint_without_any_blue_that_shines_a_little_gives_a_light_that_is_finite():
    surface, reflector, relief = photographed(ball(), coloured(1.0, 1.0, 1.0))
    painted = surface.albedo.clone()
    painted[:, 2, 12:16] = 0
    found = explain_source_light(replace(surface, albedo=painted), reflector, relief)
    assert torch.isfinite(found).all()
    assert float(found.max()) < 3


def test_a_camera_that_saturates_skin_makes_no_other_level():
    plain, saturated = (float(explained(coloured(1.0, 1.0, 1.0), saturation=one).mean()) for one in (1.0, 1.3))
    assert saturated == pytest.approx(plain, rel=0.1)


@pytest.mark.parametrize("lost", ["a channel", "all"])
@pytest.mark.parametrize("black", [False, True])
def test_a_photo_without_blue_or_any_light_and_black_parts_give_a_light_that_is_finite(lost, black):
    surface, reflector, relief = photographed(ball(), coloured(1.0, 1.0, 1.0))
    surface.photo[:, 2 if lost == "a channel" else slice(None)] = 0
    albedo = surface.albedo.clone()
    if black:
        albedo[..., 10:20, :] = 0
    found = explain_source_light(replace(surface, albedo=albedo), reflector, relief)
    assert torch.isfinite(found).all()
    assert float(found.min()) >= 0


def levels(photo, irradiance=0.5, gloss=0.1, person=None):
    """What `exposure_of_photo` and `level_over_person` make of a photo of a person of albedo 0.4 all over."""
    one = torch.ones(1, 1, SIZE, SIZE)
    person = one if person is None else person
    surface = replace(ball(), photo=photo, albedo=0.4 * one.repeat(1, 3, 1, 1), person=person)
    reflected = torch.cat([irradiance * one.repeat(1, 3, 1, 1), gloss * one.repeat(1, 3, 1, 1)], 1)
    lit = surface.albedo * reflected[:, :3] + reflected[:, 3:]
    return exposure_of_photo(surface, reflected), level_over_person(surface, lit)


def test_a_photo_s_level_is_that_of_most_of_it_and_black_tells_nothing():
    photo = torch.full((1, 3, SIZE, SIZE), 0.6)
    assert levels(photo) == pytest.approx((2.0, 2.0), rel=1e-4)
    photo[..., :13, :] = 0.01
    photo[..., 13:16, :] = 0.9
    assert levels(photo)[0] == pytest.approx(2.0, rel=1e-4)
    photo[..., 16:, :] = 1.0
    assert levels(photo)[0] == pytest.approx(3.0, rel=1e-4)


def test_a_photo_s_level_is_that_of_who_is_surely_there_and_too_few_pixels_tell_none():
    photo, person = torch.full((1, 3, SIZE, SIZE), 0.6), torch.full((1, 1, SIZE, SIZE), 0.4)
    person[..., :7, :7] = 1
    assert levels(photo, person=person) == (1.0, None)
    person[..., 7, 0] = 1
    photo[..., :8, :8] = 0.3
    assert levels(photo, person=person) == pytest.approx((1.0, 1.0), rel=1e-4)


def test_where_nothing_is_lit_or_seen_there_is_no_level():
    photo = torch.full((1, 3, SIZE, SIZE), 0.6)
    assert levels(photo, 0.0, 0.0) == (1.0, None)
    assert levels(torch.ones_like(photo)) == (1.0, None)
    assert levels(0 * photo) == (1.0, 0.0)
