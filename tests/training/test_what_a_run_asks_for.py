"""What a run's settings become: its budget, its networks, and what decides its batches."""

from pathlib import Path

import pytest
import torch

from relight_core.networks.blocks import ResidualBlock
from relight_core.networks.bundle import BundleConfig, NetworkBundle, save_bundle
from relight_core.training import run as run_module
from relight_core.training.run import Run, denormals_flushed, drawn_by, train

pytestmark = pytest.mark.usefixtures("seeded")


@pytest.fixture
def begun(tmp_path, monkeypatch):
    """Trains nothing; gives the networks and the budget that a run of a stage would begin with."""
    start = tmp_path / "start.safetensors"
    save_bundle(start, NetworkBundle(BundleConfig.tiny()))
    monkeypatch.setattr(run_module, "train_stage", lambda stage, bundle, batches, budget, *_: (bundle, budget))

    def begin(stage, **settings):
        return train(Run(stage, tmp_path, tmp_path, tmp_path / "w.safetensors", start, **settings), print)

    return begin


def test_the_learning_rate_is_the_stage_s_own_or_the_one_that_is_asked_for(begun):
    assert begun("warm-delight", steps=9)[1].learning_rate == 1.5e-3
    assert begun("tune-delight-strongly", steps=9)[1].learning_rate == 4e-4
    assert begun("tune-delight-strongly", steps=9, learning_rate=1e-4)[1].learning_rate == 1e-4


@pytest.mark.parametrize(
    ("length", "rise"),
    [({"steps": 5}, 1), ({"steps": 90}, 9), ({"steps": 2000}, 200), ({"steps": 9000}, 200), ({"minutes": 1.0}, 200)],
)
def test_the_learning_rate_rises_over_a_tenth_of_a_short_run(begun, length, rise):
    budget = begun("warm-delight", **length)[1]
    assert budget.warm_up_steps == rise
    assert (budget.steps, budget.minutes) == (length.get("steps"), length.get("minutes"))


def test_blocks_that_are_added_begin_as_their_stage_normalises(begun):
    asked = {"residual": (0, 0, 1), "steps": 9}
    blocks = {}
    for stage in ("warm-delight", "tune-delight-strongly"):
        parts = begun(stage, **asked)[0].delight.modules()
        (blocks[stage],) = (part for part in parts if isinstance(part, ResidualBlock))
    # By a batch's own statistics: the scale is nothing, and learns.
    assert not blocks["warm-delight"].second.norm.weight.any()
    assert blocks["warm-delight"].second.conv.weight.any()
    # By running ones: the convolution is nothing.
    assert torch.all(blocks["tune-delight-strongly"].second.norm.weight == 1)
    assert not blocks["tune-delight-strongly"].second.conv.weight.any()


def test_how_often_pairs_are_used_and_from_how_many_decides_the_batches():
    run = {"stage": "warm-delight", "heads": Path("h"), "lights": Path("l"), "checkpoint": Path("w"), "steps": 9}
    drawn = {"size": 64, "pairs": 6, "seed": 5, "workers": 1}
    once, again = ({"size": 64, "pairs": 6, "seed": 5, "uses": uses, "window": 12} for uses in (1, 3))
    assert drawn_by(Run(**run, **once)) == drawn | {"uses": 1}
    assert drawn_by(Run(**run, **again)) == drawn | {"uses": 3, "window": 12}
    # Made between the steps, they are those that one worker makes.
    assert drawn_by(Run(**run, **once, workers=0)) == drawn | {"uses": 1}
    assert drawn_by(Run(**run, **once, workers=3)) == drawn | {"workers": 3, "uses": 1}


def test_denormals_are_flushed_for_the_time_of_the_training_alone():
    denormal, flushed = torch.full((8,), 1e-40), []

    @denormals_flushed()
    def stopped():
        flushed.append(not (denormal * 1).any())
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stopped()
    assert flushed == [True]
    assert (denormal * 1).all()
