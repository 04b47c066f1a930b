"""Specular, shadow, their sum and the sliders, on arbitrary surfaces."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
import torch

from relight_core.face.parsing import INDEX
from relight_core.imaging.tensor_colour import grey
from relight_core.lighting.reflection import ReflectionTable
from relight_core.lighting.relief import march_relief
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.networks.specular_shadow import Occlusion, SpecularShadowConfig
from relight_core.pipeline import stages
from relight_core.pipeline.per_light.hints import (
    Effects,
    as_channels,
    doubtful_shadow,
    effects_of,
    estimated_effects,
    explicit_sum,
    hidden_share,
    smooth_gloss,
    specular_shadow_hints,
    with_dull_parts,
)
from relight_core.pipeline.per_light.sliders import move_sliders
from relight_core.pipeline.stages import Composed, Surface

GAINS = (0.0, 0.5, 1.0, 1.5, 2.0)


@pytest.fixture
def scene():
    """Albedo, what the surface reflects unoccluded, and the effects of a random occlusion."""
    torch.manual_seed(0)
    albedo = torch.rand(1, 3, 12, 12)
    reflected = torch.rand(1, 6, 12, 12) * torch.tensor([3.0, 3, 3, 0.5, 0.5, 0.5])[None, :, None, None]
    occlusion = Occlusion(torch.randn(1, 1, 12, 12) * 3, torch.randn(1, 1, 12, 12) * 3)
    return albedo, reflected, effects_of(occlusion, reflected, albedo)


def test_effects_are_not_negative_and_no_larger_than_the_light(scene):
    albedo, reflected, effects = scene
    assert (effects.specular >= 0).all()
    assert (effects.shadow >= 0).all()
    assert (effects.specular <= grey(reflected[:, 3:]) + 1e-6).all()
    assert (effects.shadow <= grey(albedo * reflected[:, :3] + reflected[:, 3:]) + 1e-5).all()


@pytest.mark.parametrize("gain", GAINS)
def test_no_depth_of_shadow_takes_away_what_is_thrown_back_into_it(scene, gain):
    albedo, reflected, effects = scene
    back = torch.rand(1, 3, 12, 12)
    with_it = explicit_sum(albedo, reflected, replace(effects, interreflection=back), 1.0, gain)
    torch.testing.assert_close(with_it, explicit_sum(albedo, reflected, effects, 1.0, gain) + back)


def test_the_shadow_channel_is_what_the_picture_lacks(scene):
    albedo, reflected, _ = scene
    third = torch.full((1, 1, 12, 12), 1 / 3).logit()
    effects = effects_of(Occlusion(third, third), reflected, albedo)
    effects = replace(effects, interreflection=0.1 * albedo * reflected[:, :3])
    shown, picture = as_channels(effects), explicit_sum(albedo, reflected, effects)
    open_to_all_light = albedo * reflected[:, :3] + reflected[:, 3:]
    torch.testing.assert_close(shown.shadow, grey(open_to_all_light - picture), rtol=1e-4, atol=1e-5)
    everything_back = replace(effects, interreflection=open_to_all_light)
    assert as_channels(everything_back).shadow.max() == 0


def test_without_occlusion_there_is_no_shadow_and_all_of_the_gloss(scene):
    albedo, reflected, _ = scene
    never = torch.full((1, 1, 12, 12), -50.0)
    effects = effects_of(Occlusion(never, never), reflected, albedo)
    assert effects.shadow.max() < 1e-6
    torch.testing.assert_close(effects.specular, grey(reflected[:, 3:]))
    torch.testing.assert_close(
        explicit_sum(albedo, reflected, effects),
        albedo * reflected[:, :3] + reflected[:, 3:],
        rtol=1e-4,
        atol=1e-5,
    )


def test_fully_occluded_everything_is_black(scene):
    albedo, reflected, _ = scene
    always = torch.full((1, 1, 12, 12), 50.0)
    effects = effects_of(Occlusion(always, always), reflected, albedo)
    assert explicit_sum(albedo, reflected, effects).max() < 1e-4


def test_the_sum_is_the_paper_s_in_grey(scene):
    """gray(sum) = gray(albedo * irradiance + gloss) - shadow: additive, as the channels are defined."""
    albedo, reflected, effects = scene
    image = explicit_sum(albedo, reflected, effects)
    unshadowed = grey(albedo * reflected[:, :3] + reflected[:, 3:])
    torch.testing.assert_close(grey(image), unshadowed - effects.shadow, rtol=1e-3, atol=2e-3)


def test_shadow_keeps_the_colour_of_the_diffuse_part(scene):
    albedo, reflected, effects = scene
    effects = Effects(torch.zeros_like(effects.specular), effects.shadow)
    reflected = torch.cat([reflected[:, :3], torch.zeros_like(reflected[:, 3:])], 1)
    image, full = explicit_sum(albedo, reflected, effects), albedo * reflected[:, :3]
    ratio = image / full.clamp_min(1e-3)
    lit = full.amin(1, keepdim=True) > 0.05
    assert ((ratio.amax(1, keepdim=True) - ratio.amin(1, keepdim=True))[lit] < 1e-3).all()


@pytest.mark.parametrize(("gain", "left"), [(0.0, 1.0), (0.5, 0.75), (1.0, 0.5), (2.0, 0.25)])
def test_where_half_the_light_is_hidden_a_deeper_shadow_is_not_black(gain, left):
    albedo, reflected = torch.full((1, 3, 2, 2), 0.5), torch.zeros(1, 6, 2, 2)
    reflected[:, :3] = 2
    half = Effects(torch.zeros(1, 1, 2, 2), torch.full((1, 1, 2, 2), 0.5))
    torch.testing.assert_close(explicit_sum(albedo, reflected, half, 1.0, gain), torch.full((1, 3, 2, 2), left))


def test_a_shadow_takes_more_of_one_colour_than_of_another_at_their_odds():
    white, reflected = torch.ones(1, 3, 1, 1), torch.zeros(1, 6, 1, 1)
    reflected[:, :3] = 2
    odds = torch.tensor([0.25, 1.0, 2.5])[None, :, None, None]
    half = Effects(torch.zeros(1, 1, 1, 1), torch.ones(1, 1, 1, 1), odds)
    left = explicit_sum(white, reflected, half).flatten() / 2
    assert float(left @ torch.tensor([0.2126, 0.7152, 0.0722])) == pytest.approx(0.5, abs=1e-3)
    hidden = (1 - left) / left
    assert float(hidden[2] / hidden[0]) == pytest.approx(10, rel=0.05)


def test_a_highlight_of_one_pixel_is_spread_and_even_gloss_stays_even_at_the_border():
    highlight = torch.zeros(1, 1, 5, 5)
    highlight[..., 2, 2] = 9
    around = torch.zeros(1, 1, 5, 5)
    around[..., 1:4, 1:4] = 1
    torch.testing.assert_close(smooth_gloss(highlight), around)
    torch.testing.assert_close(smooth_gloss(torch.ones(1, 1, 5, 5)), torch.ones(1, 1, 5, 5))


@pytest.mark.parametrize("slider", ["specular", "shadow"])
def test_sliders_are_monotone_pixel_by_pixel(scene, slider):
    albedo, reflected, effects = scene
    plain = explicit_sum(albedo, reflected, effects)
    composed = Composed((plain * (0.5 + torch.rand_like(plain))).clamp_min(0), plain)
    parsing = torch.rand(len(albedo), len(INDEX), *albedo.shape[2:])
    sockets = torch.rand(albedo.shape[2:])
    surface = type("Surface", (), {"albedo": albedo, "parsing": parsing, "eye_sockets": sockets})
    images = []
    for gain in GAINS:
        gains = (gain, 1.0) if slider == "specular" else (1.0, gain)
        moved = move_sliders(composed, surface, reflected, effects, *gains)
        images.append(composed.image * moved.kept + moved.added + moved.lifted)
    for one, next_one in zip(images, images[1:], strict=False):
        step = next_one - one if slider == "specular" else one - next_one
        assert step.min() >= -1e-6
        assert step.max() > 1e-3
    torch.testing.assert_close(images[2], composed.image)
    assert all(torch.isfinite(image).all() and (image >= 0).all() for image in images)


def test_hints_of_every_variant():
    reflected, relief = torch.rand(1, 6, 4, 4), torch.rand(1, 1, 4, 4)
    assert specular_shadow_hints(SpecularShadowConfig(), reflected, relief).shape == (1, 3, 4, 4)
    parsing = torch.softmax(torch.rand(1, 14, 4, 4), 1)
    told = SpecularShadowConfig(parsing_classes=14)
    assert specular_shadow_hints(told, reflected, relief, relief, parsing).shape == (1, 18, 4, 4)
    bare = SpecularShadowConfig(per_pixel_light=False, relief_shadow=False)
    assert specular_shadow_hints(bare, reflected, None) is None
    with pytest.raises(ValueError):
        specular_shadow_hints(SpecularShadowConfig(), reflected, None)
    with pytest.raises(ValueError):
        specular_shadow_hints(told, reflected, relief)


def test_the_shadow_network_is_told_of_irradiance_and_gloss_on_curves_that_it_learnt():
    reflected = torch.full((1, 6, 1, 1), 1.0)
    reflected[:, 3:] = 0.25
    told = specular_shadow_hints(SpecularShadowConfig(), reflected, torch.full((1, 1, 1, 1), 0.4))
    assert told.flatten().tolist() == pytest.approx([0.693147, 0.693147, 0.4], abs=1e-5)


def test_relief_behind_the_person_tells_the_shadow_network_nothing():
    reflected, shadow, parsing = torch.rand(1, 6, 4, 4), torch.rand(1, 1, 4, 4), torch.zeros(1, 14, 4, 4)
    parsing[:, 0, :2], parsing[:, 1, 2:] = 1, 1
    config = SpecularShadowConfig(parsing_classes=14)
    one, other = (specular_shadow_hints(config, reflected, shadow, r, parsing) for r in torch.rand(2, 1, 1, 4, 4))
    assert torch.equal(one[:, 0, :2], other[:, 0, :2])
    assert not torch.equal(one[:, 0, 2:], other[:, 0, 2:])


def test_grey_weighs_as_rec709():
    colours = torch.eye(3)[None, :, :, None]
    assert grey(colours).flatten().tolist() == pytest.approx([0.2126, 0.7152, 0.0722])


def test_networks_in_training_are_not_copied():
    bundle = NetworkBundle(BundleConfig.tiny()).eval()
    assert stages.in_precision(bundle, "cuda") is bundle
    ready = bundle.for_inference()
    assert stages.in_precision(ready, "cuda") is ready.rounded()
    assert stages.in_precision(ready, "cuda", "fp32") is ready


def shaded(share_by_network, share_by_relief, diffuse=1.0, gloss=0.2):
    """Effects of a place, so much of whose diffuse light and gloss is hidden."""
    one = torch.ones(1, 1, 1, 1)
    by_relief = None if share_by_relief is None else share_by_relief * one
    return Effects(gloss * (1 - share_by_network) * one, share_by_network * (diffuse + gloss) * one, None, by_relief)


@pytest.mark.parametrize(
    ("by_network", "by_relief", "left"),
    [
        (1.0, 1.0, 0.0),
        (1.0, 0.95, 0.05 * 1.2),
        (0.4, 1.0, 0.0),
        (0.9, 0.7, (0.9 - 0.35) * 1.2),
        (0.9, 0.5, 0.9 * 1.2),
        (0.9, 0.0, 0.9 * 1.2),
        (0.9, None, 0.9 * 1.2),
        (0.0, 1.0, 0.0),
    ],
)
def test_of_a_shadow_what_network_and_relief_are_sure_of_is_not_in_doubt(by_network, by_relief, left):
    one = torch.ones(1, 1, 1, 1)
    assert doubtful_shadow(shaded(by_network, by_relief), one, 0.2 * one, one).item() == pytest.approx(left, abs=1e-5)


def test_gloss_that_the_relief_hides_is_not_in_doubt_where_the_rest_is():
    """Where light grazes a nose from behind, a lamp gives nearly all of the gloss and little else."""
    one = torch.ones(1, 1, 1, 1)
    effects = replace(shaded(0.5, 0.4), specular=0.02 * one, gloss_by_relief=one)
    left = doubtful_shadow(effects, one, 0.2 * one, one).item()
    assert left == pytest.approx(effects.shadow.item() - 0.18, abs=1e-5)


def test_gloss_that_is_hidden_stays_in_doubt_where_only_the_relief_hides_all_other_light():
    one = torch.ones(1, 1, 1, 1)
    effects = replace(shaded(0.2, 1.0), gloss_by_relief=0 * one)
    assert doubtful_shadow(effects, one, 0.2 * one, one).item() == pytest.approx(0.2 * 0.2, abs=1e-5)


def test_no_shadow_takes_more_than_all_of_the_diffuse_light_or_less_than_none():
    one = torch.ones(1, 1, 1, 1)
    shares = [hidden_share(Effects(0.2 * one, depth * one), one, 0.2 * one).item() for depth in (-1.0, 0.3, 5.0)]
    assert shares == pytest.approx([0.0, 0.3, 1.0])
    assert hidden_share(Effects(0 * one, one), 0 * one, 0 * one).item() == 1.0


def test_the_maps_of_an_additive_network_are_gloss_and_shadow_themselves():
    one, config = torch.ones(1, 1, 2, 2), SpecularShadowConfig(4, 3, additive=True)
    effects = estimated_effects(config, Occlusion(shadow=3 * one, gloss=-2 * one), torch.ones(1, 6, 2, 2), one)
    torch.testing.assert_close(effects.shadow, torch.log1p(torch.exp(3 * one)))
    torch.testing.assert_close(effects.specular, torch.log1p(torch.exp(-2 * one)))


def test_what_is_dull_has_less_of_the_gloss_of_skin_and_all_of_the_light():
    reflected = torch.arange(1.0, 7.0)[None, :, None, None].expand(1, 6, 1, 3)
    parsing = torch.zeros(1, len(INDEX), 1, 3)
    parsing[:, INDEX["skin"], :, 0] = parsing[:, INDEX["cloth"], :, 1] = 1
    parsing[:, INDEX["skin"], :, 2] = parsing[:, INDEX["cloth"], :, 2] = 0.5
    dull = with_dull_parts(reflected, parsing)
    torch.testing.assert_close(dull[:, :3], reflected[:, :3])
    skin, cloth, between = (dull[:, 3:] / reflected[:, 3:]).mean((0, 1, 2)).tolist()
    assert skin == 1 > 0.5 > cloth > 0
    assert between == pytest.approx((1 + cloth) / 2)


def test_where_the_relief_is_not_trusted_all_of_a_shadow_is_in_doubt():
    one = torch.ones(1, 1, 1, 1)
    effects = shaded(0.9, 1.0)
    assert doubtful_shadow(effects, one, 0.2 * one, 0 * one).item() == pytest.approx(0.9 * 1.2)


def test_a_place_that_light_surely_does_not_reach_is_composed_as_if_it_faced_away():
    torch.manual_seed(1)
    bundle = NetworkBundle(BundleConfig.tiny())
    bundle.composition.head.weight.data.normal_(0, 0.3)
    one, colour = torch.ones(1, 1, 32, 32), torch.full((1, 3, 32, 32), 0.5)
    normal = torch.zeros_like(colour)
    normal[:, 2] = 1
    parsing = torch.zeros(1, 14, 32, 32)
    parsing[:, 1] = 1  # skin
    surface = Surface(colour, colour, normal, 0 * one, parsing, one, torch.ones(1, 16, 32, 3))

    def composed(irradiance, shadow, by_relief=None):
        reflected = torch.cat([torch.full_like(colour, irradiance), torch.full_like(colour, 0.02)], 1)
        effects = Effects(0.02 * one, shadow * one, None, by_relief)
        return stages.compose(bundle, surface, reflected, effects, surface.source_light).image

    away = composed(0.2, 0.0)
    torch.testing.assert_close(composed(4.2, 2.0, by_relief=one), away, rtol=1e-3, atol=1e-4)
    assert (composed(4.2, 2.0) - away).abs().max() > 0.01


def composed_by(correct, colour):
    """What composition makes of a surface of an explicit sum (3,), of which the network makes `correct` of it, (3,)."""
    one = torch.ones(1, 1, 4, 4)
    albedo = torch.tensor(colour)[None, :, None, None].expand(1, 3, 4, 4)
    parsing = torch.zeros(1, len(INDEX), 4, 4)
    surface = Surface(albedo, albedo, torch.ones_like(albedo), 0 * one, parsing, one, torch.ones(1, 16, 32, 3))
    networks = SimpleNamespace(composition=lambda albedo, normal, specular, shadow, plain, light: correct(plain))
    reflected = torch.cat([torch.ones(1, 3, 4, 4), torch.zeros(1, 3, 4, 4)], 1)
    composed = stages.compose(networks, surface, reflected, Effects(0 * one, 0 * one), surface.source_light)
    torch.testing.assert_close(composed.plain, albedo)
    return composed.image[0, :, 2, 2].tolist()


def test_brown_hair_stays_brown_where_composition_darkens_it():
    def darker(plain):
        return torch.expm1((torch.log1p(20 * plain) - 0.21).clamp_min(0)) / 20

    # By itself this leaves 0.0254, 0.0148 and 0.0003, which is 0.51 of the luminance and 0.02 of the blue.
    relit = composed_by(darker, (0.043, 0.030, 0.012))
    assert relit == pytest.approx([0.0254, 0.51 * 0.030, 0.51 * 0.012], rel=0.01)


def test_what_composition_adds_is_as_the_network_has_it_and_no_channel_loses_by_it():
    assert composed_by(lambda plain: plain + 0.1, (0.2, 0.1, 0.0)) == pytest.approx([0.3, 0.2, 0.1])
    redder = torch.tensor([1.4, 0.95, 1.0])[None, :, None, None]
    assert composed_by(lambda plain: plain * redder, (0.2, 0.1, 0.1)) == pytest.approx([0.28, 0.1, 0.1])


def test_what_composition_blackens_is_black():
    assert composed_by(torch.zeros_like, (0.2, 0.1, 0.0)) == [0, 0, 0]


def test_only_diffuse_light_counts_as_lifted_and_softening_lifts_it_too(scene):
    albedo, reflected, effects = scene
    nobody = torch.zeros(len(albedo), len(INDEX), *albedo.shape[2:])
    surface = type("Surface", (), {"albedo": albedo, "parsing": nobody, "eye_sockets": torch.zeros(albedo.shape[2:])})
    unshadowed = explicit_sum(albedo, reflected, effects, 1.0, 0.0)
    shiny = move_sliders(Composed(unshadowed, unshadowed), surface, reflected, effects, 2.0, 0.0)
    assert shiny.lifted.max() < 1e-6
    assert shiny.added.max() > 0
    plain = explicit_sum(albedo, reflected, effects)
    softer = replace(effects, shadow=0.5 * effects.shadow)
    softened = move_sliders(Composed(plain, plain), surface, reflected, softer, 1.0, 1.0)
    assert softened.lifted.max() > 0
    torch.testing.assert_close(softened.added, torch.zeros_like(plain), atol=1e-6, rtol=0)


def test_without_the_network_a_lamp_that_is_hidden_gives_no_gloss_beside_one_that_is_seen():
    size, one = 32, torch.ones(1, 1, 32, 32)
    normal, relief = torch.zeros(1, 3, size, size), torch.zeros(1, 1, size, size)
    normal[:, 0], normal[:, 2], relief[..., 15:17] = 0.5, 0.75**0.5, 0.5
    key, behind = torch.zeros(2, 1, 16, 32, 3)
    key[:, 7:9, 31], behind[:, 7:9, 22] = 50, 50
    surface = Surface(None, 0.5 * one.expand(1, 3, -1, -1), normal, relief, None, one, None)
    transport, table = march_relief(relief[0, 0], normal[0], one[0, 0]), ReflectionTable()

    def shown(light):
        effects = stages.estimate_effects(None, surface, table(light, normal), transport, light)
        return effects.specular[0, 0, size // 2, 10:14].mean().item()

    assert shown(key + behind) == pytest.approx(shown(key) + shown(behind), rel=0.05)
