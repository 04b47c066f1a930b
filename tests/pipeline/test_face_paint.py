"""A face painted all over in one colour, beside one in a coloured light, on bands of hair, face and neck."""

from types import SimpleNamespace

import pytest
import torch

from relight_core.pipeline.per_light.hints import Effects
from relight_core.pipeline.per_light.residual import add_residual, find_residual
from relight_core.pipeline.per_photo.face_paint import face_paint
from relight_core.pipeline.stages import Composed

SIZE, SKIN, NECK, HAIR = 48, 1, 9, 10
BANDS = {HAIR: slice(0, 16), SKIN: slice(16, 32), NECK: slice(32, SIZE)}
TONE, BROWN, BLUE, GREEN = (0.4, 0.25, 0.18), (0.12, 0.08, 0.06), (0.08, 0.15, 0.4), (0.1, 0.3, 0.08)


def head(face=TONE, neck=TONE, hair=BROWN):
    """A surface that the photo shows in those colours, and that de-lighting takes for plain skin below hair."""
    parsing, photo, albedo = (
        torch.zeros(1, 14, SIZE, SIZE),
        torch.zeros(1, 3, SIZE, SIZE),
        torch.zeros(1, 3, SIZE, SIZE),
    )
    for label, shown, own in ((HAIR, hair, BROWN), (SKIN, face, TONE), (NECK, neck, TONE)):
        parsing[:, label, BANDS[label]] = 1
        photo[..., BANDS[label], :] = torch.tensor(shown)[:, None, None]
        albedo[..., BANDS[label], :] = torch.tensor(own)[:, None, None]
    ahead = torch.tensor([0.0, 0, 1])[None, :, None, None].expand_as(photo)
    return SimpleNamespace(photo=photo, albedo=albedo, normal=ahead, person=0 * photo[:, :1] + 1, parsing=parsing)


def in_light(*light):
    """The colours of a plain head in a coloured light."""
    return [tuple(own * lamp for own, lamp in zip(colour, light, strict=True)) for colour in (TONE, TONE, BROWN)]


@pytest.mark.parametrize("paint", [BLUE, GREEN, (0.6, 0.05, 0.04)])
def test_a_face_of_no_skins_colour_between_hair_and_a_neck_that_have_theirs_is_painted(paint):
    share = face_paint(head(paint))
    assert share[0, 0, BANDS[SKIN]].min() == 1
    assert share[0, 0, BANDS[HAIR]].max() == share[0, 0, BANDS[NECK]].max() == 0


@pytest.mark.parametrize(
    "colours",
    [
        (TONE, TONE, BROWN),
        in_light(0.3, 0.6, 2.0),
        in_light(2.0, 0.4, 0.3),
        (BLUE, TONE, (0.2, 0.05, 0.1)),
        (BLUE, (0.25, 0.25, 0.25), BROWN),
        ((0.32, 0.25, 0.26), (0.4, 0.12, 0.08), (0.4, 0.12, 0.066)),
        ((0.3, 0.25, 0.34), (0.32, 0.25, 0.27), (0.25, 0.2, 0.22)),
    ],
    ids=["plain", "in a blue light", "in a red light", "below purple hair", "above a grey neck", "pale", "bluish"],
)
def test_neither_a_plain_face_nor_one_whose_neck_or_hair_is_in_a_coloured_light_too_is_painted(colours):
    assert face_paint(head(*colours)).max() == 0


def test_a_face_of_several_colours_is_between_lamps_and_a_face_alone_tells_nothing():
    between, alone = head(BLUE), head(BLUE)
    between.photo[..., BANDS[SKIN], :24] = torch.tensor((0.5, 0.1, 0.3))[:, None, None]
    alone.parsing[:, HAIR] = 0
    assert face_paint(between).max() == face_paint(alone).max() == 0


def test_paint_keeps_its_colour_in_another_light():
    seen, light, other = head(BLUE), torch.full((1, 16, 32, 3), 0.01), torch.full((1, 16, 32, 3), 0.01)
    light[:, 8, 2], other[:, 8, 18] = 20.0, 20.0
    residual = find_residual(seen, seen.photo, light, lambda own: Composed(seen.albedo, torch.ones_like(seen.albedo)))
    none, dim = torch.zeros(1, 1, SIZE, SIZE), torch.full_like(seen.albedo, 0.7)
    image, _ = add_residual(residual, Composed(0.7 * seen.albedo, dim), Effects(none, none), other)
    red, _, blue = image[0, :, 24, 24].tolist()
    assert blue / red == pytest.approx(5.0, rel=0.15)
