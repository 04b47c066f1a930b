"""What de-lighting is told of its errors: none where it finds the truth, and most where everyone looks."""

from dataclasses import replace

import pytest
import torch
from small_runs import some_batch

from relight_core.face.parsing import INDEX
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.training.delight_step import delight_losses

PAIRS, SIZE = 2, 16


def encoded(linear):
    return torch.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def losses_of(batch, **wrong):
    """Of a network that finds the truth of every photo but for what is wrong, each part given in the truth's place."""
    torch.manual_seed(0)
    network = NetworkBundle(BundleConfig.tiny()).eval().delight
    twice = {name: batch[name].repeat_interleave(2, 0) for name in ("albedo", "normal", "relief")}
    # Heights are counted in 64 pixels, the truth in half-widths of the picture.
    found = {
        "albedo_srgb": encoded(twice["albedo"]),
        "normal": twice["normal"],
        "relief": twice["relief"] * (SIZE / 2) / 64,
        "light": batch["light"].flatten(0, 1),
    }
    network.register_forward_hook(lambda network, given, said: replace(said, **found | wrong))
    with torch.no_grad():
        return {name: float(loss) for name, loss in delight_losses(network, ReflectionTable(), batch)[1].items()}


@pytest.fixture
def batch():
    torch.manual_seed(1)
    return some_batch(pairs=PAIRS)


def test_who_finds_the_truth_is_told_of_no_error_but_in_the_parsing(batch):
    losses = losses_of(batch)
    assert losses.pop("parsing") > 0
    assert set(losses) >= {"albedo", "albedo_levelled", "normal", "relief", "horizon", "light", "irradiance"}
    assert max(losses.values()) < 1e-3


@pytest.mark.parametrize(
    ("part", "told"),
    [
        ("albedo_srgb", {"albedo", "albedo_levelled", "albedo_edges"}),
        ("normal", {"normal", "normal_edges"}),
        ("relief", {"relief", "horizon"}),
        ("light", {"light", "irradiance"}),
    ],
)
def test_an_error_is_told_of_its_own_part_alone(batch, part, told):
    generator = torch.Generator().manual_seed(2)
    shapes = {"light": (2 * PAIRS, 16, 32, 3), "relief": (2 * PAIRS, 1, SIZE, SIZE)}
    drawn = torch.rand(shapes.get(part, (2 * PAIRS, 3, SIZE, SIZE)), generator=generator)
    losses = losses_of(batch, **{part: drawn})
    assert {name for name, loss in losses.items() if loss > 1e-2} - {"parsing"} == told


def test_a_face_counts_twice_as_much_as_hair_and_nothing_where_nobody_is(batch):
    batch["covered"] = torch.ones(PAIRS, 1, SIZE, SIZE)
    batch["covered"][..., 12:] = 0
    batch["label"][:] = INDEX["hair"]
    batch["label"][..., 6:12] = INDEX["nose"]
    truth, told = encoded(batch["albedo"].repeat_interleave(2, 0)), {}
    for name, columns in (("hair", slice(0, 6)), ("face", slice(6, 12)), ("nobody", slice(12, 16))):
        off = truth.clone()
        off[..., columns] += 0.1
        told[name] = losses_of(batch, albedo_srgb=off)["albedo"]
    assert told["face"] == pytest.approx(2 * told["hair"], rel=1e-3)
    assert told["hair"] > 0.01
    assert told["nobody"] == pytest.approx(0, abs=1e-6)
