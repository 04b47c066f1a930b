"""The bench's own arithmetic: who knows the truth makes no error, who mixes up the lights does."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch
from synthetic_heads import write_balls, write_lights

from relight_core.evaluation.bench import Bench, Editor
from relight_core.evaluation.held_out import Case, held_out_lights, held_out_textures, load_head
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.pipeline.quality import Tier

NO_ERROR = ("albedo.rmse", "normal.rmse", "normal.angle_deg", "light.wlog_l2", "relit.rmse", "specular.rmse")
CASE = Case(source=0, target=2)


@pytest.fixture(scope="module")
def held_out(tmp_path_factory):
    folder = tmp_path_factory.mktemp("oracle")
    write_balls(folder / "heads", 2_000_000, 1, size=16)
    write_lights(folder / "lights.npz", 3)
    lights = held_out_lights(folder / "lights.npz", "test")
    return load_head(folder / "heads" / "head-2000000.npz", lights, held_out_textures()), lights


class Oracle(Editor):
    """Says what is true: of the surface and of the photo's light, and of any picture it is asked for."""

    def knowing(self, head, lights, source):
        self.__dict__.update(head=head, lights=lights, source=source)
        return self

    def take_apart(self, photo):
        light = self.lights[self.source].radiance
        channels = self.head.surface() | {"guess": light, "source_light": light}
        return SimpleNamespace(seen=SimpleNamespace(photo=photo), channels=channels)

    def relight(self, found, target):
        number = next(i for i, light in enumerate(self.lights) if light is target)
        true = self.head.channels(number)
        return {"composition": true["image"], "specular": true["specular"], "shadow": true["shadow"]}


def scored(held_out, source, case=CASE):
    torch.manual_seed(0)
    bundle = NetworkBundle(BundleConfig.tiny()).for_inference()
    oracle = Oracle(bundle, ReflectionTable(), Tier(16, 16, 16, 8, False), "cpu").knowing(*held_out, source)
    return Bench(oracle, *held_out, "clean").score(case)


def test_the_truth_has_no_error(held_out):
    figures = scored(held_out, CASE.source)
    for group in ("panoramas", "face"):
        for name in NO_ERROR:
            assert figures[group][name] == pytest.approx(0, abs=1e-3), (group, name)
        assert figures[group]["relit.psnr"] > 60
        assert figures[group]["relit.ssim"] == pytest.approx(1, abs=1e-4)
    # Networks that know nothing are not spared by what the editor around them knows.
    assert figures["true surface, panoramas"]["relit.rmse"] > 0.01


def test_the_source_is_what_the_light_is_compared_with(held_out):
    figures = scored(held_out, CASE.target)["panoramas"]
    assert figures["light.wlog_l2"] > 0.01
    assert figures["relit.rmse"] == pytest.approx(0, abs=1e-3)


def test_a_photo_left_as_it_is_has_the_error_that_is_said_of_it(held_out):
    head, _ = held_out
    unchanged = scored(held_out, 0)["panoramas"]["relit.rmse_of_unchanged_photo"]
    photo, truth = head.photo(0, "clean"), head.channels(2)["image"] * head.exposure(2)
    shown = np.clip([photo, truth], 0, 1)
    encoded = np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * shown ** (1 / 2.4) - 0.055)
    covered = head.lit.head.covered
    assert unchanged == pytest.approx(np.sqrt(np.mean((encoded[0] - encoded[1])[covered] ** 2)), rel=1e-4)
    assert unchanged > 0.01


def test_single_lamps_are_a_group_of_their_own(held_out):
    figures = scored(held_out, 0, Case(0, 5))
    assert set(figures) == {"lamps", "true surface, lamps"}
    assert figures["lamps"]["shadow.rmse"] == pytest.approx(0, abs=1e-6)
