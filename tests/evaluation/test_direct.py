"""The networks alone: every variant of them is given what it asks for."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from relight_core.evaluation.direct import DirectRelighter
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.training.relight_steps import composition_losses, specular_shadow_losses


@pytest.mark.parametrize(
    "told", [{}, {"relief_shadow": False}, {"parsing_classes": 14}, {"relief_shadow": False, "parsing_classes": 14}]
)
def test_a_shadow_network_told_more_or_less_relights(told):
    torch.manual_seed(2)
    tiny = BundleConfig.tiny()
    config = replace(tiny, specular_shadow=replace(tiny.specular_shadow, **told))
    direct = DirectRelighter(NetworkBundle(config).eval(), ReflectionTable())
    found = direct.take_apart(np.random.default_rng(0).random((32, 32, 3), np.float32))
    relit = direct.relight(found, np.ones((16, 32, 3), np.float32))
    assert relit["composition"].shape == (32, 32, 3)
    assert all(np.isfinite(image).all() for image in relit.values())


def test_networks_are_measured_with_what_they_were_trained_on():
    torch.manual_seed(3)
    tiny, table = BundleConfig.tiny(), ReflectionTable()
    told = replace(tiny.specular_shadow, relief_shadow=True, parsing_classes=14)
    bundle = NetworkBundle(replace(tiny, specular_shadow=told)).eval()
    photo, light = torch.rand(32, 32, 3).numpy(), torch.rand(1, 16, 32, 3) ** 4 * 5
    direct = DirectRelighter(bundle, table)
    found, relit = direct.take_apart(photo), direct.relight(direct.take_apart(photo), light[0].numpy())
    with torch.no_grad():
        said = bundle.delight(encoded(torch.from_numpy(photo).permute(2, 0, 1)[None]))
        torch.testing.assert_close(encoded(found.albedo), said.albedo_srgb, atol=2e-3, rtol=0)
        torch.testing.assert_close(found.normal, torch.nn.functional.normalize(said.normal, dim=1), atol=1e-4, rtol=0)
        one = torch.zeros(1, 1, 32, 32)
        surface = {"albedo": found.albedo, "normal": found.normal, "relief": found.relief, "parsing": found.parsing}
        truth = {"specular": one, "shadow": one, "shadow_fraction": one, "gloss_fraction": one, "covered": one + 1}
        flat = surface | truth | {"light": light, "relief_shadow": found.transport.shadow_fraction(light)}
        flat["image"] = one.expand(1, 3, 32, 32)
        effects, _ = specular_shadow_losses(bundle.specular_shadow, table, flat)
        image, _ = composition_losses(bundle.composition, table, flat, effects)
    assert float(flat["relief_shadow"].max()) > 0.05
    for name, expected in (("specular", effects.specular), ("shadow", effects.shadow), ("composition", image)):
        np.testing.assert_allclose(relit[name], expected[0].permute(1, 2, 0).squeeze(-1), atol=1e-4, err_msg=name)


def encoded(linear):
    return torch.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear.clamp_min(1e-8) ** (1 / 2.4) - 0.055)
