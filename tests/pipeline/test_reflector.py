"""What of a light a surface gives back, by what it is made of."""

import pytest
import torch

from relight_core.lighting.reflection import ReflectionTable
from relight_core.pipeline.stages import Surface, reflect, reflector

SIZE, SKIN, RIGHT_EYE, NECK, HAIR, CLOTH = 16, 1, 5, 9, 10, 13


def surface_of(label, albedo):
    """A wall that faces the camera, all of one kind and colour."""
    one = torch.ones(1, 1, SIZE, SIZE)
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, label] = 1
    normal = torch.cat([0 * one, 0 * one, one], 1)
    colour = (albedo * one).repeat(1, 3, 1, 1)
    return Surface(colour, colour, normal, 0 * one, parsing, one, torch.ones(1, 16, 32, 3))


def reflected(label, albedo, **how):
    """Irradiance and gloss under light from everywhere."""
    both = reflect(reflector(ReflectionTable(), surface_of(label, albedo), **how), torch.ones(1, 16, 32, 3))
    return both[:, :3].mean().item(), both[:, 3:].mean().item()


def test_black_cloth_taken_for_a_neck_hardly_mirrors_and_dark_skin_does():
    light, skin_gloss = reflected(SKIN, 0.4)
    assert reflected(NECK, 0.06) == pytest.approx((light, skin_gloss), rel=1e-4)
    black_light, black_gloss = reflected(NECK, 0.015)
    assert black_light == pytest.approx(light, rel=1e-4)
    assert 0 < black_gloss < 0.1 * skin_gloss
    assert black_gloss < reflected(NECK, 0.03)[1] < skin_gloss


def beside_a_face(label, albedo, fairness):
    """Gloss, beside the skin's, of what lies beside a face of an albedo."""
    surface = surface_of(label, albedo)
    surface.parsing[0, :, : SIZE // 2], surface.parsing[0, SKIN, : SIZE // 2] = 0, 1
    surface.albedo[..., : SIZE // 2, :] = fairness
    gloss = reflect(reflector(ReflectionTable(), surface), torch.ones(1, 16, 32, 3))[0, 3:]
    return (gloss[:, -1].mean() / gloss[:, 0].mean()).item()


def test_a_neck_far_darker_than_its_fair_face_is_a_collar_and_hardly_mirrors():
    assert beside_a_face(NECK, 0.05, fairness=0.4) < 0.1
    assert beside_a_face(NECK, 0.3, fairness=0.4) == pytest.approx(1, rel=1e-4)
    assert 0.2 < beside_a_face(NECK, 0.23, fairness=0.4) < 0.8
    assert beside_a_face(NECK, 0.075, fairness=0.1) == pytest.approx(1, rel=1e-4)
    assert beside_a_face(NECK, 0.05, fairness=0.06) == pytest.approx(1, rel=1e-4)


def with_a_beard(albedo, fairness):
    """Gloss, beside the skin's, of the lowest quarter of a face, of which the parsing takes all for skin."""
    surface = surface_of(SKIN, fairness)
    surface.albedo[..., 3 * SIZE // 4 :, :] = albedo
    gloss = reflect(reflector(ReflectionTable(), surface), torch.ones(1, 16, 32, 3))[0, 3:]
    return (gloss[:, -1].mean() / gloss[:, 0].mean()).item()


def test_a_beard_that_passes_for_skin_hardly_mirrors_and_a_flush_does():
    assert with_a_beard(0.12, fairness=0.3) < 0.15
    assert 0.2 < with_a_beard(0.17, fairness=0.3) < 0.8
    assert with_a_beard(0.25, fairness=0.3) == pytest.approx(1, rel=1e-4)
    assert with_a_beard(0.046, fairness=0.06) == pytest.approx(1, rel=1e-4)


def test_dark_hair_beside_a_fair_face_is_duller_than_brown_hair():
    assert beside_a_face(HAIR, 0.04, fairness=0.4) < 0.2 * beside_a_face(HAIR, 0.1, fairness=0.4)
    assert beside_a_face(RIGHT_EYE, 0.05, fairness=0.4) == pytest.approx(beside_a_face(RIGHT_EYE, 0.4, fairness=0.4))


def test_as_rendered_black_has_the_gloss_of_what_it_is():
    assert reflected(NECK, 0.015, black_is_dull=False) == reflected(SKIN, 0.4)
    assert reflected(CLOTH, 0.015, black_is_dull=False) == reflected(CLOTH, 0.4)


def test_cloth_is_duller_than_skin():
    assert reflected(CLOTH, 0.4)[1] < 0.2 * reflected(SKIN, 0.4)[1]


def test_a_flat_eye_gets_no_light_thrown_back():
    assert reflected(RIGHT_EYE, 0.4)[0] == pytest.approx(reflected(SKIN, 0.4)[0], rel=1e-4)


def test_a_highlight_on_a_sharp_ridge_is_wider_than_a_pixel_and_as_bright_in_all():
    """A gable along the middle whose ridge alone mirrors the lamp."""
    surface = surface_of(SKIN, 0.4)
    surface.normal[0, 0], surface.normal[0, 2] = -0.8, 0.6
    surface.normal[0, 0, :, SIZE // 2 :] = 0.8
    surface.normal[0, 0, :, SIZE // 2], surface.normal[0, 2, :, SIZE // 2] = 0.0, 1.0
    light = torch.zeros(1, 16, 32, 3)
    light[:, 7:9, [0, -1]] = 20.0
    gloss = reflect(reflector(ReflectionTable(), surface), light)[0, 3, 8]
    alone = ReflectionTable()(light, surface.normal)[0, 3, 8]
    assert gloss.max() < 0.5 * alone.max()
    assert gloss[SIZE // 2 - 1] > 5 * alone[SIZE // 2 - 1]
    assert float(gloss.sum()) == pytest.approx(float(alone.sum()), rel=0.02)
