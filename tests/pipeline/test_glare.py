"""A bright rim on skin, which a light from behind drew there."""

import torch

from relight_core.pipeline.per_photo.glare import without_glare
from relight_core.pipeline.stages import Surface

SIZE, SKIN, CLOTH = 64, 1, 13
BROWN = torch.tensor([0.4, 0.25, 0.16])[None, :, None, None]
RIM = slice(48, 52)


def face(albedo, photo, label=SKIN):
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, label] = 1
    one = torch.ones(1, 1, SIZE, SIZE)
    normal = torch.zeros(1, 3, SIZE, SIZE)
    normal[:, 2] = 1
    return Surface(photo, albedo, normal, 0 * one, parsing, one, torch.ones(1, 16, 32, 3))


def with_rim(image, rim):
    image = image.expand(1, 3, SIZE, SIZE).clone()
    image[..., RIM] = rim
    return image


def cleaned(albedo, photo, shading=0.5, skin=1.0):
    one = torch.ones(1, 1, SIZE, SIZE)
    return without_glare(face(albedo, photo), shading * one, skin * one).albedo


def test_a_rim_gets_the_colour_of_the_skin_around_it():
    found = cleaned(with_rim(BROWN, 0.6), with_rim(0.5 * BROWN, 0.95))
    torch.testing.assert_close(found, BROWN.expand(1, 3, SIZE, SIZE), atol=0.02, rtol=0)


def test_what_is_no_skin_keeps_its_rim():
    albedo = with_rim(BROWN, 0.6)
    torch.testing.assert_close(cleaned(albedo, with_rim(0.5 * BROWN, 0.95), skin=0.5), albedo)


def test_pale_skin_that_its_albedo_explains_stays():
    albedo = with_rim(BROWN, 0.6)
    torch.testing.assert_close(cleaned(albedo, 0.5 * albedo), albedo)


def test_paler_skin_that_a_stronger_light_explains_stays():
    albedo, shading = with_rim(BROWN, BROWN * 1.3), torch.full((1, 1, SIZE, SIZE), 0.5)
    shading[..., RIM] = 1.3
    torch.testing.assert_close(cleaned(albedo, shading * albedo, shading), albedo)


def test_a_rim_beside_cloth_gets_nothing_of_its_colour():
    albedo, photo, skin = with_rim(BROWN, 0.6), with_rim(0.5 * BROWN, 0.95), torch.ones(1, 1, SIZE, SIZE)
    for image, cloth in ((albedo, 0.4), (photo, 0.2)):
        image[..., RIM.stop :] = torch.tensor([0.1, 0.1, 1.0])[None, :, None, None] * cloth
    skin[..., RIM.stop :] = 0
    found = cleaned(albedo, photo, skin=skin)[..., RIM]
    torch.testing.assert_close(found, BROWN.expand_as(found), atol=0.02, rtol=0)


def test_a_face_that_is_brighter_than_all_the_rest_is_no_glare():
    albedo, skin = with_rim(BROWN, BROWN * 1.3), torch.zeros(1, 1, SIZE, SIZE)
    skin[..., 40:] = 1
    photo = 0.5 * albedo
    photo[..., :40] *= 0.2
    torch.testing.assert_close(cleaned(albedo, photo, skin=skin), albedo)


def test_skin_that_is_only_thought_to_be_in_shadow_stays():
    albedo, shading = with_rim(BROWN, BROWN * 1.2), torch.full((1, 1, SIZE, SIZE), 0.5)
    shading[..., RIM] = 0.1
    torch.testing.assert_close(cleaned(albedo, 0.5 * albedo, shading), albedo)


def test_a_rim_that_has_left_nothing_in_the_albedo_changes_nothing():
    albedo = BROWN.expand(1, 3, SIZE, SIZE)
    torch.testing.assert_close(cleaned(albedo, with_rim(0.5 * BROWN, 0.95)), albedo, atol=1e-4, rtol=0)


def test_black_and_blown_out_photos_stay_finite():
    for value in (0.0, 1.0):
        image = torch.full((1, 3, SIZE, SIZE), value)
        for shading in (0.0, 1e4):
            found = cleaned(image, image, shading)
            assert torch.isfinite(found).all()
            assert 0 <= float(found.min()) <= float(found.max()) <= 1


def test_glare_makes_no_skin_paler_than_it_was():
    albedo = with_rim(BROWN, 0.5 * BROWN)
    torch.testing.assert_close(cleaned(albedo, with_rim(0.5 * BROWN, 0.95)), albedo)
