"""relight train: a run is given what was asked for, and what ends it is told in words to act on."""

import cv2
import numpy as np
import pytest
import torch
from refusals import refused
from synthetic_heads import write_balls, write_lights

from relight_core.networks.bundle import BundleConfig, NetworkBundle, save_bundle
from relight_core.training import recipe, run
from relight_core.training.loop import TrainingDiverged


@pytest.fixture
def data(tmp_path):
    """Heads and lights to learn from, weights to begin from, and a folder of places."""
    write_lights(tmp_path / "lights.npz", 32)
    write_balls(tmp_path / "heads", 0, 1, size=32)
    (tmp_path / "places").mkdir()
    cv2.imwrite(str(tmp_path / "places" / "yard.hdr"), np.ones((8, 16, 3), np.float32))
    torch.manual_seed(0)
    save_bundle(tmp_path / "tiny.safetensors", NetworkBundle(BundleConfig.tiny()))
    return tmp_path


def words_of(data, **others):
    given = {"heads": data / "heads", "lights": data / "lights.npz", "output": data / "w.safetensors"} | others
    return ["train", *(word for name, value in given.items() for word in (f"--{name.replace('_', '-')}", value))]


def stopped_with(given):
    def stop(*arguments, **named):
        given.extend([arguments, named])
        raise KeyboardInterrupt

    return stop


def test_a_stage_is_trained_as_was_asked_for_and_else_as_usual(command_line, data, monkeypatch):
    given = []
    monkeypatch.setattr(run, "train", stopped_with(given))
    start = data / "tiny.safetensors"
    asked = {"minutes": 2.5, "size": 16, "pairs": 3, "seed": 7, "uses": 2, "window": 64, "workers": 5}
    words = words_of(data, stage="warm-delight", start=start, rate=3e-4, residual="0,1", decoder_residual="1", **asked)
    assert command_line(*words).code == 130
    settings = given[0][0]
    for name, value in asked.items():
        assert getattr(settings, name) == value, name
    assert (settings.stage, settings.start, settings.learning_rate) == ("warm-delight", start, 3e-4)
    assert (settings.residual, settings.decoder_residual) == ((0, 1), (1,))
    assert (settings.heads, settings.lights) == (data / "heads", data / "lights.npz")
    given.clear()
    assert command_line(*words_of(data, stage="outline", minutes=1, size=16, places=data / "places")).code == 130
    settings = given[0][0]
    assert (settings.places, settings.checkpoint) == (data / "places", data / "w.safetensors")
    assert (settings.pairs, settings.seed, settings.uses, settings.workers) == (8, 0, 1, 1)
    assert settings.learning_rate is None
    assert settings.start is None


def test_a_recipe_is_followed_with_the_workers_places_and_weights_that_were_given(command_line, data, monkeypatch):
    given = []
    monkeypatch.setattr(recipe, "follow", stopped_with(given))
    (data / "r.toml").write_text(
        '[[stage]]\nname = "outline"\nsteps = 2\n[[stage]]\nname = "warm-delight"\nsteps = 2\nsize = 32'
    )
    others = {"start": data / "tiny.safetensors", "workers": 4, "places": data / "places", "output": data / "run"}
    assert command_line(*words_of(data, recipe=data / "r.toml", **others)).code == 130
    (plan, heads, lights, folder, _, start), named = given
    assert [stage.name for stage in plan.stages] == ["outline", "warm-delight"]
    assert (heads, lights, folder, start) == (data / "heads", data / "lights.npz", data / "run", others["start"])
    assert named == {"workers": 4, "places": data / "places"}


def test_training_that_diverges_is_told_with_its_mend_and_is_no_fault_of_ours(command_line, data, monkeypatch):
    def diverge(*_):
        raise TrainingDiverged("20 non-finite batches in a row at step 7")

    monkeypatch.setattr(run, "train", diverge)
    done = command_line(*words_of(data, stage="warm-delight", minutes=1, size=16))
    refused(done, "w.safetensors: training stopped (20 non-finite", "try a lower learning rate")


def test_a_recipe_without_a_name_is_not_taken_for_a_stage(command_line, data):
    """As a shell's variable leaves it that is not set."""
    refused(command_line(*words_of(data, recipe="", output=data / "run")), "give a file or one of", "shipped")
