"""What networks make of weights and inputs that a rule gives: to any other arithmetic trained weights are of no use."""

from functools import partial

import pytest
import torch

from relight_core.networks.composition import CompositionConfig, CompositionNetwork
from relight_core.networks.delight import DelightConfig, DelightNetwork
from relight_core.networks.foreign_shadow import ForeignShadowConfig, ForeignShadowNetwork
from relight_core.networks.person import PersonConfig, PersonNetwork
from relight_core.networks.specular_shadow import SpecularShadowConfig, SpecularShadowNetwork


def waves(shape, low, high, pace=0.37):
    """Numbers between two that go up and down in no order."""
    places = torch.arange(torch.Size(shape).numel())
    wave = torch.sin(pace * (places**2 % 1009).double()).reshape(shape)
    return (low + (high - low) * (wave + 1) / 2).float()


def weighted(network, strength=0.6):
    """A network whose weights go up and down, and matter the more the stronger they are."""
    for name, value in network.state_dict().items():
        if name.endswith(("num_batches_tracked", "even_rows")):
            continue
        reach = strength / value[0].numel() ** 0.5 if value.ndim > 1 else 0.5
        middle = 1.0 if name.endswith(("norm.weight", "running_var")) else 0.0
        value.copy_(waves(value.shape, middle - reach, middle + reach, 0.61 + 0.07 * (sum(name.encode()) % 9)))
    return network.eval()


def images(*channels, size=32):
    return [waves((1, count, size, size), 0.05, 0.9, 0.31 + 0.05 * place) for place, count in enumerate(channels)]


LIGHT = waves((1, 16, 32, 3), 0, 3, 0.53)


def delight(**settings):
    found = weighted(DelightNetwork(DelightConfig(width=4, levels=4, **settings)))(*images(3))
    return found.albedo_srgb, found.normal, found.relief, found.parsing_logits, found.light


def specular_shadow(strength=0.6, **settings):
    network = weighted(SpecularShadowNetwork(SpecularShadowConfig(width=4, levels=4, **settings)), strength)
    normal = torch.nn.functional.normalize(images(3)[0] - 0.3, dim=1)
    said = network(normal, LIGHT, images(3, network.config.hints)[1])
    return said.shadow, said.gloss


def composition(strength=0.6, **settings):
    network = weighted(CompositionNetwork(CompositionConfig(width=4, levels=4, **settings)), strength)
    return (network(*images(3, 3, 1, 1, 3), LIGHT),)


def person():
    return (weighted(PersonNetwork(PersonConfig(width=4, levels=4, widest=8)), 2.0)(*images(3, 1, 1)),)


def foreign_shadow():
    return (weighted(ForeignShadowNetwork(ForeignShadowConfig(width=4, levels=4, widest=8)), 2.0)(*images(3, 4)),)


SHARPENED = {"detail_width": 4, "decoder_least": 6, "residual": (0, 0, 1, 1), "decoder_residual": (1, 0, 1)}
CASES = {
    "delight": delight,
    "delight, sharpened": partial(delight, **SHARPENED),
    "delight, plain": partial(delight, anchored=False),
    "specular_shadow": partial(specular_shadow, parsing_classes=14),
    "specular_shadow, as in the paper's baseline": partial(specular_shadow, 1.5, modulated=False, additive=True),
    "composition": composition,
    "composition, as in the paper's baseline": partial(composition, 0.9, modulated=False, explicit_sum=False),
    "person": person,
    "foreign_shadow": foreign_shadow,
}


def figures(channel):
    """Mean, deviation, and one of the values."""
    return [float(channel.mean()), float(channel.std()), float(channel.flatten()[channel.numel() // 3])]


EXPECTED = {
    "delight": [
        [0.5045, 0.3034, 0.8329],
        [-0.5132, 0.2646, -0.2673],
        [-0.4803, 0.0526, -0.4475],
        [-0.048, 0.4121, 0.1308],
        [1.0053, 0.0826, 0.9905],
    ],
    "delight, sharpened": [
        [0.4744, 0.301, 0.7126],
        [-0.1134, 0.5662, 0.2235],
        [-0.6554, 0.0923, -0.6512],
        [-0.0236, 0.4697, -0.2944],
        [1.0052, 0.0831, 0.9995],
    ],
    "delight, plain": [
        [0.5435, 0.1108, 0.6517],
        [-0.5132, 0.2646, -0.2673],
        [-0.4803, 0.0526, -0.4475],
        [-0.048, 0.4121, 0.1308],
        [1.0053, 0.0826, 0.9905],
    ],
    "specular_shadow": [[0.0027, 1.5971, -2.683], [1.0956, 0.1104, 1.1287]],
    "specular_shadow, as in the paper's baseline": [[1.1807, 1.6703, -0.2784], [3.4587, 0.6885, 3.3049]],
    "composition": [[5.3236, 8.6118, 5.4819]],
    "composition, as in the paper's baseline": [[4.7342, 7.5212, 0.5925]],
    "person": [[1.0727, 2.4101, 0.3816]],
    "foreign_shadow": [[1.2391, 2.9227, 0.7863]],
}


@pytest.mark.parametrize("name", CASES)
@torch.no_grad()
def test_weights_mean_what_they_meant(name):
    found = [figures(channel) for channel in CASES[name]()]
    for channel, expected in zip(found, EXPECTED[name], strict=True):
        assert channel == pytest.approx(expected, rel=1e-3, abs=5e-4)
