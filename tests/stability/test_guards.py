"""Where a formula would divide by zero or take the root of nothing: values and gradients are finite."""

from types import SimpleNamespace

import pytest
import torch

from relight_core.imaging.tensor_colour import srgb_decode, srgb_encode
from relight_core.imaging.tensor_normals import unit_normals
from relight_core.lighting.reflection import ReflectionTable, specular_lobe, table_position
from relight_core.networks.composition import decode_radiance, encode_radiance
from relight_core.networks.lfm import encode_light
from relight_core.pipeline.per_light.hints import Effects, effects_of, explicit_sum
from relight_core.training.losses import edges_l1, focal_parsing, fraction_loss, irradiance_l1, masked_l1, wlog_l2

EDGES = (0.0, 1e-45, 1e-8, 0.0031308, 0.04045, 1.0, 1e4, 1e30)
CURVES = {
    "srgb_encode": srgb_encode,
    "srgb_decode": lambda x: srgb_decode(x.clamp_max(16)),
    "encode_radiance": encode_radiance,
    "decode_radiance": decode_radiance,
    "encode_light": lambda x: encode_light(x.reshape(1, -1)),
}


def finite_gradient(function, *inputs):
    inputs = [value.clone().requires_grad_(True) for value in inputs]
    result = function(*inputs)
    assert torch.isfinite(result).all()
    result.sum().backward()
    for value in inputs:
        assert value.grad is None or torch.isfinite(value.grad).all()


@pytest.mark.parametrize("name", CURVES)
def test_curves_at_their_ends(name):
    finite_gradient(CURVES[name], torch.tensor([*EDGES, *(-edge for edge in EDGES)]))


def test_normals_of_length_zero_and_away_from_the_camera():
    normals = torch.tensor([[0.0, 0, 0], [0, 0, -1], [0, 0, 1], [1, 0, 0], [1e-30, 0, 0]]).T.reshape(1, 3, 1, 5)
    finite_gradient(unit_normals, normals)
    finite_gradient(table_position, normals)
    light = torch.zeros(1, 16, 32, 3)
    light[0, 3, 4] = 1e6
    finite_gradient(ReflectionTable(), light, normals)


def test_the_gloss_of_grazing_and_opposite_directions():
    ways = torch.tensor([[0.0, 0, -1], [0, 0, 1], [1, 0, 0], [0, 1, 0]])
    finite_gradient(specular_lobe, ways, ways)


def test_effects_of_no_light_and_a_black_surface():
    for brightness in (0.0, 1e-20, 1e4):
        reflected = torch.full((1, 6, 4, 4), brightness)
        for logit in (-1e4, 0.0, 1e4):
            occlusion = SimpleNamespace(shadow=torch.full((1, 1, 4, 4), logit), gloss=torch.full((1, 1, 4, 4), logit))
            effects = effects_of(occlusion, reflected, torch.zeros(1, 3, 4, 4))
            for gain in (0.0, 1.0, 2.0):
                finite_gradient(
                    lambda albedo, light, e=effects, g=gain: explicit_sum(
                        albedo, light, Effects(e.specular, e.shadow), g, g
                    ),
                    torch.zeros(1, 3, 4, 4),
                    reflected,
                )


@pytest.mark.parametrize("covered", [0.0, 1.0])
@pytest.mark.parametrize("constant", [0.0, 1.0])
def test_losses_of_empty_masks_and_constant_images(covered, constant):
    mask, image = torch.full((2, 1, 8, 8), covered), torch.full((2, 3, 8, 8), constant)
    finite_gradient(lambda x: masked_l1(x, image, mask), image)
    finite_gradient(lambda x: edges_l1(x, image, mask), image)
    finite_gradient(lambda x: fraction_loss(x, mask * constant, mask), 1e4 * (image[:, :1] - 0.5))
    labels = torch.zeros(2, 8, 8, dtype=torch.int64)
    finite_gradient(lambda x: focal_parsing(x, labels), torch.full((2, 14, 8, 8), 1e3 * constant))


@pytest.mark.parametrize("radiance", [0.0, 1e-45, 1e6])
def test_losses_of_black_and_blinding_lights(radiance):
    light, table = torch.full((1, 16, 32, 3), radiance), ReflectionTable()
    finite_gradient(lambda x: wlog_l2(x, torch.zeros_like(light)), light)
    finite_gradient(lambda x: irradiance_l1(x, torch.zeros_like(light), table), light)
