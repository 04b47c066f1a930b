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
