"""Which channel is which: weights that were trained know them by their order alone."""

import pytest
import torch

from relight_core.networks.composition import CompositionConfig, CompositionNetwork, encode_radiance
from relight_core.networks.pair import PairConfig, RelightingPair
from relight_core.networks.person import PersonConfig, PersonNetwork
from relight_core.networks.specular_shadow import SpecularShadowConfig, SpecularShadowNetwork

LIGHT = torch.ones(1, 16, 32, 3)


def told(network, *inputs):
    """What a network's encoder gets."""
    seen = []
    network.encoder.register_forward_pre_hook(lambda _, parts: seen.append(parts[0]))
    with torch.no_grad():
        network.eval()(*inputs)
    return seen[0]


def test_composition_is_told_albedo_normal_specular_shadow_and_sum():
    values = (0.1, 0.2, 0.3, 0.4, 0.5)
    parts = [torch.full((1, count, 16, 16), value) for count, value in zip((3, 3, 1, 1, 3), values, strict=True)]
    seen = told(CompositionNetwork(CompositionConfig(width=4)), *parts, LIGHT)[0, :, 0, 0]
    albedo, specular, shadow, explicit = encode_radiance(torch.tensor([0.1, 0.3, 0.4, 0.5])).tolist()
    assert seen.tolist() == pytest.approx([albedo] * 3 + [0.2] * 3 + [specular, shadow] + [explicit] * 3)


def test_of_what_ss_says_shadow_comes_first_on_top_of_the_reliefs():
    network = SpecularShadowNetwork(SpecularShadowConfig(width=4, levels=3)).eval()
    with torch.no_grad():
        network.head.weight.zero_()
        network.head.bias.copy_(torch.tensor([1.0, -2.0]))
        hints = torch.full((1, 3, 16, 16), 0.8)
        said = network(torch.zeros(1, 3, 16, 16), LIGHT, hints)
    assert float(said.shadow.mean()) == pytest.approx(1 + 1.386294, abs=1e-4)
    assert float(said.gloss.mean()) == pytest.approx(-2, abs=1e-4)


def test_beyond_the_photo_the_person_network_is_told_nothing():
    inside = torch.zeros(1, 1, 32, 32)
    inside[..., :16] = 1
    photo = 0.7 * inside.expand(1, 3, 32, 32)
    seen = told(PersonNetwork(PersonConfig(width=4, levels=3)), photo, inside, torch.zeros(1, 1, 32, 32))
    assert seen[..., 8:].abs().max() == 0
    assert seen[0, :4, 0, 0].tolist() == pytest.approx([0.2] * 4)


def test_a_narrow_pair_reads_lights_as_a_wide_one_does_at_the_same_resolution():
    wide = PairConfig(SpecularShadowConfig(width=8, levels=4), CompositionConfig(width=8, levels=4))
    given, pair = RelightingPair(wide), RelightingPair(wide.narrowed(4))
    pair.told_of_light_like(given)
    for mine, others in (
        (pair.specular_shadow.modulations, given.specular_shadow.modulations),
        (pair.composition.modulations, given.composition.modulations),
    ):
        assert torch.equal(mine[-1].fc1.weight, others[-1].fc1.weight)
