"""Tiers that use another width of the relighting networks: which one runs, and that results never mix."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from tiny_networks import write_tiny_weights
from tiny_relighter import EDIT, computed, some_light, some_photo

from relight_core.networks.bundle import load_bundle, save_bundle, with_narrow_pair
from relight_core.networks.pair import RelightingPair
from relight_core.pipeline.quality import TIERS, Tier
from relight_core.pipeline.relighter import Relighter

WIDE = replace(EDIT, quality=Tier(64, 32, 32, 16, False))
NARROW = replace(EDIT, quality=Tier(64, 32, 32, 16, False, pair="narrow"))


@pytest.fixture
def both(tmp_path, small_and_seeing_faces):
    """A file whose two pairs of networks don't agree."""
    bundle = load_bundle(write_tiny_weights(tmp_path))
    torch.manual_seed(11)
    narrow = RelightingPair(bundle.config.wide.narrowed(2))
    narrow.composition.head.weight.data.normal_(0, 0.1)
    save_bundle(tmp_path / "both.safetensors", with_narrow_pair(bundle, narrow))
    relighter = Relighter(tmp_path / "both.safetensors")
    relighter.set_portrait(some_photo())
    return relighter


def alone(tmp_path, edit, name="both"):
    relighter = Relighter(tmp_path / f"{name}.safetensors")
    relighter.set_portrait(some_photo())
    return relighter.relight(some_light(), edit).image


def test_each_tier_runs_its_own_networks_whatever_ran_before(both, tmp_path):
    narrow, wide = alone(tmp_path, NARROW), alone(tmp_path, WIDE)
    assert np.abs(narrow - wide).max() > 1e-3
    for edit, image in ((WIDE, wide), (NARROW, narrow), (WIDE, wide), (NARROW, narrow)):
        np.testing.assert_array_equal(both.relight(some_light(), edit).image, image)


def test_changing_over_takes_nothing_apart_again(both):
    both.relight(some_light(), WIDE)
    changed = both.relight(some_light(), NARROW)
    assert {"specular_shadow", "compose", "begun"} <= computed(changed)
    assert not computed(changed) & {"delight", "relief", "normals", "albedo", "view"}


def test_a_file_of_one_pair_gives_the_same_picture_at_both(tmp_path, both):
    np.testing.assert_array_equal(alone(tmp_path, NARROW, "tiny"), alone(tmp_path, WIDE, "tiny"))


def test_live_is_narrow_and_final_is_wide():
    assert (TIERS["live"].pair, TIERS["final"].pair) == ("narrow", "wide")
    assert TIERS["live"].shadow_network
    assert TIERS["live"].correction
