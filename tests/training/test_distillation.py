"""A narrow pair of relighting networks learns what the wide one says, and nothing else changes."""

import contextlib
import functools
import itertools
import shutil
from dataclasses import replace

import pytest
import torch
from small_runs import quiet, some_batch

from relight_core.errors import InputError
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import BundleConfig, NetworkBundle, load_bundle, save_bundle
from relight_core.training import run as run_module
from relight_core.training.distillation import Teacher, distillation_losses, under_some_lights
from relight_core.training.recipe import load_recipe
from relight_core.training.run import Run, train
from relight_core.training.stages import STAGES


@pytest.fixture
def start(tmp_path):
    """Untrained networks that see a person everywhere."""
    torch.manual_seed(7)
    bundle = NetworkBundle(BundleConfig.tiny())
    bundle.composition.head.weight.data.normal_(0, 0.05)
    bundle.delight.head.bias.data[8] = 6.0
    bundle.delight.head.bias.data[9] = -0.0
    save_bundle(tmp_path / "start.safetensors", bundle, half=False)
    return tmp_path / "start.safetensors"


@pytest.fixture
def made(monkeypatch):
    """Batches without heads or lights, and how many were made."""
    numbers = []

    def batches(run, stage, first_batch):
        for number in itertools.count(first_batch):
            numbers.append(number)
            with torch.random.fork_rng():
                torch.manual_seed(number)
                batch = some_batch(pairs=2)
            yield batch

    monkeypatch.setattr(run_module, "training_batches", batches)
    return numbers


def run_of(start, place, **settings):
    settings = {"steps": 30, "size": 16, "pairs": 2, "narrow_width": 4, "examples": 2, "learning_rate": 4e-3} | settings
    return Run("distil-relight", place, place, place / "narrow.safetensors", start=start, **settings)


def error(bundle, examples):
    """What the narrow pair misses of the wide pair's answers."""
    torch.manual_seed(0)
    with torch.no_grad():
        losses = distillation_losses(bundle.eval(), ReflectionTable(), examples)
    return float(sum(losses[name] for name in ("specular", "shadow", "encoded", "display")))


def test_it_comes_nearer_to_the_wide_pair_on_surfaces_it_has_not_seen(start, made, tmp_path):
    torch.manual_seed(99)
    unseen = Teacher(load_bundle(start), ReflectionTable()).examples(some_batch(pairs=2))
    short, long = (train(run_of(start, tmp_path / str(n), steps=n, narrow_width=8), quiet) for n in (1, 25))
    assert error(long, unseen) < 0.7 * error(short, unseen)


def test_only_the_narrow_pair_changes_and_examples_are_made_once_and_gone_at_the_end(start, made, tmp_path):
    before, after = load_bundle(start), train(run_of(start, tmp_path, steps=4), quiet)
    assert after.config.narrow is not None
    for name, value in before.state_dict().items():
        assert torch.equal(after.state_dict()[name], value), name
    assert made == [0, 1]
    assert not list(tmp_path.glob("*.examples"))


def test_examples_that_runs_share_stay_and_serve_the_same_teacher_again(start, made, tmp_path):
    other = load_bundle(start)
    other.specular_shadow.head.bias.data += 1
    save_bundle(tmp_path / "other.safetensors", other)
    for number, place in enumerate((start, tmp_path / "0" / "narrow.safetensors", tmp_path / "other.safetensors")):
        train(run_of(place, tmp_path / str(number), steps=4, examples=1, kept=tmp_path / "kept"), quiet)
    assert made == [0, 0]


def test_an_example_is_a_photo_under_its_own_light_and_the_next_three_with_what_they_do_to_it(start):
    batch = some_batch(pairs=3)
    lights = batch["light"].flatten(0, 1)
    examples = Teacher(load_bundle(start), ReflectionTable()).examples(batch)
    assert examples["light"].shape == (6, 4, 16, 32, 3)
    for first, own in enumerate(examples["light"]):
        for beyond, light in enumerate(own):
            assert torch.equal(light, lights[(first + beyond) % 6])
    for name in ("image", "reflected", "relief_shadow", "specular", "shadow", "shadow_fraction", "gloss_fraction"):
        assert examples[name].shape[:2] == (6, 4), name
        assert torch.isfinite(examples[name]).all(), name


def test_some_lights_of_an_example_stay_with_its_surface():
    place = torch.arange(3)[:, None] * 10 + torch.arange(4)[None]
    batch = {
        "light": place[..., None, None, None].expand(3, 4, 16, 32, 3),
        "image": place[..., None, None, None].expand(3, 4, 3, 2, 2),
        "albedo": torch.arange(3)[:, None, None, None].expand(3, 3, 2, 2),
    }
    drawn = set()
    for seed in range(20):
        torch.manual_seed(seed)
        flat = under_some_lights(batch)
        light, image, albedo = (flat[name].flatten(1)[:, 0] for name in ("light", "image", "albedo"))
        assert torch.equal(light, image)
        assert torch.equal(light // 10, albedo)
        assert albedo.tolist() == [0, 1, 2]
        drawn |= set((light % 10).tolist())
    assert drawn == {0, 1, 2, 3}


class Killed(Exception):
    pass


@pytest.fixture
def killed_after_three(monkeypatch):
    """Runs that end after their third batch, with a state kept after every step."""
    learnt = run_module.train_stage

    def stops(stage, bundle, batches_from, budget, checkpoint, report, device, drawn_by):
        def some(first):
            yield from itertools.islice(batches_from(first), 3)
            raise Killed

        budget = replace(budget, warm_up_steps=1, checkpoint_seconds=0.0)
        return learnt(stage, bundle, some, budget, checkpoint, report, device, drawn_by)

    def train_some(run):
        with monkeypatch.context() as patched:
            patched.setattr(run_module, "train_stage", stops)
            with pytest.raises(Killed):
                train(run, quiet)

    return train_some


def test_a_run_that_was_killed_goes_on_as_if_it_had_not_been(start, made, killed_after_three, tmp_path, monkeypatch):
    whole = train(run_of(start, tmp_path / "whole", steps=5), quiet).state_dict()
    killed_after_three(run_of(start, tmp_path / "halves", steps=5))
    monkeypatch.setattr(Teacher, "examples", lambda *_: pytest.fail("the examples are there"))
    halves = train(run_of(start, tmp_path / "halves", steps=5), quiet).state_dict()
    for name, value in whole.items():
        torch.testing.assert_close(halves[name], value, rtol=0, atol=0)


def test_a_run_whose_budget_is_spent_needs_no_examples_to_end(start, made, killed_after_three, tmp_path):
    killed_after_three(run_of(start, tmp_path, steps=5))
    (examples,) = tmp_path.glob("*.examples")
    shutil.rmtree(examples)
    train(run_of(start, tmp_path, steps=1), quiet)
    assert not list(tmp_path.glob("*.state*"))
    assert made == [0, 1]


@pytest.mark.parametrize("other", [{"workers": 2}, {"uses": 2}, {"heads": "others"}])
def test_examples_of_other_samples_that_a_killed_run_has_left_are_not_learnt_from(start, made, tmp_path, other):
    heads = tmp_path / "others"
    heads.mkdir()
    (heads / "head-0000001.npz").write_bytes(b"a head")
    begun = run_of(start, tmp_path, steps=4)
    examples = functools.partial(run_module._example_batches, stage=STAGES["distil-relight"], device="cpu")
    with contextlib.suppress(Killed), examples(begun, bundle=load_bundle(start)) as batches_from:
        next(batches_from(0))
        raise Killed
    assert made == [0]
    train(replace(begun, **{name: heads if name == "heads" else value for name, value in other.items()}), quiet)
    assert made == [0, 0, 1]


def test_a_pair_that_is_there_goes_on_learning(start, made, tmp_path):
    first = train(run_of(start, tmp_path, steps=1), quiet)
    second = train(run_of(tmp_path / "narrow.safetensors", tmp_path / "2", steps=4, narrow_width=None), quiet)
    assert second.config == first.config
    moved = (second.narrow.specular_shadow.head.weight - first.narrow.specular_shadow.head.weight).abs().max()
    assert 0 < moved < 0.1


def test_light_is_read_as_the_wide_pair_reads_it(start):
    from relight_core.networks.bundle import with_narrow_width

    bundle = with_narrow_width(load_bundle(start), 2)
    for mine, given in zip(
        reversed(bundle.narrow.specular_shadow.modulations), reversed(bundle.specular_shadow.modulations), strict=False
    ):
        assert torch.equal(mine.fc1.weight, given.fc1.weight)


def test_networks_that_nobody_taught_teach_nobody(made, tmp_path):
    with pytest.raises(InputError, match="weights to start from"):
        train(run_of(None, tmp_path), quiet)


def test_the_shipped_recipe_ends_with_a_narrow_pair():
    assert load_recipe("shipped").stages[-1].name == "distil-relight"
