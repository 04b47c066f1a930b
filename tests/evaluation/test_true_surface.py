"""The truth that networks' surfaces are measured beside: at a smaller size as true as at the head's own."""

from types import SimpleNamespace

import numpy as np
import torch

from relight_core.evaluation.true_surface import true_surface

SIZE, SKIN = 32, 1


def test_the_nothing_around_a_head_has_no_say_in_its_outline():
    y, x = np.mgrid[:SIZE, :SIZE] - (SIZE - 1) / 2
    covered = (np.hypot(x, y) < 11.3).astype(np.float32)
    truth = {
        "covered": covered,
        "albedo": covered[..., None] * np.float32([0.6, 0.4, 0.2]),
        "normal": covered[..., None] * np.float32([0.6, 0, 0.8]),
        "relief": -0.5 * covered,
        "label": (covered * SKIN).astype(np.uint8),
    }
    light = SimpleNamespace(radiance=np.full((16, 32, 3), 2.0, np.float32))
    surface = true_surface(SimpleNamespace(surface=lambda: truth), light, SIZE // 2, "cpu")
    person = surface.person[0, 0]
    assert ((person > 0) & (person < 1)).sum() > 8
    for name, value in (("albedo", [0.6, 0.4, 0.2]), ("normal", [0.6, 0, 0.8]), ("relief", [-0.5])):
        found = getattr(surface, name)[0][:, person > 0]
        torch.testing.assert_close(found, torch.tensor(value)[:, None].expand_as(found), atol=1e-4, rtol=0)
    torch.testing.assert_close(surface.parsing[0, SKIN], person)
    torch.testing.assert_close(surface.source_light, torch.full((1, 16, 32, 3), 2.0))
