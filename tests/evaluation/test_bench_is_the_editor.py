"""What is measured on held-out heads is what the editor does: the same photo and light give the same channels."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from synthetic_heads import write_balls, write_lights

from relight_core.evaluation.bench import Editor
from relight_core.evaluation.held_out import HeldOutLight, held_out_lights, held_out_textures, lamp, load_head
from relight_core.face.crop import Crop
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment, network_light
from relight_core.lighting.lamps import lamps_of
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import BundleConfig, NetworkBundle, load_bundle, save_bundle
from relight_core.pipeline import relighter as relighter_module
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_photo.portrait import Portrait
from relight_core.pipeline.quality import Tier
from relight_core.pipeline.relighter import Relighter

SIZE = 32
TIER = Tier(SIZE, SIZE, 16, 8, False)
FACE = FaceBox(4, 4, 28, 28)


@pytest.fixture(scope="module")
def held_out(tmp_path_factory):
    """A photo of a ball, the held-out lights, and a file of networks that all have a say."""
    folder = tmp_path_factory.mktemp("editor")
    write_balls(folder / "heads", 2_000_000, 1, size=SIZE)
    write_lights(folder / "lights.npz", 3)
    torch.manual_seed(0)
    bundle = NetworkBundle(BundleConfig.tiny())
    with torch.no_grad():
        for weight in bundle.parameters():
            if weight.ndim > 1:
                weight += 0.05 * torch.randn_like(weight)
    save_bundle(folder / "w.safetensors", bundle, half=False)
    lights = held_out_lights(folder / "lights.npz", "test")
    head = load_head(folder / "heads" / "head-2000000.npz", lights, held_out_textures())
    return head.photo(0, "clean"), lights, folder / "w.safetensors"


@pytest.fixture
def all_view(monkeypatch):
    """A photo is seen as it is, all of it."""
    view = Crop(SIZE / 2, SIZE / 2, float(SIZE))
    monkeypatch.setattr(relighter_module, "framed", lambda photo, *_: Portrait(photo, FACE, FACE, view, view))


@pytest.mark.usefixtures("all_view")
@pytest.mark.parametrize(
    "tier",
    [
        TIER,
        replace(TIER, mirrored=True, looks_twice=True),
        replace(TIER, correction=False),
        replace(TIER, shadow_network=False),
    ],
    ids=["all", "looks more than once", "no correction", "no shadow network"],
)
@pytest.mark.parametrize("has_lamp", [False, True], ids=["panorama", "lamp"])
def test_the_bench_makes_the_channels_that_the_editor_makes(held_out, tier, has_lamp):
    photo, lights, weights = held_out
    light = lamp(60.0, 35.0) if has_lamp else Environment.from_radiance(lights[1].radiance)
    relighter = Relighter(weights)
    relighter.set_portrait(Photo(photo), boxes=[FACE])
    expected = relighter.relight(light, Edit(quality=tier, tolerance=0.0)).channels
    bench = Editor(load_bundle(weights).for_inference(), ReflectionTable(), tier, "cpu")
    target = HeldOutLight("target", network_light(light), has_lamp, lamps_of(light, 0.0))
    assert bool(target.small_lamps) == has_lamp
    found = bench.relight(bench.take_apart(photo), target)
    for name in ("specular", "shadow", "composition"):
        np.testing.assert_allclose(found[name], np.squeeze(expected[name]), atol=2e-5, err_msg=name)
        assert found[name].max() > 0.01, name


def test_what_the_photo_s_light_is_told_to_be_is_told_from_what_the_network_guessed(held_out):
    photo, lights, weights = held_out
    bench = Editor(load_bundle(weights).for_inference(), ReflectionTable(), TIER, "cpu")
    seen = bench.look(photo)
    untold = bench.ready(seen).channels
    told = bench.ready(bench.told(seen, seen.surface, torch.from_numpy(lights[0].radiance)[None])).channels
    np.testing.assert_array_equal(told["source_light"], lights[0].radiance)
    np.testing.assert_array_equal(told["guess"], untold["guess"])
    assert not np.allclose(untold["source_light"], lights[0].radiance, rtol=0.1)
    assert not np.allclose(untold["guess"], untold["source_light"], rtol=0.1)
