"""Gloss by part: hair and cloth are duller than skin, in the truth, in photos of it and in what is looked up."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from synthetic_heads import ball

from relight_core.dataset.lighting.appearance import appear
from relight_core.dataset.samples import channels_of, light_head
from relight_core.lighting.reflection import Gloss
from relight_core.pipeline.per_light.hints import with_dull_parts

BACKGROUND, SKIN, BROWS, EYES, LIPS, NECK, HAIR, HAT, GLASSES, CLOTH = 0, 1, (2, 3), (4, 5), 8, 9, 10, 11, 12, 13
LIGHTS = np.random.default_rng(0).gamma(0.5, 1, (1, 16, 32, 3)).astype(np.float32)


def lit(label, **how):
    head = ball()
    return light_head(replace(head, label=np.full_like(head.label, label)), head.normal, LIGHTS, **how)


def specular(label, **how):
    head = lit(label, **how)
    return channels_of(head, np.full((len(head.normal), 3), 0.3, np.float32), 0)["specular"]


@pytest.mark.parametrize(
    ("label", "share"),
    [
        *((label, 1.0) for label in (SKIN, LIPS, NECK, GLASSES)),
        *((label, 0.5) for label in EYES),
        *((label, 0.4) for label in BROWS),
        *((label, 0.15) for label in (HAIR, HAT)),
        *((BACKGROUND, 0.1), (CLOTH, 0.08)),
    ],
)
def test_each_part_has_its_share_of_the_gloss_of_skin(label, share):
    np.testing.assert_allclose(specular(label), share * specular(SKIN, dull=False), rtol=1e-5, atol=1e-7)


def test_a_ball_of_cloth_is_the_ball_of_skin_less_its_gloss():
    albedo = np.full((len(ball().normal), 3), 0.3, np.float32)
    skin, cloth = (channels_of(lit(label), albedo, 0)["image"] for label in (SKIN, CLOTH))
    lost = (skin - cloth) @ np.float32([0.2126, 0.7152, 0.0722])
    np.testing.assert_allclose(lost, specular(SKIN) - specular(CLOTH), atol=1e-5)


def test_photos_show_hair_from_as_shiny_as_skin_to_duller_than_the_truth():
    hair = lit(HAIR)
    gloss, none = Gloss(0.6, 0.5), None

    def shown(dullness):
        looks = appear(hair.head, hair.normal, LIGHTS, hair.illumination, gloss, none, 0.0, dullness)
        return float(looks.specular.mean())

    assert shown(0.0) == pytest.approx(float(lit(SKIN).illumination.specular.mean()), rel=1e-5)
    assert shown(1.0) == pytest.approx(float(hair.illumination.specular.mean()), rel=1e-5)
    assert shown(2.0) < 0.3 * shown(1.0)


def test_the_table_s_gloss_is_dulled_by_probabilities_and_its_irradiance_is_not():
    reflected = torch.ones(1, 6, 2, 2)
    parsing = torch.zeros(1, 14, 2, 2)
    parsing[:, SKIN], parsing[:, HAIR] = 0.5, 0.5
    dulled = with_dull_parts(reflected, parsing)
    torch.testing.assert_close(dulled[:, :3], reflected[:, :3])
    torch.testing.assert_close(dulled[:, 3:], torch.full((1, 3, 2, 2), 0.575))
