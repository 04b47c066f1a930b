"""Paint on a face as albedo: of its own colour in whatever light it was seen, and nothing else of the person."""

import pytest
import torch

from relight_core.pipeline.per_photo.face_paint import face_paint, with_paint
from relight_core.pipeline.stages import Surface

SIZE, SKIN, NOSE, NECK, HAIR = 48, 1, 6, 9, 10
BANDS = {HAIR: slice(0, 16), SKIN: slice(16, 32), NECK: slice(32, SIZE)}
TONE, BROWN, BLUE = (0.4, 0.25, 0.18), (0.12, 0.08, 0.06), (0.08, 0.15, 0.4)
LUMINANCE = torch.tensor([0.2126, 0.7152, 0.0722])[None, :, None, None]


def head(face=BLUE, neck=TONE, hair=BROWN, light=(1.0, 1.0, 1.0)):
    """Bands of hair, face and neck that a photo shows in a light; their albedo is of plain skin below hair."""
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    photo, albedo = torch.zeros(1, 3, SIZE, SIZE), torch.zeros(1, 3, SIZE, SIZE)
    for label, shown, own in ((HAIR, hair, BROWN), (SKIN, face, TONE), (NECK, neck, TONE)):
        parsing[:, label, BANDS[label]] = 1
        photo[..., BANDS[label], :] = (torch.tensor(shown) * torch.tensor(light))[:, None, None]
        albedo[..., BANDS[label], :] = torch.tensor(own)[:, None, None]
    one = torch.ones(1, 1, SIZE, SIZE)
    return Surface(photo, albedo, one.repeat(1, 3, 1, 1), 0 * one, parsing, one, torch.ones(1, 16, 32, 3))


@pytest.mark.parametrize("light", [(1.0, 1.0, 1.0), (1.0, 0.8, 0.6), (0.5, 0.5, 0.5)])
def test_paint_has_its_own_colour_whatever_light_it_was_seen_in_and_the_brightness_it_was_found_to_have(light):
    before = head(light=light)
    after = with_paint(before).albedo
    red, green, blue = after[0, :, 24, 24].tolist()
    assert (red / green, blue / green) == pytest.approx((0.08 / 0.15, 0.4 / 0.15), rel=0.01)
    torch.testing.assert_close((after * LUMINANCE).sum(1), (before.albedo * LUMINANCE).sum(1))
    for label in (HAIR, NECK):
        torch.testing.assert_close(after[..., BANDS[label], :], before.albedo[..., BANDS[label], :])


def test_without_paint_nothing_changes():
    plain = head(face=TONE)
    assert with_paint(plain) is plain


def test_a_nose_is_painted_with_its_face():
    nosed = head()
    nosed.parsing[:, SKIN, 20:28, 20:28], nosed.parsing[:, NOSE, 20:28, 20:28] = 0, 1
    assert face_paint(nosed)[..., BANDS[SKIN], :].min() == 1


def test_a_face_of_its_hair_s_colour_is_in_its_light():
    assert face_paint(head((0.2, 0.2, 0.148), (0.543, 0.2, 0.11), (0.063, 0.06, 0.044))).max() == 0
    assert face_paint(head((0.2, 0.2, 0.148), (0.543, 0.2, 0.11), (0.12, 0.06, 0.044))).max() > 0.1


def test_what_of_a_face_is_nearly_black_or_clipped_has_no_colour_that_tells():
    spotted = head()
    spotted.photo[..., BANDS[SKIN], :8] = torch.tensor((0.01, 0.001, 0.001))[:, None, None]
    spotted.photo[..., BANDS[SKIN], 40:] = torch.tensor((1.0, 0.97, 0.9))[:, None, None]
    assert face_paint(spotted)[..., BANDS[SKIN], :].min() == 1
