"""What a light makes of a response to its texels."""

import pytest
import torch

from relight_core.lighting.response import response_to


@pytest.mark.parametrize("lit", [0, 1, 12, 13, 100])
def test_it_is_the_product_however_few_texels_are_lit(lit):
    generator = torch.Generator().manual_seed(0)
    light, response = torch.zeros(3, 100), torch.rand(100, 7, generator=generator)
    light[:, torch.randperm(100, generator=generator)[:lit]] = torch.rand(3, lit, generator=generator)
    torch.testing.assert_close(response_to(light, response), (light[:, :, None] * response).sum(1))


def test_light_in_any_colour_counts():
    light = torch.zeros(3, 100)
    light[2, 40] = 2.0
    torch.testing.assert_close(response_to(light, torch.ones(100, 1)), torch.tensor([[0.0], [0.0], [2.0]]))
