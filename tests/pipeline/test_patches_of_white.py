"""White hair and white collars among skin: each pixel by its own colour, and only where there is some of either."""

import torch

from relight_core.pipeline.per_photo.glare import without_glare
from relight_core.pipeline.per_photo.own_redness import own_redness
from relight_core.pipeline.per_photo.white_collar import with_white_collar
from relight_core.pipeline.per_photo.white_hair import with_white_hair
from relight_core.pipeline.stages import Surface

SIZE, SKIN, LEFT_EYE, LIPS, NECK, HAIR, CLOTH = 24, 1, 4, 8, 9, 10, 13
TONE = torch.tensor([0.5, 0.3, 0.2])[:, None, None]
PINK = torch.tensor([0.7, 0.5, 0.42])[:, None, None]
SCALP, EYES, MOUTH, COLLAR = slice(0, 8), 12, 14, slice(18, SIZE)


def surface(white=COLLAR, level=0.8):
    """A bald head on a neck, of skin but for some rows that are white and were found to be pink."""
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    for label, rows in ((NECK, SCALP), (SKIN, slice(8, 16)), (NECK, slice(16, SIZE))):
        parsing[:, label, rows] = 1
    for label, row in ((LEFT_EYE, EYES), (LIPS, MOUTH)):
        parsing[:, :, row, 4:12] = 0
        parsing[:, label, row, 4:12] = 1
    photo, albedo = TONE.repeat(1, 1, SIZE, SIZE), TONE.repeat(1, 1, SIZE, SIZE)
    photo[:, :, white], albedo[:, :, white] = level, PINK
    one = torch.ones(1, 1, SIZE, SIZE)
    return Surface(0.8 * photo, albedo, one.repeat(1, 3, 1, 1), 0 * one, parsing, one, torch.ones(1, 16, 32, 3))


def collared(seen):
    return with_white_collar(seen.photo, seen.albedo, seen.parsing)


def is_without_collar(seen):
    return collared(seen)[1] is seen.parsing


def test_what_is_white_above_the_mouth_is_no_collar():
    assert is_without_collar(surface(white=SCALP))
    assert not is_without_collar(surface())


def test_a_collar_is_brighter_than_the_lit_side_of_its_face():
    between = surface(level=0.5)
    assert not is_without_collar(between)
    between.photo[:, :, 8:16, :9] *= 1.8
    assert is_without_collar(between)


def test_skin_beside_a_collar_stays_skin_though_it_is_as_bright():
    beside = surface()
    beside.photo[:, :, COLLAR, 18:] = 0.8 * 1.9 * TONE
    albedo, parsing = collared(beside)
    assert parsing[0, CLOTH, COLLAR, :16].min() > 0.9
    assert parsing[0, CLOTH, COLLAR, 20:].max() < 0.05
    torch.testing.assert_close(albedo[..., COLLAR, 20:], beside.albedo[..., COLLAR, 20:])


def test_a_few_bright_pixels_are_no_collar():
    few = surface(white=slice(0, 0))
    few.photo[:, :, 20, 10:13] = 0.64
    assert is_without_collar(few)


def test_a_bald_spot_in_white_hair_stays_bald():
    spotted = surface(white=SCALP)
    spotted.photo[:, :, SCALP, 18:] = 0.8 * TONE
    after = with_white_hair(spotted)
    assert after.parsing[0, HAIR, SCALP, :18].min() > 0.9
    assert after.parsing[0, HAIR, SCALP, 18:].max() < 0.05


def test_a_head_whose_scalp_is_not_seen_is_left_as_it_is():
    covered = surface(white=SCALP)
    covered.parsing[:, NECK, SCALP], covered.parsing[:, HAIR, SCALP] = 0, 1
    assert with_white_hair(covered) is covered


def test_a_rim_along_cloth_beside_skin_is_no_glare():
    plain = surface(white=slice(0, 0))
    plain.photo[:, :, 4:6], plain.albedo[:, :, 4:6] = 0.95, 0.6
    skin = torch.zeros(1, 1, SIZE, SIZE)
    skin[..., :12] = 1
    after = without_glare(plain, torch.full_like(skin, 0.8), skin).albedo
    torch.testing.assert_close(after[..., 12:], plain.albedo[..., 12:])
    assert after[0, 0, 4:6, :12].max() < 0.58


def test_where_no_skin_is_seen_none_is_red_by_itself():
    seen, none = surface(), torch.zeros(1, 1, SIZE, SIZE)
    assert own_redness(seen, torch.zeros_like(seen.photo), none).max() == 0
