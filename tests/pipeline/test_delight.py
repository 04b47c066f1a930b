"""What de-lighting makes of a view, whatever its networks have learnt."""

import numpy as np
import torch

from relight_core.networks.bundle import load_bundle
from relight_core.pipeline import stages


def some_surface(weights, **how):
    photo = np.random.default_rng(3).random((64, 64, 3), np.float32)
    return stages.delight(load_bundle(weights).for_inference(), photo, 32, precision="fp32", **how)


def test_normals_are_unit_vectors_and_probabilities_sum_to_one(weights):
    for how in ({}, {"mirrored": True}):
        surface = some_surface(weights, **how)
        assert torch.allclose(surface.normal.norm(dim=1), torch.ones(1, 32, 32), atol=1e-4)
        assert torch.allclose(surface.parsing.sum(1), torch.ones(1, 32, 32), atol=1e-4)


def test_the_rim_of_a_view_is_no_edge_of_the_surface(weights):
    """Convolutions padded with zeros answer otherwise in the outermost pixels."""
    normal = some_surface(weights).normal
    for axis in (2, 3):
        for rim, inside in ((0, 1), (31, 30)):
            assert torch.equal(normal.select(axis, rim), normal.select(axis, inside))


def test_dust_on_a_pixel_reaches_the_network_as_a_lens_draws_it(weights):
    """Nothing it learnt from was sharper; light is spread, not lost, and linear light at that."""
    bundle, seen = load_bundle(weights).for_inference(), []
    bundle.delight.register_forward_pre_hook(lambda _, views: seen.append(views[0].float()))
    dusty = np.full((64, 64, 3), 0.2, np.float32)
    dusty[20, 30] = 1.0
    stages.delight(bundle, dusty, 64, precision="fp32")
    linear = torch.where(seen[0] <= 0.04045, seen[0] / 12.92, ((seen[0] + 0.055) / 1.055) ** 2.4)
    spread = linear[0, 0] - 0.2
    assert np.isclose(float(spread.sum()), 0.8, atol=1e-3)
    assert np.allclose(spread[19:22, 30], [0.075, 0.45, 0.075], atol=1e-4)
    assert np.allclose(spread[20, 29:32], [0.075, 0.45, 0.075], atol=1e-4)


def test_the_rim_of_a_view_is_as_bright_through_the_lens(weights):
    bundle, seen = load_bundle(weights).for_inference(), []
    bundle.delight.register_forward_pre_hook(lambda _, views: seen.append(views[0].float()))
    stages.delight(bundle, np.full((64, 64, 3), 0.5, np.float32), 64, precision="fp32")
    assert torch.allclose(seen[0], seen[0][..., 32:33, 32:33].expand_as(seen[0]), atol=1e-5)
