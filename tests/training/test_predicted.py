"""Batches whose surface is found in the photo: shapes, which light goes with which truth, no gradient."""

import pytest
import torch

from relight_core.imaging.tensor_colour import srgb_decode
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import BundleConfig, NetworkBundle, with_detail_pass
from relight_core.pipeline import stages
from relight_core.training.predicted import found_hints, on_predicted_surface
from relight_core.training.stages import STAGES


@pytest.fixture
def bundle():
    torch.manual_seed(5)
    return NetworkBundle(BundleConfig.tiny()).eval()


def pairs(count, size):
    """Photos of noise; every truth is a constant that tells its pair and its light."""
    number = torch.arange(2.0 * count).reshape(count, 2)

    def told(channels):
        return number[..., None, None, None].expand(count, 2, channels, size, size).clone()

    return {
        "photo_srgb": torch.rand(count, 2, 3, size, size),
        "image": told(3),
        "shadow_fraction": told(1),
        "light": number[..., None, None, None].expand(count, 2, 16, 32, 3) + 1,
        "albedo": (number[:, 0, None, None, None] + 1).expand(count, 3, size, size) / 4,
        "normal": torch.zeros(count, 3, size, size),
        "covered": torch.ones(count, 1, size, size),
        "label": torch.zeros(count, size, size, dtype=torch.long),
    }


def test_each_photo_gets_the_truth_under_both_lights_of_its_pair(bundle):
    flat = on_predicted_surface(bundle, ReflectionTable(), pairs(2, 32))
    assert flat["image"][:, 0, 0, 0].tolist() == [0, 1, 0, 1, 2, 3, 2, 3]
    assert flat["light"][:, 0, 0, 0].tolist() == [1, 2, 1, 2, 3, 4, 3, 4]
    assert flat["albedo"][:, 0, 0, 0].tolist() == [0.25] * 4 + [0.75] * 4
    assert flat["relief_shadow"].shape == (8, 1, 32, 32)


def test_normals_are_those_found_in_the_photo(bundle):
    batch = pairs(1, 32)
    normal = on_predicted_surface(bundle, ReflectionTable(), batch)["normal"]
    torch.testing.assert_close(normal.norm(dim=1), torch.ones(4, 32, 32), rtol=0, atol=1e-3)
    assert torch.equal(normal[0], normal[1])
    assert not torch.equal(normal[0], normal[2])


def test_with_a_sharpening_pass_the_relighting_networks_work_at_half_the_size(bundle):
    flat = on_predicted_surface(with_detail_pass(bundle, 4).eval(), ReflectionTable(), pairs(1, 64))
    for name in ("image", "albedo", "normal", "relief_shadow", "covered", "shadow_fraction"):
        assert flat[name].shape[-2:] == (32, 32)
    torch.testing.assert_close(flat["albedo"], torch.full((4, 3, 32, 32), 0.25))


def test_what_it_gives_can_be_learnt_on(bundle):
    flat = on_predicted_surface(bundle, ReflectionTable(), pairs(1, 32))
    weight = torch.ones(1, requires_grad=True)
    (weight * flat["normal"] * flat["relief_shadow"]).square().sum().backward()
    assert torch.isfinite(weight.grad).all()


def test_what_is_tuned_on_predictions_is_told_nothing_true_of_the_surface():
    """SS is used with the relief and the parts that were found; with true ones it would learn to trust them."""
    torch.manual_seed(0)
    bundle, table = NetworkBundle(BundleConfig.tiny()).eval(), ReflectionTable()
    generator = torch.Generator().manual_seed(1)

    def drawn(*shape):
        return torch.rand(*shape, generator=generator)

    batch = {
        "photo_srgb": drawn(1, 2, 3, 16, 16),
        "light": drawn(1, 2, 16, 32, 3) * 2,
        "albedo": drawn(1, 3, 16, 16),
        "normal": torch.nn.functional.normalize(drawn(1, 3, 16, 16) + 0.1, dim=1),
        "relief": drawn(1, 1, 16, 16),
        "relief_shadow": drawn(1, 2, 1, 16, 16),
        "label": torch.randint(14, (1, 16, 16), generator=generator),
        "covered": torch.ones(1, 1, 16, 16),
    }
    batch |= {name: drawn(1, 2, 1, 16, 16) for name in ("specular", "shadow", "shadow_fraction", "gloss_fraction")}
    batch["image"] = drawn(1, 2, 3, 16, 16)
    other = batch | {
        "relief": 2 * drawn(1, 1, 16, 16),
        "relief_shadow": drawn(1, 2, 1, 16, 16),
        "label": torch.randint(14, (1, 16, 16), generator=generator),
        "albedo": drawn(1, 3, 16, 16),
        "normal": batch["normal"].flip(-1),
    }
    for stage, same in (("tune-on-predictions", True), ("tune-delight", False)):
        one, two = (STAGES[stage].losses(bundle, table, truth) for truth in (batch, other))
        alike = all(one[name].item() == pytest.approx(two[name].item(), abs=1e-6) for name in one)
        assert alike == same, stage


def test_a_found_relief_casts_the_shadow_that_the_editor_would_march():
    """Two photos at once, each under its own light, are two photos one at a time."""
    torch.manual_seed(0)
    bundle = NetworkBundle(BundleConfig.tiny()).eval()
    photo, light = torch.rand(2, 3, 16, 16), torch.rand(2, 16, 32, 3) ** 6 * 9
    with torch.no_grad():
        found = bundle.delight(photo)
        both = found_hints(bundle, found, light, 16)
        for number in range(2):
            one = found_hints(bundle, bundle.delight(photo[number, None]), light[number, None], 16)
            for name in ("parsing", "relief", "relief_shadow"):
                torch.testing.assert_close(both[name][number, None], one[name], atol=1e-4, rtol=1e-3)
    assert float(both["relief_shadow"].std()) > 0
    assert both["parsing"].sum(1).allclose(torch.ones(2, 16, 16), atol=1e-4)


def test_surfaces_found_together_are_those_found_one_at_a_time(bundle):
    views = torch.rand(3, 3, 32, 32, generator=torch.Generator().manual_seed(2))
    for mirrored in (False, True):
        together = stages.delight_views(bundle, views, views, mirrored=mirrored)
        for view, surface in zip(views, together, strict=True):
            alone = stages.delight(bundle, view.permute(1, 2, 0).numpy(), 32, mirrored=mirrored)
            for name in ("photo", "albedo", "normal", "relief", "parsing", "person", "source_light"):
                found, expected = getattr(surface, name), getattr(alone, name)
                torch.testing.assert_close(found.clone(), expected.clone(), atol=1e-4, rtol=1e-3)
    assert not torch.allclose(together[0].normal.clone(), together[1].normal.clone(), atol=1e-3)


def test_surfaces_reflect_what_the_editor_makes_of_them_and_their_light_but_black_as_it_is_rendered(bundle):
    batch = pairs(1, 32)
    batch["photo_srgb"][:] *= torch.linspace(0, 1, 32)
    flat = on_predicted_surface(bundle, ReflectionTable(), batch)
    surface = stages.delight(bundle, srgb_decode(batch["photo_srgb"][0, 1]).permute(1, 2, 0).numpy(), 32)
    as_rendered, as_edited = (
        stages.reflect(stages.reflector(ReflectionTable(), surface, black_is_dull=dull), batch["light"][0, :1]).clone()
        for dull in (False, True)
    )
    torch.testing.assert_close(flat["reflected"][2:3], as_rendered)
    assert not torch.allclose(as_rendered, as_edited, atol=1e-4)
