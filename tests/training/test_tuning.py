"""What fine-tuning does that warm-ups do not."""

import itertools

import pytest
import torch
from test_loop import budget, run, some_batch

from relight_core.imaging.tensor_colour import srgb_decode
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.training import stages
from relight_core.training.stages import STAGES


def statistics(bundle):
    return {name: value.clone() for name, value in bundle.named_buffers() if "running" in name}


@pytest.mark.parametrize(("name", "stays"), [("tune-delight", True), ("tune-relight", True), ("warm-delight", False)])
def test_tuning_keeps_the_statistics_that_the_editor_normalises_by(name, stays, tmp_path):
    torch.manual_seed(0)
    bundle = NetworkBundle(BundleConfig.tiny())
    before = statistics(bundle)
    assert before
    run(STAGES[name], itertools.repeat(some_batch()), budget(3), tmp_path / "w.safetensors", bundle)
    same = [torch.equal(value, before[part]) for part, value in statistics(bundle).items()]
    assert all(same) == stays


def terms_of(bundle, batch):
    torch.manual_seed(3)
    return STAGES["tune-delight"].losses(bundle, ReflectionTable(), batch)


def test_second_looks_are_learnt_from_in_a_share_of_the_steps(monkeypatch):
    bundle, batch = NetworkBundle(BundleConfig.tiny()).eval(), some_batch(pairs=2)
    monkeypatch.setattr(stages, "_SECOND_LOOK_SHARE", 0.0)
    once = terms_of(bundle, batch)
    monkeypatch.setattr(stages, "_SECOND_LOOK_SHARE", 1.0)
    twice = terms_of(bundle, batch)
    assert twice.keys() - once.keys() == {"second_albedo", "second_albedo_levelled", "second_albedo_edges"}
    bundle.requires_grad_(True)
    terms_of(bundle, batch)["second_albedo"].backward()
    assert any(weight.grad is not None and weight.grad.abs().max() > 0 for weight in bundle.delight.parameters())


def test_how_bright_an_albedo_is_costs_nothing_in_photos_that_are_brought_to_its_level(monkeypatch):
    bundle, batch = NetworkBundle(BundleConfig.tiny()).eval(), some_batch(pairs=2)
    batch["albedo"] = batch["albedo"] * 0.2
    monkeypatch.setattr(stages, "_SECOND_LOOK_SHARE", 0.0)

    def relit(share, gain):
        monkeypatch.setattr(stages, "_LEVELLED_SHARE", share)
        monkeypatch.setattr(stages, "srgb_decode", lambda encoded: gain * srgb_decode(encoded))
        with torch.no_grad():
            return float(terms_of(bundle, batch)["relit"])

    assert relit(1.0, 0.6) == pytest.approx(relit(1.0, 1.0), rel=1e-4)
    assert abs(relit(0.0, 0.6) - relit(0.0, 1.0)) > 0.01
