"""Normals at length 1, with gradients that stay finite."""

import torch

from relight_core.imaging.tensor_normals import unit_normals


def test_long_and_short_normals_are_of_length_one():
    normal = torch.tensor([2.0, -1.0, 2.0])[None, :, None, None] * torch.tensor([1e-3, 0.01, 1.0, 50.0])
    unit = torch.tensor([2.0, -1.0, 2.0])[None, :, None, None] / 3
    torch.testing.assert_close(unit_normals(normal), unit.expand(1, 3, 1, 4))


def test_nothing_stays_nothing_with_a_finite_gradient():
    normal = torch.zeros(1, 3, 2, 2, requires_grad=True)
    unit = unit_normals(normal)
    unit.sum().backward()
    assert unit.abs().max() == 0
    assert normal.grad.isfinite().all()
