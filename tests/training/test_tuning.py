"""What fine-tuning does that warm-ups do not."""

import itertools
from dataclasses import replace

import pytest
import torch
from small_runs import budget, run, some_batch

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


@pytest.mark.parametrize(("pairs", "again"), [(1, 1), (2, 1), (5, 2), (6, 2)])
def test_one_pair_in_three_is_looked_at_twice(pairs, again):
    bundle = NetworkBundle(BundleConfig.tiny()).eval()
    photos = []
    bundle.delight.register_forward_pre_hook(lambda network, given: photos.append(len(given[0])))
    losses = terms_of(bundle, some_batch(pairs=pairs))
    assert photos == [2 * pairs, again]
    bundle.requires_grad_(True)
    for name in ("second_albedo", "second_albedo_levelled", "second_albedo_edges"):
        terms_of(bundle, some_batch(pairs=2))[name].backward()
        assert any(weight.grad is not None and weight.grad.abs().max() > 0 for weight in bundle.delight.parameters())
        assert losses[name] > 0
        bundle.zero_grad()


def test_however_many_pairs_a_second_look_weighs_a_third_of_a_first_one():
    bundle, batch = NetworkBundle(BundleConfig.tiny()).eval(), some_batch(pairs=1)
    bundle.delight.register_forward_hook(lambda network, given, found: replace(found, albedo_srgb=given[0] * 0 + 0.5))
    for pairs in (1, 6):
        losses = terms_of(bundle, {name: value.repeat_interleave(pairs, 0) for name, value in batch.items()})
        for name in ("albedo", "albedo_levelled", "albedo_edges"):
            assert float(losses[f"second_{name}"]) == pytest.approx(float(losses[name]) / 3, rel=1e-4)


def test_how_bright_an_albedo_is_costs_nothing_in_photos_that_are_brought_to_its_level(monkeypatch):
    bundle, batch = NetworkBundle(BundleConfig.tiny()).eval(), some_batch(pairs=2)
    batch["albedo"] = batch["albedo"] * 0.2

    def relit(share, gain):
        monkeypatch.setattr(stages, "_LEVELLED_SHARE", share)
        monkeypatch.setattr(stages, "srgb_decode", lambda encoded: gain * srgb_decode(encoded))
        with torch.no_grad():
            return float(terms_of(bundle, batch)["relit"])

    assert relit(1.0, 0.6) == pytest.approx(relit(1.0, 1.0), rel=1e-4)
    assert abs(relit(0.0, 0.6) - relit(0.0, 1.0)) > 0.01


@pytest.mark.parametrize("name", ["tune-delight", "tune-on-predictions"])
def test_every_photo_is_relit_with_the_other_light_of_its_pair_on_the_surface_that_is_found_in_it(name):
    torch.manual_seed(2)
    bundle, batch, read = NetworkBundle(BundleConfig.tiny()).eval(), some_batch(pairs=2), {}

    def reads(network, given):
        read["normal"], read["light"] = given[1], given[5]

    bundle.composition.register_forward_pre_hook(reads)
    with torch.no_grad():
        STAGES[name].losses(bundle, ReflectionTable(), batch)
        found = bundle.delight(batch["photo_srgb"].flatten(0, 1)).normal
    assert torch.equal(read["light"], batch["light"].flip(1).flatten(0, 1))
    torch.testing.assert_close(read["normal"], torch.nn.functional.normalize(found, dim=1), atol=1e-3, rtol=0)


@pytest.mark.parametrize(
    ("name", "together"), [("warm-relight", False), ("tune-relight", False), ("tune-on-predictions", True)]
)
def test_the_shadow_network_learns_from_the_picture_only_where_the_paper_tunes_both(name, together):
    torch.manual_seed(2)
    bundle, table, stage = NetworkBundle(BundleConfig.tiny()).eval(), ReflectionTable(), STAGES[name]
    batch = some_batch()
    losses = stage.losses(bundle, table, stage.prepare(bundle, table, batch) if stage.prepare else batch)
    (losses["encoded"] + losses["display"]).backward()

    def learns(network):
        return any(weight.grad is not None and weight.grad.abs().max() > 0 for weight in network.parameters())

    assert learns(bundle.composition)
    assert learns(bundle.specular_shadow) == together


def test_the_relit_picture_counts_three_times_where_de_lighting_is_tuned_strongly():
    bundle, batch, relit = NetworkBundle(BundleConfig.tiny()).eval(), some_batch(), []
    for name in ("tune-delight", "tune-delight-strongly"):
        torch.manual_seed(3)
        with torch.no_grad():
            relit.append(float(STAGES[name].losses(bundle, ReflectionTable(), batch)["relit"]))
    assert relit[1] == pytest.approx(3 * relit[0])


def test_a_shadow_network_of_which_composition_is_told_nothing_learns_by_itself_alone():
    tiny = BundleConfig.tiny()
    deaf = replace(tiny, composition=replace(tiny.composition, effects=False))
    both = ("specular_shadow", "composition")
    assert [STAGES["warm-relight"].learners(config) for config in (tiny, deaf)] == [both, ("composition",)]
    for config in (tiny, deaf):
        assert STAGES["warm-specular-shadow"].learners(config) == ("specular_shadow",)
        assert STAGES["warm-delight"].learners(config) == ("delight",)
