"""The networks alone: every variant of them is given what it asks for."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from relight_core.evaluation.direct import DirectRelighter
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import BundleConfig, NetworkBundle


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
