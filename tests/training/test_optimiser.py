"""The optimiser on networks so small that its steps can be checked by hand."""

import pytest
import torch
from torch import nn

from relight_core.networks.blocks import ConvBlock, Head
from relight_core.training.optimiser import Optimiser


def small_network():
    torch.manual_seed(3)
    network = nn.Sequential(ConvBlock(3, 8), ConvBlock(8, 6), Head(6, 2)).to(memory_format=torch.channels_last)
    return network


def pushed(network, seed=0):
    """Gradients of a random picture's mean square."""
    picture = torch.randn(2, 3, 8, 8, generator=torch.Generator().manual_seed(seed))
    (network(picture) ** 2).mean().backward()


def test_a_hidden_convolution_moves_equally_far_in_all_directions():
    network = small_network()
    optimiser = Optimiser(network, 1e-3)
    before = network[1].conv.weight.detach().clone()
    pushed(network)
    optimiser.step()
    moved = (network[1].conv.weight.detach() - before).flatten(1)
    lengths = torch.linalg.svdvals(moved) / 0.02
    assert lengths.min() > 0.5
    assert lengths.max() < 1.5


@pytest.mark.parametrize("layer", [0, 2])
def test_what_reads_the_photo_or_writes_a_picture_moves_as_adam_says(layer):
    network = small_network()
    optimiser = Optimiser(network, 1e-3)
    weight = (network[0].conv if layer == 0 else network[2]).weight
    before = weight.detach().clone()
    pushed(network)
    optimiser.step()
    moved = (weight.detach() - before).abs()
    assert moved.max() == pytest.approx(1e-3, rel=0.05)


def test_the_rate_can_be_nothing():
    network = small_network()
    optimiser = Optimiser(network, 1e-3)
    before = [weight.detach().clone() for weight in network.parameters()]
    optimiser.set_learning_rate(0.0)
    pushed(network)
    optimiser.step()
    for weight, old in zip(network.parameters(), before, strict=True):
        torch.testing.assert_close(weight.detach(), old, rtol=0, atol=0)


def test_frozen_weights_stay():
    network = small_network()
    network[1].requires_grad_(False)
    optimiser = Optimiser(network, 1e-3)
    before = network[1].conv.weight.clone()
    pushed(network)
    optimiser.step()
    assert torch.equal(network[1].conv.weight, before)


def test_moments_of_other_networks_are_refused():
    network, other = small_network(), nn.Sequential(ConvBlock(3, 8), ConvBlock(8, 4))
    other = other.to(memory_format=torch.channels_last)
    first, second = Optimiser(network, 1e-3), Optimiser(other, 1e-3)
    pushed(network)
    first.step()
    with pytest.raises((ValueError, IndexError)):
        second.load_moments(first.moments())
