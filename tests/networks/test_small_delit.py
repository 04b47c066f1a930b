"""De-lighting at half the size: the means of what it finds at the whole size."""

import pytest
import torch

from relight_core.imaging.tensor_colour import srgb_decode
from relight_core.networks.blocks import Head
from relight_core.networks.delight import DelightConfig, DelightNetwork


@pytest.fixture
def network():
    torch.manual_seed(4)
    network = DelightNetwork(DelightConfig(width=4, levels=3, detail_width=4, decoder_least=6)).eval()
    for layer in (network.head, network.detail.head):
        layer.weight.data.normal_(0, 0.3)
    return network


def halved(image):
    return torch.nn.functional.avg_pool2d(image, 2)


@torch.no_grad()
@pytest.mark.parametrize("relief", [True, False])
def test_it_is_the_mean_of_four_pixels(network, relief):
    if not relief:
        network = DelightNetwork(DelightConfig(width=4, levels=3, detail_width=4, relief=False)).eval()
    photo = torch.rand(2, 3, 32, 48)
    whole, small = network(photo), network.forward_small(photo)
    expected = {
        "albedo": halved(srgb_decode(whole.albedo_srgb)),
        "normal": halved(whole.normal),
        "relief": halved(whole.relief),
        "parsing_logits": halved(whole.parsing_logits),
        "light": whole.light,
    }
    for name, value in expected.items():
        torch.testing.assert_close(getattr(small, name), value, rtol=1e-4, atol=1e-4, msg=name)


@torch.no_grad()
def test_a_head_keeps_its_first_outputs_exact():
    torch.manual_seed(0)
    head, features = Head(8, 5), torch.randn(1, 8, 6, 6).bfloat16()
    exact, partly = head(features), head(features, 2)
    torch.testing.assert_close(partly[:, :2], exact[:, :2], rtol=1e-6, atol=1e-6)
    assert (partly[:, 2:] - exact[:, 2:]).abs().max() > 1e-4
    torch.testing.assert_close(partly, exact, rtol=0.02, atol=0.02)
    assert partly.dtype == torch.float32


def test_normals_get_unit_length_whatever_their_layout():
    from relight_core.imaging.tensor_normals import unit_normals

    normal = torch.randn(2, 3, 4, 5)
    normal[0, :, 0, 0] = 0
    for given in (normal, normal.to(memory_format=torch.channels_last)):
        expected = torch.nn.functional.normalize(normal, dim=1, eps=1e-4)
        torch.testing.assert_close(unit_normals(given), expected)
