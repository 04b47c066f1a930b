"""Light and shadow on skin that the model of a photo missed: they belong to the photo's light, moles to the skin."""

from types import SimpleNamespace

import pytest
import torch

from relight_core.lighting.likeness import likeness
from relight_core.pipeline.per_light.hints import Effects
from relight_core.pipeline.per_light.residual import add_residual, find_residual
from relight_core.pipeline.stages import Composed

SIZE, SKIN, LIPS, HAIR, CLOTH = 100, 1, 8, 10, 13
FLAT = Composed(*2 * (torch.full((1, 3, SIZE, SIZE), 0.2),))


def lamp(column):
    light = torch.full((1, 16, 32, 3), 0.005)
    light[:, 8, column] = 20.0
    return light


def in_light(photo, light, skin=(range(SIZE),), strength=1.0, rest=CLOTH):
    """Row 50 of a photo of skin in some columns and cloth elsewhere, of which the model sees nothing, in another light.

    Args:
        strength: of that light, which falls on all of it alike.
        rest: what is there instead of cloth.
    """
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, rest] = 1
    for columns in skin:
        parsing[:, SKIN, :, columns], parsing[:, rest, :, columns] = 1, 0
    return relit(photo, parsing, light, strength)[1, 50]


def relit(photo, parsing, light, strength=1.0, albedo=None, model=FLAT):
    """A photo, of which the model sees nothing unless told, in another light, (3, S, S)."""
    person = torch.ones_like(photo[:, :1])
    ahead = torch.tensor([0.0, 0, 1])[None, :, None, None].expand_as(photo)
    albedo = photo if albedo is None else albedo
    seen = SimpleNamespace(photo=photo, albedo=albedo, normal=ahead, person=person, parsing=parsing)
    residual = find_residual(seen, photo, lamp(2), lambda own: model)
    none = torch.zeros(1, 1, SIZE, SIZE)
    lit = Composed(strength * FLAT.image, strength * FLAT.plain)
    image, _ = add_residual(residual, lit, Effects(none, none), light)
    return image[0] * residual.level


def half_shaded(brighter=0.2, darker=0.12):
    photo = torch.full((1, 3, SIZE, SIZE), brighter)
    photo[..., 50:] = darker
    return photo


def test_a_shadow_that_the_model_missed_stays_in_the_photos_light_and_fades_in_others():
    contrasts = [float((row[30] / row[70]).log()) for row in (in_light(half_shaded(), lamp(c)) for c in (2, 3, 18))]
    assert 0.50 < contrasts[0] < 0.52
    assert contrasts[0] > contrasts[1] > contrasts[2]
    assert contrasts[2] < 0.05


def test_no_line_is_left_where_its_edge_was():
    for column in (3, 18):
        row = in_light(half_shaded(), lamp(column), strength=3.0)
        assert row[40:60].max() <= row[30] * 1.005
        assert row[40:60].min() >= row[70] * 0.995


@pytest.mark.parametrize(("around", "within", "beside"), [(0.2, 0.12, 30), (0.12, 0.2, 70)])
def test_no_dot_is_left_where_its_corner_was(around, within, beside):
    photo = half_shaded(around, within)
    photo[..., :50, :] = around
    row = in_light(photo, lamp(18))
    assert abs(float((row[beside] / row[50]).log())) < 0.05


def test_a_mole_in_it_stays():
    photo = half_shaded()
    photo[..., 49:52, 80:82] = 0.06
    row = in_light(photo, lamp(18))
    assert row[80] < 0.6 * row[70]


def test_skin_that_is_brighter_than_its_model_as_a_whole_stays_so():
    photo = half_shaded(0.24, 0.16)
    own, other = (in_light(photo, lamp(column), skin=(range(50),)) for column in (2, 18))
    assert abs(float((own[20] / own[80]).log()) - 0.405) < 0.01
    assert float((other[20] / other[80]).log()) > 0.35


def test_it_fades_by_the_square_of_what_the_lights_share():
    row, shared = in_light(half_shaded(0.2, 0.15), lamp(4)), likeness(lamp(2), lamp(4))
    assert 0.3 < shared < 0.8
    assert abs(float((row[30] / row[70]).log()) - 0.288 * shared**2) < 0.005


def test_much_of_it_fades_by_a_higher_power_since_the_photos_light_is_not_what_it_seems():
    shared, kept = likeness(lamp(2), lamp(3)), []
    assert 0.7 < shared < 0.8
    for darker in (0.16, 0.11, 0.08, 0.07):
        photo = half_shaded(0.2, darker)
        photo[..., 50:75] = 0.2
        own, other = (in_light(photo, lamp(column)) for column in (2, 3))
        kept.append(float((other[30] / other[90]).log() / (own[30] / own[90]).log()))
    assert abs(kept[0] - shared**2) < 0.01
    assert kept[0] - 0.1 > kept[1] > kept[2] + 0.1
    assert abs(kept[2] - shared**8) < 0.01
    assert abs(kept[3] - shared**8) < 0.01


def test_cloth_in_such_shadows_loses_them_too_but_no_pattern_and_dark_cloth_beside_lit_skin_stays_dark():
    photo, skin = half_shaded(0.2, 0.06), (range(50), range(75, 100))
    photo[..., 50:60] = photo[..., 90:] = 0.2
    photo[..., 65:67] = 0.03
    own, other = (in_light(photo, lamp(column), skin) for column in (2, 18))
    assert float((own[55] / own[70]).log()) > 1.1
    assert abs(float((other[55] / other[70]).log())) < 0.05
    assert float((other[70] / other[65]).log()) > 0.6
    assert abs(float((other[76] / other[85]).log())) < 0.05
    photo[..., 75:] = 0.2
    beside_lit_skin = in_light(photo, lamp(18), skin)
    assert float((beside_lit_skin[55] / beside_lit_skin[70]).log()) > 1.1


@pytest.mark.parametrize(("darker", "most", "least"), [(0.13, 1.0, 0.99), (0.095, 0.8, 0.3), (0.07, 0.1, -0.05)])
def test_the_more_is_missed_of_skin_the_less_of_a_broad_pattern_is_cloths_own(darker, most, least):
    photo, skin = half_shaded(0.2, darker), (range(50), range(75, 100))
    photo[..., 50:60] = photo[..., 75:80] = 0.2
    photo[..., 60:75] = 0.06
    own, other = (in_light(photo, lamp(column), skin) for column in (2, 18))
    assert least <= float((other[55] / other[67]).log() / (own[55] / own[67]).log()) <= most


def test_hair_in_such_shadows_loses_them_too_and_its_glare_once():
    photo, skin = half_shaded(0.2, 0.06), (range(50), range(75, 100))
    photo[..., 50:60] = photo[..., 90:] = 0.2
    photo[..., 66:72] = 0.5
    row = in_light(photo, lamp(18), skin, 3.0, HAIR)
    for column in (63, 69):
        assert abs(float((row[55] / row[column]).log())) < 0.1


def test_glare_fades_once_and_not_as_missed_light_too():
    row = in_light(half_shaded(0.5, 0.2), lamp(18))
    assert row[30] > 0.99 * row[70]


def test_glare_says_nothing_of_how_much_else_is_missed():
    photo, shared = half_shaded(0.2, 0.15), likeness(lamp(2), lamp(3))
    photo[..., 75:] = 0.5
    own, other = (in_light(photo, lamp(column)) for column in (2, 3))
    assert abs(float((other[30] / other[60]).log() / (own[30] / own[60]).log()) - shared**2) < 0.02


def test_a_strip_of_skin_between_cloth_is_compared_with_skin_alone():
    photo, skin = torch.full((1, 3, SIZE, SIZE), 0.4), (range(50), range(80, 82))
    for columns in skin:
        photo[..., columns] = 0.2
    row = in_light(photo, lamp(18), skin)
    assert abs(float((row[80] / row[30]).log())) < 0.03


def half_coloured(red, green, blue):
    """A grey photo of a face whose right part has a colour, with lips within it, and its parsing."""
    photo = torch.full((1, 3, SIZE, SIZE), 0.2)
    photo[..., 60:] = torch.tensor((red, green, blue))[:, None, None]
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, SKIN] = 1
    parsing[:, SKIN, 46:54, 76:84], parsing[:, LIPS, 46:54, 76:84] = 0, 1
    return photo, parsing


def test_the_colour_of_a_lamp_that_the_model_missed_fades_in_others_but_no_flush_and_no_spot():
    photo, parsing = half_coloured(0.14, 0.2, 0.28)
    red, flush = (torch.tensor(colour)[:, None, None] for colour in ((0.28, 0.14, 0.14), (0.21, 0.195, 0.195)))
    known_lamp = FLAT.image.clone()
    known_lamp[..., :20] = photo[..., :20] = torch.tensor((0.8, 0.2, 0.05))[:, None, None]
    photo[..., 20:22, 40:42], photo[..., 80:, 60:] = red, flush
    model = {"albedo": FLAT.image, "model": Composed(known_lamp, known_lamp)}
    own, other = (relit(photo, parsing, lamp(column), **model) for column in (2, 18))
    for row in (20, 50):
        assert abs(float((own[2, row, 80] / own[0, row, 80]).log()) - 0.693) < 0.01
        assert abs(float((other[2, row, 80] / other[0, row, 80]).log())) < 0.05
    assert float((other[0, 20, 40] / other[1, 20, 40]).log()) > 0.6
    assert float((other[0, 95, 80] / other[1, 95, 80]).log()) > 0.07


@pytest.mark.parametrize("tone", [(1.0, 1.0, 1.0), (1.1, 1.0, 0.8)])
def test_with_a_lamps_colour_goes_neither_brightness_nor_the_tone_of_all_skin_nor_the_colour_of_cloth(tone):
    photo, parsing = half_coloured(0.14, 0.2, 0.28)
    parsing[:, SKIN, 90:], parsing[:, CLOTH, 90:] = 0, 1
    known_lamp = FLAT.image.clone()
    known_lamp[..., :20] = photo[..., :20] = torch.tensor((0.8, 0.2, 0.05))[:, None, None]
    known_lamp[..., 60:80, 60:] *= 0.1
    photo[..., 60:80, 60:] *= 0.1
    photo *= torch.tensor(tone)[:, None, None]
    model = {"albedo": FLAT.image, "model": Composed(known_lamp, known_lamp)}
    other, as_in_shade = (relit(photo, parsing, lamp(18), strength, **model) for strength in (1.0, 0.1))
    lit, shaded, plain, cloth = other[:, 20, 80], as_in_shade[:, 70, 80], other[:, 20, 40], other[:, 90, 80]
    torch.testing.assert_close(lit, plain, rtol=0.02, atol=0)
    torch.testing.assert_close(shaded / shaded[1], torch.ones(3), rtol=0.1, atol=0)
    assert abs(float((cloth[2] / cloth[0] / (plain[2] / plain[0])).log()) - 0.693) < 0.01


@pytest.mark.parametrize("light", [(1.0, 1.0, 1.0), (1.6, 0.9, 0.4)])
def test_paint_in_a_light_of_one_colour_stays(light):
    photo, parsing = half_coloured(0.14, 0.2, 0.28)
    lit = torch.tensor(light)[:, None, None] * FLAT.image
    photo = torch.tensor(light)[:, None, None] * photo
    other = relit(photo, parsing, lamp(18), albedo=FLAT.image, model=Composed(lit, lit))
    assert float((other[2, 20, 80] / other[0, 20, 80]).log()) > 0.65


@pytest.mark.parametrize("strength", [1.0, 0.1])
@pytest.mark.parametrize("shaded_from", [60, 40])
def test_the_skys_colour_fades_with_shadows_that_the_model_missed_and_skin_has_the_tone_of_its_lit_part(
    shaded_from, strength
):
    photo, parsing = half_coloured(0.2, 0.2, 0.2)
    photo *= torch.tensor((1.36, 1.0, 0.76))[:, None, None]
    photo[..., shaded_from:] *= torch.tensor((0.38, 0.45, 0.55))[:, None, None]
    parsing[:, SKIN, 80:], parsing[:, CLOTH, 80:], photo[..., 80:, :] = 0, 1, 0.8
    albedo = torch.tensor((1.3, 1.0, 0.8))[:, None, None] * FLAT.image
    other = relit(photo, parsing, lamp(18), strength, albedo=albedo, model=Composed(albedo, FLAT.image))
    for row in (20, 50):
        for column in (20, 80):
            assert abs(float((other[2, row, column] / other[0, row, column]).log()) + 0.096) < 0.03


@pytest.mark.parametrize(("apart", "least", "most"), [(0.2, 0.65, 0.72), (0.6, 0.2, 0.5), (1.0, -0.02, 0.1)])
def test_paint_stays_less_and_less_the_farther_apart_the_colours_of_the_photos_light_are(apart, least, most):
    """By the logs of what the model knows of them on a fifth of the skin."""
    photo, parsing = half_coloured(0.14, 0.2, 0.28)
    known_lamp = FLAT.image.clone()
    tint = 0.2 * torch.exp(torch.tensor((apart, 0.0, -apart)))[:, None, None]
    known_lamp[..., :20] = photo[..., :20] = tint
    model = {"albedo": FLAT.image, "model": Composed(known_lamp, known_lamp)}
    other = relit(photo, parsing, lamp(18), **model)
    assert least < float((other[2, 20, 80] / other[0, 20, 80]).log()) < most
