"""Constants that are made once."""

import torch

from relight_core.imaging.tensor_constants import constant

CPU = torch.device("cpu")


def test_a_constant_has_the_numbers_and_the_type_that_were_asked_for():
    weights = constant((0.25, 0.5), CPU, torch.float32)
    assert weights.tolist() == [0.25, 0.5]
    assert constant((1, 2), CPU, torch.int64).dtype == torch.int64
    assert constant((1.0, 2.0), CPU, torch.float32).dtype == torch.float32


def test_it_is_made_once():
    assert constant((3, 1, 4), CPU, torch.int64) is constant((3, 1, 4), CPU, torch.int64)


def test_one_that_was_first_asked_for_in_inference_can_be_learnt_with():
    with torch.inference_mode():
        constant((0.125, 8.0), CPU, torch.float32)
    image = torch.ones(2, requires_grad=True)
    (image * constant((0.125, 8.0), CPU, torch.float32)).sum().backward()
    assert image.grad.tolist() == [0.125, 8.0]
