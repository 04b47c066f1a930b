"""What SS and composition learn: each channel from its own truth, and of a shadow what the editor would show."""

from dataclasses import replace

import pytest
import torch

from relight_core.face.parsing import INDEX
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.training.relight_steps import composition_losses, specular_shadow_losses, with_reflected

SIZE = 16


def batch(relief_shadow):
    """A patch of bare skin facing a light from everywhere."""
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, INDEX["skin"]] = 1
    normal = torch.zeros(1, 3, SIZE, SIZE)
    normal[:, 2] = 1
    flat = {
        "normal": normal,
        "albedo": torch.full((1, 3, SIZE, SIZE), 0.5),
        "covered": torch.ones(1, 1, SIZE, SIZE),
        "light": torch.ones(1, 16, 32, 3),
        "parsing": parsing,
        "relief": torch.zeros(1, 1, SIZE, SIZE),
        "image": torch.full((1, 3, SIZE, SIZE), 0.2),
        "relief_shadow": torch.full((1, 1, SIZE, SIZE), relief_shadow),
    }
    names = ("specular", "shadow", "shadow_fraction", "gloss_fraction")
    return with_reflected(ReflectionTable(), flat | {name: torch.full((1, 1, SIZE, SIZE), 0.3) for name in names})


def shown(by_relief, **specular_shadow):
    """The mean shadow that composition reads, and the one that SS says, which is configured like this."""
    torch.manual_seed(0)
    config = BundleConfig.tiny()
    config = replace(config, specular_shadow=replace(config.specular_shadow, **specular_shadow))
    bundle, read = NetworkBundle(config).eval(), {}
    network, table, flat = bundle.composition, ReflectionTable(), batch(by_relief)

    def reads(_, inputs):
        read["shadow"] = float(inputs[3].mean())

    network.register_forward_pre_hook(reads)
    with torch.no_grad():
        effects, _ = specular_shadow_losses(bundle.specular_shadow, table, flat)
        composition_losses(network, table, flat, effects)
    return read["shadow"], float(effects.shadow.mean())


def test_what_the_relief_hides_for_certain_is_not_shown():
    read, said = shown(0.95)
    assert said > 0.3
    assert read < 0.3 * said


def test_where_the_relief_hides_little_all_of_it_is_shown():
    read, said = shown(0.2)
    assert read == said > 0


def test_networks_without_a_relief_learn_from_the_whole_shadow_that_they_are_shown_when_they_relight():
    read, said = shown(0.95, relief_shadow=False, additive=True)
    assert read == said > 0


def test_every_channel_is_compared_with_its_own_truth_and_gloss_counts_twice_what_shadow_does():
    torch.manual_seed(0)
    bundle, table, flat = NetworkBundle(BundleConfig.tiny()).eval(), ReflectionTable(), batch(0.4)
    with torch.no_grad():
        effects, _ = specular_shadow_losses(bundle.specular_shadow, table, flat)
        image, _ = composition_losses(bundle.composition, table, flat, effects)
        flat |= {"specular": effects.specular, "shadow": effects.shadow - 0.1, "image": image}
        _, losses = specular_shadow_losses(bundle.specular_shadow, table, flat)
        _, of_picture = composition_losses(bundle.composition, table, flat, effects)
        assert float(losses["specular"]) == pytest.approx(0, abs=1e-6)
        assert float(losses["shadow"]) == pytest.approx(0.5, rel=1e-3)
        assert [float(value) for value in of_picture.values()] == pytest.approx([0, 0], abs=1e-6)
        flat |= {"specular": effects.specular + 0.1, "shadow": effects.shadow, "image": image + 0.2}
        _, losses = specular_shadow_losses(bundle.specular_shadow, table, flat)
        _, of_picture = composition_losses(bundle.composition, table, flat, effects)
    assert float(losses["specular"]) == pytest.approx(1, rel=1e-3)
    assert float(losses["shadow"]) == pytest.approx(0, abs=1e-6)
    assert min(of_picture.values()) > 0.01


def test_hair_and_cloth_shine_less_than_skin_to_networks_that_learn_as_well():
    gloss = {}
    for name in ("skin", "cloth"):
        flat = {key: value for key, value in batch(0.4).items() if key != "reflected"}
        flat["parsing"] = torch.zeros(1, 14, SIZE, SIZE)
        flat["parsing"][:, INDEX[name]] = 1
        gloss[name] = float(with_reflected(ReflectionTable(), flat)["reflected"][:, 3:].mean())
    assert gloss["cloth"] < 0.5 * gloss["skin"]
