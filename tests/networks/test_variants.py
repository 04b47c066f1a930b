"""The switches behind the paper's ablation: each does what it says, to the inputs, the outputs and the gradient."""

import pytest
import torch

from relight_core.networks.bundle import BundleConfig, NetworkBundle, load_bundle, save_bundle
from relight_core.networks.composition import CompositionConfig, CompositionNetwork
from relight_core.networks.delight import DelightConfig, DelightNetwork
from relight_core.networks.lfm import BottleneckLight, LightModulation, encode_light
from relight_core.networks.specular_shadow import SpecularShadowConfig, SpecularShadowNetwork
from relight_core.pipeline.per_light.hints import estimated_effects

SIZE = 16


pytestmark = pytest.mark.usefixtures("seeded")


def surface():
    toward_camera = torch.tensor([0, 0, 1.0])[:, None, None]
    normal = torch.nn.functional.normalize(torch.randn(1, 3, SIZE, SIZE) + toward_camera, dim=1)
    return torch.rand(1, 3, SIZE, SIZE), normal, torch.rand(1, 1, SIZE, SIZE), torch.rand(1, 1, SIZE, SIZE)


def count(network, kind):
    return sum(isinstance(module, kind) for module in network.modules())


def composition(**switches):
    return CompositionNetwork(CompositionConfig(width=4, levels=3, explicit_sum=False, **switches)).eval()


def plain_specular_shadow(**switches):
    config = SpecularShadowConfig(width=4, levels=3, per_pixel_light=False, relief_shadow=False, **switches)
    return SpecularShadowNetwork(config).eval()


@pytest.mark.parametrize("make", [composition, plain_specular_shadow])
def test_without_lfm_the_light_enters_at_the_bottleneck_alone(make):
    modulated, plain = make(), make(modulated=False)
    assert (count(modulated, LightModulation), count(modulated, BottleneckLight)) == (2, 0)
    assert (count(plain, LightModulation), count(plain, BottleneckLight)) == (0, 1)
    features = plain.encoder(torch.rand(1, plain.config.inputs, SIZE, SIZE))
    seen = []
    plain.bottleneck.register_forward_hook(lambda _, given, __: seen.append(given[0].shape))
    plain.bottleneck(features[-1], encode_light(torch.rand(1, 16, 32, 3)))
    assert seen == [(1, 16, SIZE // 4, SIZE // 4)]


def test_the_tiled_light_is_the_same_everywhere():
    block = BottleneckLight(5).eval()
    tiled = []
    block.blend.register_forward_pre_hook(lambda _, given: tiled.append(given[0][:, 5:]))
    block(torch.rand(2, 5, 3, 4), encode_light(torch.rand(2, 16, 32, 3)))
    assert tiled[0].shape == (2, 128, 3, 4)
    assert torch.equal(tiled[0], tiled[0][:, :, :1, :1].expand(-1, -1, 3, 4))
    assert not torch.equal(tiled[0][0], tiled[0][1])


@pytest.mark.parametrize("modulated", [True, False])
def test_the_image_depends_on_the_light_and_the_gradient_reaches_it(modulated):
    network = composition(modulated=modulated)
    torch.nn.init.constant_(network.head.bias, 1.0)
    albedo, normal, specular, shadow = surface()
    light = torch.rand(1, 16, 32, 3, requires_grad=True)
    image = network(albedo, normal, specular, shadow, albedo, light)
    image.sum().backward()
    assert light.grad.abs().sum() > 0
    other = network(albedo, normal, specular, shadow, albedo, light.detach() * 4)
    assert not torch.allclose(image, other, atol=1e-5)


@pytest.mark.parametrize("effects", [True, False])
def test_specular_and_shadow_count_only_as_inputs(effects):
    network = composition(effects=effects)
    torch.nn.init.constant_(network.head.bias, 1.0)
    albedo, normal, specular, shadow = surface()
    light = torch.rand(1, 16, 32, 3)
    with torch.no_grad():
        one = network(albedo, normal, specular, shadow, albedo, light)
        other = network(albedo, normal, specular * 3, shadow * 0, albedo, light)
    assert torch.equal(one, other) is not effects


def test_an_additive_network_s_maps_owe_nothing_to_albedo_or_looked_up_light():
    network = plain_specular_shadow(additive=True)
    _, normal, _, _ = surface()
    with torch.no_grad():
        estimate = network(normal, torch.rand(1, 16, 32, 3))
        maps = [
            estimated_effects(network.config, estimate, reflected, albedo)
            for reflected, albedo in (
                (torch.zeros(1, 6, SIZE, SIZE), torch.zeros(1, 3, SIZE, SIZE)),
                (torch.ones(1, 6, SIZE, SIZE), torch.ones(1, 3, SIZE, SIZE)),
            )
        ]
    for one, other in ((maps[0].specular, maps[1].specular), (maps[0].shadow, maps[1].shadow)):
        assert torch.equal(one, other)
        assert one.min() >= 0
        assert 0 < one.mean() < 0.2


def test_without_parsing_and_relief_there_are_six_outputs_and_a_light():
    network = DelightNetwork(DelightConfig(width=4, levels=3, classes=0, relief=False)).eval()
    assert network.head.out_channels == 6
    with torch.no_grad():
        found = network(torch.rand(1, 3, SIZE, SIZE))
    assert found.parsing_logits.shape == (1, 0, SIZE, SIZE)
    assert found.relief.shape == (1, 1, SIZE, SIZE)
    assert not found.relief.any()
    assert found.albedo_srgb.shape == (1, 3, SIZE, SIZE)
    assert found.light.shape == (1, 16, 32, 3)


def test_every_switch_is_saved_with_the_weights(tmp_path):
    config = BundleConfig(
        DelightConfig(width=4, levels=3, classes=0, relief=False, anchored=False),
        SpecularShadowConfig(4, 3, per_pixel_light=False, relief_shadow=False, additive=True, modulated=False),
        CompositionConfig(4, 2, explicit_sum=False, effects=False, modulated=False),
    )
    save_bundle(tmp_path / "w.safetensors", NetworkBundle(config))
    assert load_bundle(tmp_path / "w.safetensors").config == config


def test_a_network_without_lfm_works_in_half_precision_too():
    config = BundleConfig(
        DelightConfig(width=4, levels=3),
        SpecularShadowConfig(4, 3, per_pixel_light=False, relief_shadow=False, additive=True, modulated=False),
        CompositionConfig(4, 2, explicit_sum=False, modulated=False),
    )
    bundle = NetworkBundle(config).for_inference()
    albedo, normal, specular, shadow = surface()
    light = torch.rand(1, 16, 32, 3)
    images = []
    for networks in (bundle, bundle.rounded()):
        estimate = networks.specular_shadow(normal, light)
        images.append(networks.composition(albedo, normal, specular, shadow, albedo, light))
        assert estimate.shadow.dtype == torch.float32
    torch.testing.assert_close(*images, atol=0.05, rtol=0.05)
