"""relight train: weights that go on from others, and what never happens to those."""

import pytest
import torch

from app.cli.main import main
from relight_core.networks.bundle import (
    BundleConfig,
    NetworkBundle,
    load_bundle,
    save_bundle,
    with_narrow_pair,
    with_person_network,
)
from relight_core.networks.pair import RelightingPair
from relight_core.networks.person import PersonConfig, PersonNetwork


@pytest.fixture
def data(tmp_path):
    torch.manual_seed(0)
    save_bundle(tmp_path / "tiny.safetensors", NetworkBundle(BundleConfig.tiny()))
    return tmp_path


@pytest.fixture
def run(capfd):
    def run(*words):
        code = main([str(word) for word in words])
        return code, capfd.readouterr().err

    return run


def refused(result, words):
    code, err = result
    assert code == 2
    assert words in err.strip().splitlines()[-1]


def test_a_narrow_pair_and_a_person_network_are_joined_to_other_weights(run, data):
    tiny = load_bundle(data / "tiny.safetensors")
    narrow = with_narrow_pair(tiny, RelightingPair(tiny.config.wide.narrowed(2)))
    save_bundle(data / "narrow.safetensors", narrow)
    words = ["train", "--start", data / "tiny.safetensors", "-o", data / "both.safetensors", "--join"]
    code, err = run(*words, data / "narrow.safetensors")
    assert code == 0, err
    both = load_bundle(data / "both.safetensors")
    assert both.narrow.specular_shadow.config.width == 2
    assert torch.equal(both.delight.head.weight, tiny.delight.head.weight)
    person = with_person_network(tiny, PersonNetwork(PersonConfig(4, 3, 8)))
    save_bundle(data / "person.safetensors", person)
    assert run(*words, data / "person.safetensors")[0] == 0
    assert load_bundle(data / "both.safetensors").config.person == PersonConfig(4, 3, 8)
    refused(run(*words, data / "tiny.safetensors"), "neither a narrow pair nor a person network")
    refused(run("train", "--join", data / "narrow.safetensors", "-o", data / "x.safetensors"), "--start")
    refused(run("train", "--stage", "warm-delight", "--minutes", 1, "-o", data / "x.safetensors"), "--heads")


def test_weights_are_never_written_over_those_they_are_made_from(run, data):
    tiny, before = data / "tiny.safetensors", (data / "tiny.safetensors").read_bytes()
    inputs = ["--heads", data, "--lights", tiny]
    refused(
        run("train", "--stage", "warm-delight", "--minutes", 1, *inputs, "--start", tiny, "-o", tiny),
        "over the weights",
    )
    refused(run("train", "--join", tiny, "--start", data / "other.safetensors", "-o", tiny), "over the weights")
    assert tiny.read_bytes() == before
