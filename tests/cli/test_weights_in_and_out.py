"""relight train: weights that go on from others, and what never happens to those."""

import pytest
import torch
from refusals import refused

from relight_core.networks.bundle import (
    BundleConfig,
    NetworkBundle,
    load_bundle,
    save_bundle,
    with_foreign_shadow_network,
    with_narrow_pair,
    with_person_network,
)
from relight_core.networks.foreign_shadow import ForeignShadowConfig, ForeignShadowNetwork
from relight_core.networks.pair import RelightingPair
from relight_core.networks.person import PersonConfig, PersonNetwork
from relight_core.training.loop import state_path


@pytest.fixture
def data(tmp_path):
    torch.manual_seed(0)
    save_bundle(tmp_path / "tiny.safetensors", NetworkBundle(BundleConfig.tiny()))
    return tmp_path


def test_networks_beside_the_first_three_are_joined_to_other_weights(command_line, data):
    tiny = load_bundle(data / "tiny.safetensors")
    narrow = with_narrow_pair(tiny, RelightingPair(tiny.config.wide.narrowed(2)))
    save_bundle(data / "narrow.safetensors", narrow)
    words = ["train", "--start", data / "tiny.safetensors", "-o", data / "both.safetensors", "--join"]
    done = command_line(*words, data / "narrow.safetensors")
    assert done.code == 0, done.err
    both = load_bundle(data / "both.safetensors")
    assert both.narrow.specular_shadow.config.width == 2
    assert torch.equal(both.delight.head.weight, tiny.delight.head.weight)
    person = with_person_network(tiny, PersonNetwork(PersonConfig(4, 3, 8)))
    save_bundle(data / "person.safetensors", person)
    assert command_line(*words, data / "person.safetensors").code == 0
    assert load_bundle(data / "both.safetensors").config.person == PersonConfig(4, 3, 8)
    save_bundle(data / "two.safetensors", with_person_network(narrow, PersonNetwork(PersonConfig(4, 3, 8))))
    assert command_line(*words, data / "two.safetensors").code == 0
    both = load_bundle(data / "both.safetensors")
    assert (both.config.narrow, both.config.person) == (narrow.config.narrow, PersonConfig(4, 3, 8))
    foreign = ForeignShadowNetwork(ForeignShadowConfig(4, 3, 8))
    save_bundle(data / "foreign.safetensors", with_foreign_shadow_network(tiny, foreign))
    assert command_line(*words, data / "foreign.safetensors").code == 0
    assert load_bundle(data / "both.safetensors").config.foreign_shadow == ForeignShadowConfig(4, 3, 8)
    refused(
        command_line(*words, data / "tiny.safetensors"),
        "no narrow pair, no person network and no foreign-shadow network",
    )
    refused(command_line(*words, data / "narrow.safetensors", "--workers", 3), "--workers: joining weights needs none")
    refused(command_line("train", "--join", data / "narrow.safetensors", "-o", data / "x.safetensors"), "--start")
    refused(command_line("train", "--stage", "warm-delight", "--minutes", 1, "-o", data / "x.safetensors"), "--heads")


def test_weights_are_never_written_over_those_they_are_made_from(command_line, data):
    tiny, before = data / "tiny.safetensors", (data / "tiny.safetensors").read_bytes()
    inputs = ["--heads", data, "--lights", tiny]
    refused(
        command_line("train", "--stage", "warm-delight", "--minutes", 1, *inputs, "--start", tiny, "-o", tiny),
        "over the weights",
    )
    refused(
        command_line("train", "--join", tiny, "--start", data / "other.safetensors", "-o", tiny), "over the weights"
    )
    assert tiny.read_bytes() == before


def test_weights_whose_training_has_ended_are_not_trained_over(command_line, data):
    tiny, before = data / "tiny.safetensors", (data / "tiny.safetensors").read_bytes()
    words = ["train", "--stage", "warm-delight", "--minutes", 1, "--heads", data, "--lights", data, "-o", tiny]
    refused(command_line(*words), "has ended", "--start")
    assert tiny.read_bytes() == before
    state_path(tiny).touch()
    refused(command_line(*words), "panorama")
