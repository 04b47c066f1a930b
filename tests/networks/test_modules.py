"""The three networks' parts: what holds for any weights."""

import math

import pytest
import torch
from torch import nn

from relight_core.networks.blocks import ConvBlock, fold_normalisation
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.networks.composition import (
    CompositionConfig,
    CompositionNetwork,
    decode_radiance,
    encode_radiance,
)
from relight_core.networks.delight import ConfidenceWeightedLight, DelightConfig, DelightNetwork
from relight_core.networks.lfm import LightModulation, encode_light
from relight_core.networks.specular_shadow import SpecularShadowConfig, SpecularShadowNetwork

pytestmark = pytest.mark.usefixtures("seeded")


def light(batch=1):
    return torch.rand(batch, 16, 32, 3) * 3


class TestModulation:
    """F_out = gamma * F_in + beta (paper, Eq. 7)."""

    def test_is_near_the_identity_before_training(self):
        features = torch.randn(2, 6, 5, 5)
        modulated = LightModulation(6)(features, encode_light(light(2)))
        assert (modulated - features).abs().mean() < 0.3 * features.abs().mean()

    def test_black_light_leaves_features_with_the_biases_alone(self):
        modulation = LightModulation(4)
        nn.init.zeros_(modulation.fc1.bias)
        features = torch.randn(1, 4, 3, 3)
        torch.testing.assert_close(modulation(features, torch.zeros(1, 1536)), features)

    def test_is_gamma_times_features_plus_beta(self):
        modulation = LightModulation(2)
        for layer, bias in ((modulation.fc2, [2.0, -1.0]), (modulation.fc3, [0.5, 3.0])):
            nn.init.zeros_(layer.weight)
            layer.bias.data = torch.tensor(bias)
        modulated = modulation(torch.full((1, 2, 1, 1), 10.0), encode_light(light()))
        assert modulated.flatten().tolist() == [20.5, -7.0]

    def test_is_affine_in_the_features(self):
        modulation, encoded = LightModulation(3), encode_light(light())
        a, b = torch.randn(2, 1, 3, 4, 4)
        middle = modulation((a + b) / 2, encoded)
        torch.testing.assert_close(middle, (modulation(a, encoded) + modulation(b, encoded)) / 2)

    @pytest.mark.parametrize("batch", [1, 3])
    def test_does_the_same_whichever_way_features_lie_in_memory(self, batch):
        modulation, encoded = LightModulation(5), encode_light(light(batch))
        features = torch.randn(batch, 5, 4, 7)
        beside = features.contiguous(memory_format=torch.channels_last)
        torch.testing.assert_close(modulation(beside, encoded), modulation(features, encoded))

    def test_light_is_encoded_as_log_of_one_plus_radiance(self):
        encoded = encode_light(torch.full((1, 16, 32, 3), math.e - 1))
        assert encoded.shape == (1, 1536)
        torch.testing.assert_close(encoded, torch.ones(1, 1536))

    def test_negative_radiance_counts_as_none(self):
        assert encode_light(torch.full((1, 16, 32, 3), -5.0)).abs().max() == 0


class TestConfidenceWeightedLight:
    """The light is a convex combination of what the places of the bottleneck propose (Sun et al. 2019)."""

    def network(self):
        network = ConfidenceWeightedLight(4).eval()
        network.hidden = nn.Identity()  # a convolution mixes neighbours; the combination itself does not
        return network

    def test_order_of_places_does_not_matter(self):
        network, features = self.network(), torch.randn(1, 4, 3, 3)
        shuffled = features.flatten(2)[..., torch.randperm(9)].unflatten(2, (3, 3))
        torch.testing.assert_close(network(features), network(shuffled))

    def test_repeating_all_places_changes_nothing(self):
        network, features = self.network(), torch.randn(1, 4, 2, 2)
        torch.testing.assert_close(network(features), network(features.repeat(1, 1, 2, 3)))

    def test_lies_between_the_places_own_proposals(self):
        network, features = self.network(), torch.randn(1, 4, 2, 3)
        alone = torch.stack([network(features[:, :, y : y + 1, x : x + 1]) for y in range(2) for x in range(3)])
        together = network(features)
        assert (together >= alone.amin(0) - 1e-5).all()
        assert (together <= alone.amax(0) + 1e-5).all()

    def test_is_a_light(self):
        found = ConfidenceWeightedLight(4).eval()(torch.randn(2, 4, 3, 3) * 100)
        assert found.shape == (2, 16, 32, 3)
        assert torch.isfinite(found).all()
        assert (found >= 0).all()


class TestDelight:
    def network(self, **settings):
        return DelightNetwork(DelightConfig(width=4, levels=3, **settings)).eval()

    def test_shapes_and_ranges(self):
        found = self.network()(torch.rand(2, 3, 16, 24))
        assert found.albedo_srgb.shape == found.normal.shape == (2, 3, 16, 24)
        assert found.relief.shape == (2, 1, 16, 24)
        assert found.parsing_logits.shape == (2, 14, 16, 24)
        assert found.light.shape == (2, 16, 32, 3)
        assert ((found.albedo_srgb >= 0) & (found.albedo_srgb <= 1)).all()
        torch.testing.assert_close(found.normal.norm(dim=1), torch.ones(2, 16, 24))

    @pytest.mark.parametrize("detail_width", [0, 4])
    def test_a_wider_decoder_has_the_same_outputs(self, detail_width):
        plain, wide = (self.network(detail_width=detail_width, decoder_least=least) for least in (0, 12))
        found = wide(torch.rand(1, 3, 16, 24))
        assert found.normal.shape == (1, 3, 16, 24)
        assert found.parsing_logits.shape == (1, 14, 16, 24)
        assert plain.head.in_channels == 4
        assert wide.head.in_channels == 12
        assert {level.blend.conv.out_channels for level in wide.decoder} == {12}

    def test_residual_blocks_sit_where_they_are_told_to(self):
        network = self.network(residual=[0, 2, 1])
        assert [len(level) for level in network.encoder.levels] == [4, 3]
        assert network(torch.rand(1, 3, 16, 24)).normal.shape == (1, 3, 16, 24)

    @pytest.mark.parametrize("residual", [(1,), (0, 1), (1, 0, 0), (0, 0, 0, 0)])
    def test_residual_blocks_for_other_levels_are_refused(self, residual):
        with pytest.raises(ValueError, match="3 numbers"):
            self.network(residual=residual)

    def test_so_do_those_of_the_decoder_which_has_one_level_fewer(self):
        network = self.network(decoder_residual=[2, 1])
        assert [len(level.residual) for level in network.decoder] == [1, 2]
        assert network(torch.rand(1, 3, 16, 24)).normal.shape == (1, 3, 16, 24)
        with pytest.raises(ValueError, match="2 numbers"):
            self.network(decoder_residual=(0, 1, 1))

    def test_anchored_albedo_without_change_is_the_photo(self):
        network = self.network()
        nn.init.zeros_(network.head.weight)
        nn.init.zeros_(network.head.bias)
        photo = torch.rand(1, 3, 8, 8) * 0.9 + 0.05
        torch.testing.assert_close(network(photo).albedo_srgb, photo)

    def test_anchored_albedo_can_leave_black_and_white(self):
        network = self.network()
        nn.init.zeros_(network.head.weight)
        network.head.bias.data[:3] = 4.0
        assert network(torch.zeros(1, 3, 8, 8)).albedo_srgb.min() > 0.5

    def test_plain_albedo_does_not_see_the_photo_but_through_the_network(self):
        network = self.network(anchored=False)
        nn.init.zeros_(network.head.weight)
        nn.init.zeros_(network.head.bias)
        torch.testing.assert_close(network(torch.rand(1, 3, 8, 8)).albedo_srgb, torch.full((1, 3, 8, 8), 0.5))

    def test_black_and_white_photos_give_finite_gradients(self):
        network = self.network().train()
        found = network(torch.tensor([0.0, 1.0]).reshape(2, 1, 1, 1).expand(2, 3, 8, 8))
        (found.albedo_srgb.sum() + found.normal.sum() + found.light.sum()).backward()
        assert all(torch.isfinite(p.grad).all() for p in network.parameters() if p.grad is not None)


class TestSpecularShadow:
    @pytest.mark.parametrize(
        ("per_pixel", "relief", "inputs"),
        [(True, True, 6), (True, False, 5), (False, True, 4), (False, False, 3)],
    )
    def test_every_variant_has_its_inputs(self, per_pixel, relief, inputs):
        config = SpecularShadowConfig(4, 3, per_pixel_light=per_pixel, relief_shadow=relief)
        assert config.inputs == inputs
        hints = torch.rand(1, inputs - 3, 8, 8) if inputs > 3 else None
        occlusion = SpecularShadowNetwork(config).eval()(torch.rand(1, 3, 8, 8), light(), hints)
        assert occlusion.shadow.shape == occlusion.gloss.shape == (1, 1, 8, 8)

    def test_starts_from_the_relief_s_shadow(self):
        network = SpecularShadowNetwork(SpecularShadowConfig(4, 3)).eval()
        nn.init.zeros_(network.head.weight)
        nn.init.zeros_(network.head.bias)
        hints = torch.rand(1, 3, 8, 8) * 0.9 + 0.05
        occlusion = network(torch.rand(1, 3, 8, 8), light(), hints)
        torch.testing.assert_close(torch.sigmoid(occlusion.shadow), hints[:, 2:])

    def test_light_modulates_the_result(self):
        network = SpecularShadowNetwork(SpecularShadowConfig(4, 3)).eval()
        normal, hints = torch.rand(1, 3, 8, 8), torch.rand(1, 3, 8, 8)
        one, other = (network(normal, light(), hints).shadow for _ in range(2))
        assert (one - other).abs().max() > 1e-4


class TestComposition:
    def channels(self, size=8):
        albedo, normal = torch.rand(2, 1, 3, size, size)
        specular, shadow = torch.rand(2, 1, 1, size, size)
        return albedo, normal, specular, shadow

    def test_untrained_it_returns_the_explicit_sum(self):
        explicit = torch.rand(1, 3, 8, 8) * 20
        image = CompositionNetwork(CompositionConfig(4, 2)).eval()(*self.channels(), explicit, light())
        torch.testing.assert_close(image, explicit, rtol=1e-4, atol=1e-5)

    def test_the_paper_s_form_does_not_read_the_sum(self):
        network = CompositionNetwork(CompositionConfig(4, 2, explicit_sum=False)).eval()
        channels, target = self.channels(), light()
        one, other = (network(*channels, torch.rand(1, 3, 8, 8), target) for _ in range(2))
        torch.testing.assert_close(one, other)
        assert (one >= 0).all()

    def test_radiance_comes_back_from_its_encoding_far_beyond_one(self):
        radiance = torch.tensor([0.0, 1e-4, 0.18, 1.0, 7.5, 300.0, 30000.0])
        torch.testing.assert_close(decode_radiance(encode_radiance(radiance)), radiance, rtol=1e-4, atol=1e-7)

    def test_encoding_is_one_at_one_and_grows(self):
        encoded = encode_radiance(torch.tensor([0.0, 0.5, 1.0, 2.0, 100.0]))
        assert encoded[0] == 0
        assert float(encoded[2]) == pytest.approx(1.0)
        assert (encoded.diff() > 0).all()

    def test_decoding_stays_finite(self):
        decoded = decode_radiance(torch.tensor([-1e9, -1.0, 1e9]))
        assert torch.isfinite(decoded).all()
        assert decoded[:2].tolist() == [0.0, 0.0]


def test_folding_the_normalisation_changes_no_output():
    bundle = NetworkBundle(BundleConfig.tiny())
    for module in bundle.modules():
        if isinstance(module, nn.BatchNorm2d):
            module.running_mean.normal_(0, 0.5)
            module.running_var.uniform_(0.2, 3)
            module.weight.data.uniform_(0.5, 2)
            module.bias.data.normal_()
    bundle.eval().requires_grad_(False)
    photo, target = torch.rand(1, 3, 16, 16), light()
    before = bundle.delight(photo)
    shadow_before = bundle.specular_shadow(photo, target, photo).shadow
    fold_normalisation(bundle)
    after = bundle.delight(photo)
    for name in ("albedo_srgb", "normal", "relief", "parsing_logits", "light"):
        torch.testing.assert_close(getattr(after, name), getattr(before, name), rtol=1e-3, atol=1e-4)
    torch.testing.assert_close(bundle.specular_shadow(photo, target, photo).shadow, shadow_before, rtol=1e-3, atol=1e-4)
    assert not any(isinstance(module, nn.BatchNorm2d) for module in bundle.modules())


def test_folding_twice_is_folding_once():
    block = ConvBlock(2, 3).eval().requires_grad_(False)
    block.fold()
    x = torch.rand(1, 2, 4, 4)
    once = block(x)
    block.fold()
    torch.testing.assert_close(block(x), once)
