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


@pytest.mark.parametrize("first", [1e-3, 7e-2])
def test_a_hidden_convolution_moves_equally_far_in_all_directions(first):
    network = small_network()
    optimiser = Optimiser(network, first)
    if first != 1e-3:
        optimiser.set_learning_rate(1e-3)
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


def test_without_gradients_to_follow_weights_shrink_as_much_as_they_should():
    network = small_network()
    optimiser = Optimiser(network, 0.5)
    before = [weight.detach().clone() for weight in network.parameters()]
    for weight in network.parameters():
        weight.grad = torch.zeros_like(weight)
    optimiser.step()
    for weight, old in zip(network.parameters(), before, strict=True):
        kept = 1 - 0.5 * 20 * 0.01 if weight is network[1].conv.weight else 1 - 0.5 * 1e-4
        torch.testing.assert_close(weight.detach(), kept * old, rtol=2e-6, atol=1e-7)


def test_gradients_of_one_step_are_forgotten_before_the_next():
    network = small_network()
    optimiser = Optimiser(network, 1e-3)
    pushed(network)
    optimiser.zero_grad()
    assert all(weight.grad is None for weight in network.parameters())


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


def test_moments_of_some_of_the_weights_are_refused():
    network = small_network()
    network[2].requires_grad_(False)
    first = Optimiser(network, 1e-3)
    pushed(network)
    first.step()
    network.requires_grad_(True)
    with pytest.raises(ValueError, match="this stage changes"):
        Optimiser(network, 1e-3).load_moments(first.moments())


def test_steps_go_on_from_moments_as_if_they_had_never_been_put_down():
    whole, halves = small_network(), small_network()
    one, first = Optimiser(whole, 1e-3), Optimiser(halves, 1e-3)
    for seed in range(4):
        if seed == 2:
            moments, first = first.moments(), Optimiser(halves, 1e-3)
            first.load_moments({name: value.clone().contiguous() for name, value in moments.items()})
        for network, optimiser in ((whole, one), (halves, first)):
            optimiser.zero_grad()
            pushed(network, seed)
            optimiser.step()
    for weight, expected in zip(halves.parameters(), whole.parameters(), strict=True):
        torch.testing.assert_close(weight, expected, rtol=0, atol=0)
