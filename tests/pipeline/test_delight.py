"""What de-lighting makes of a view, whatever its networks have learnt."""

import numpy as np
import pytest
import torch

from relight_core.face.parsing import INDEX
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


@pytest.fixture
def both_ways(weights):
    """Surfaces of a view and of its mirror image, each with the mean of two looks."""
    photo, bundle = np.random.default_rng(3).random((64, 64, 3), np.float32), load_bundle(weights).for_inference()
    how = {"mirrored": True, "precision": "fp32"}
    return [stages.delight(bundle, np.ascontiguousarray(view), 32, **how) for view in (photo, photo[:, ::-1])]


def test_the_mean_of_two_looks_is_that_of_the_mirror_image_turned_over(both_ways):
    one, other = both_ways
    for name in ("albedo", "relief"):
        torch.testing.assert_close(getattr(other, name).flip(-1), getattr(one, name), atol=1e-4, rtol=1e-3)
    torch.testing.assert_close(other.source_light.flip(2), one.source_light, atol=1e-4, rtol=1e-3)
    sideways = torch.tensor([-1.0, 1.0, 1.0])[None, :, None, None]
    torch.testing.assert_close(other.normal.flip(-1) * sideways, one.normal, atol=1e-3, rtol=0)
    for left, right in (("left_eye", "right_eye"), ("left_brow", "right_brow"), ("hair", "hair")):
        found = other.parsing[:, INDEX[right]].flip(-1)
        torch.testing.assert_close(found, one.parsing[:, INDEX[left]], atol=1e-6, rtol=1e-3)
    assert (one.normal[:, 0] ** 2).mean() > 1e-4
    assert not torch.allclose(one.parsing[:, INDEX["left_eye"]], one.parsing[:, INDEX["right_eye"]], rtol=1e-2, atol=0)


def test_heights_are_in_half_widths_of_the_view():
    """The network's unit is 64 pixels, and its answers fall short by a tenth."""
    assert float(stages.height_of(torch.ones(1, 1, 2, 2), 256).max()) == pytest.approx(0.55)


def test_a_photo_brighter_than_white_is_seen_as_a_camera_would_have_clipped_it(weights):
    bundle, photo = load_bundle(weights).for_inference(), 4 * np.random.default_rng(3).random((64, 64, 3), np.float32)
    bright, clipped = (stages.delight(bundle, view, 32, precision="fp32") for view in (photo, photo.clip(0, 1)))
    assert torch.equal(bright.photo, clipped.photo)
    assert torch.equal(bright.albedo, clipped.albedo)
