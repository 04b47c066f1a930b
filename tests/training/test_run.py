"""A run's batches."""

import itertools
import os
import signal
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
import torch
from small_runs import some_batch
from torch.utils.data import IterableDataset

from relight_core.errors import InputError
from relight_core.networks.bundle import BundleConfig, NetworkBundle, save_bundle
from relight_core.training import run as run_module
from relight_core.training.loop import Budget, state_path
from relight_core.training.run import Run, train, training_batches
from relight_core.training.stages import STAGES


class Numbers(IterableDataset):
    def __init__(self, *_, first_batch, **__):
        self.first = first_batch

    def __iter__(self):
        return iter([{"number": torch.tensor(self.first + n)} for n in range(8)])


class Damaged(IterableDataset):
    def __init__(self, *_, **__):
        pass

    def __iter__(self):
        raise InputError("head.npz: damaged; bake it again")


class Stopped(Exception):
    """As a run is by its user."""


class Pairs(IterableDataset):
    def __init__(self, *_, first_batch, pairs, **__):
        self.first, self.pairs = first_batch, pairs

    def __iter__(self):
        for number in itertools.count(self.first * self.pairs):
            told = torch.full((3, 2, 2), float(number))
            yield {"normal": told, "label": torch.zeros(2, 2, dtype=torch.long)}


def test_pairs_that_are_used_again_come_in_batches_of_the_size_that_was_asked_for(monkeypatch):
    monkeypatch.setattr(run_module, "SampleStream", Pairs)
    run = Run("warm-delight", Path("heads"), Path("lights"), Path("w"), steps=9, pairs=6, workers=0, uses=3, window=12)

    def some(first, count):
        batches = itertools.islice(training_batches(run, STAGES["warm-delight"], first), count)
        return [batch["normal"][:, 1, 0, 0].cpu().tolist() for batch in batches]

    whole = some(0, 12)
    assert all(len(set(batch)) == 6 for batch in whole)
    # 8 pairs come at once and then 2 a batch, in fours.
    assert max(max(batch) for batch in whole) < 8 + 24
    assert len({number for batch in whole for number in batch}) > 16
    assert some(7, 5) == whole[7:]


@pytest.mark.parametrize(("uses", "kinds"), [(1, (torch.float32, torch.int64)), (3, (torch.float16, torch.uint8))])
def test_pairs_that_are_used_again_are_handed_over_by_half(monkeypatch, uses, kinds):
    monkeypatch.setattr(run_module, "SampleStream", Pairs)
    monkeypatch.setattr(run_module, "replayed", lambda batches_from, *_: batches_from(0))
    run = Run("warm-delight", Path("heads"), Path("lights"), Path("w"), steps=9, pairs=2, workers=0, uses=uses)
    batch = next(training_batches(run, STAGES["warm-delight"], 0))
    assert (batch["normal"].dtype, batch["label"].dtype) == kinds


def test_taking_batches_draws_nothing_from_the_stream_that_steps_draw_from(monkeypatch):
    monkeypatch.setattr(run_module, "SampleStream", Numbers)
    run = Run("warm-delight", Path("heads"), Path("lights"), Path("w"), steps=9, pairs=2, workers=0)
    before = torch.get_rng_state()
    batches = training_batches(run, STAGES["warm-delight"], 3)
    assert next(batches)["number"].tolist() == [3, 4]
    assert torch.equal(torch.get_rng_state(), before)


@pytest.mark.parametrize("workers", [0, 1])
def test_what_is_wrong_with_the_data_is_told_in_one_line(monkeypatch, workers):
    monkeypatch.setattr(run_module, "SampleStream", Damaged)
    run = Run("warm-delight", Path("heads"), Path("lights"), Path("w"), steps=9, pairs=2, workers=workers)
    with pytest.raises(InputError) as refused:
        next(training_batches(run, STAGES["warm-delight"], 0))
    assert str(refused.value) == "head.npz: damaged; bake it again"


@pytest.mark.parametrize(
    "words",
    [
        "RuntimeError in DataLoader worker process 0.\nunable to allocate shared memory(shm) for file </torch_1>",
        "DataLoader worker (pid 7) is killed by signal: Bus error. It is possible that dataloader's workers are out of "
        "shared memory.",
    ],
)
def test_too_little_shared_memory_is_told_in_words_to_act_on(words):
    def batches():
        yield {}
        raise RuntimeError(words)

    plain = run_module._in_plain_words(batches())
    next(plain)
    with pytest.raises(InputError, match="/dev/shm.*--workers"):
        next(plain)


@pytest.mark.parametrize(
    ("stage", "size", "pairs", "words"),
    [
        ("outline", 17, 8, "photos of 17 pixels have no whole blocks of 2; give an even size"),
        ("outline", 64, 1, "one photo of 64 pixels is too little for a batch"),
        ("foreign-shadow", 32, 1, "one photo of 32 pixels is too little for a batch"),
    ],
)
def test_photos_that_a_network_of_blocks_can_not_learn_from_are_refused_before_any_is_made(
    tmp_path, stage, size, pairs, words
):
    settings = {"steps": 1, "size": size, "pairs": pairs, "config": BundleConfig.tiny()}
    with pytest.raises(InputError, match=f"{stage}: {words}"):
        train(Run(stage, tmp_path, tmp_path, tmp_path / "w.safetensors", **settings), heedless)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "stage", ["tune-delight", "tune-delight-strongly", "tune-relight", "tune-on-predictions", "distil-relight"]
)
def test_a_stage_that_learns_through_other_networks_is_refused_where_these_are_random(tmp_path, stage):
    run = Run(stage, tmp_path, tmp_path, tmp_path / "w.safetensors", steps=1, config=BundleConfig.tiny())
    with pytest.raises(InputError, match=f"{stage} learns from trained networks: give their weights .* --start"):
        train(run, heedless)
    assert not list(tmp_path.iterdir())


class Killed(IterableDataset):
    def __init__(self, *_, **__):
        pass

    def __iter__(self):
        os.kill(os.getpid(), signal.SIGKILL)
        yield {}


@pytest.mark.skipif(os.name == "nt", reason="nobody is killed so there")
def test_a_worker_that_is_killed_for_its_memory_is_told_in_words_to_act_on(monkeypatch):
    monkeypatch.setattr(run_module, "SampleStream", Killed)
    run = Run("warm-delight", Path("heads"), Path("lights"), Path("w"), steps=9, pairs=2, workers=1)
    with pytest.raises(InputError, match=r"was killed.*memory.*give the command again"):
        next(training_batches(run, STAGES["warm-delight"], 0))


@pytest.mark.parametrize(("asked", "threads"), [(None, "1"), ("3", "3")])
def test_who_makes_samples_starts_with_one_thread_unless_another_number_was_asked_for(monkeypatch, asked, threads):
    monkeypatch.setattr(run_module, "SampleStream", Numbers)
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", asked or "")
    if asked is None:
        monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    run = Run("warm-delight", Path("heads"), Path("lights"), Path("w"), steps=9, pairs=2, workers=1)
    training_batches(run, STAGES["warm-delight"], 0)
    assert os.environ["OPENBLAS_NUM_THREADS"] == threads


@pytest.fixture
def saves_at_once(monkeypatch):
    monkeypatch.setattr(run_module, "training_batches", lambda *_: itertools.repeat(some_batch()))
    monkeypatch.setattr(run_module, "Budget", partial(Budget, checkpoint_seconds=-1.0))


def stop(done, progress):
    raise Stopped


def heedless(done, progress):
    pass


def two_batches(*_):
    yield some_batch()
    yield some_batch()
    raise Stopped


@pytest.mark.usefixtures("saves_at_once")
@pytest.mark.parametrize("changed", ["heads", "lights"])
def test_a_run_with_other_heads_or_lights_is_not_gone_on_with(tmp_path, monkeypatch, changed):
    monkeypatch.setattr(run_module, "training_batches", two_batches)
    for folder, name in (("heads", "head-7.npz"), ("lights", "sky.hdr")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / name).write_bytes(b"one")
    checkpoint = tmp_path / "w.safetensors"
    run = Run("warm-delight", tmp_path / "heads", tmp_path / "lights", checkpoint, steps=50, config=BundleConfig.tiny())
    with pytest.raises(Stopped):
        train(run, heedless)
    another = tmp_path / changed / {"heads": "head-8.npz", "lights": "snow.exr"}[changed]
    another.write_bytes(b"another")
    with pytest.raises(InputError, match="began with heads and lights"):
        train(run, heedless)
    another.unlink()
    (tmp_path / changed).rename(tmp_path / "moved")
    with pytest.raises(Stopped):
        train(replace(run, **{changed: tmp_path / "moved"}), heedless)


@pytest.mark.usefixtures("saves_at_once")
def test_a_run_from_other_weights_is_not_gone_on_with(tmp_path):
    first, other = tmp_path / "first.safetensors", tmp_path / "other.safetensors"
    for path in (first, other):
        save_bundle(path, NetworkBundle(BundleConfig.tiny()))
    run = Run("warm-delight", tmp_path, tmp_path, tmp_path / "w.safetensors", start=first, steps=50)
    with pytest.raises(Stopped):
        train(run, stop)
    assert state_path(run.checkpoint).exists()
    for start in (other, None):
        with pytest.raises(InputError, match="began with start"):
            train(replace(run, start=start), stop)
    first.rename(tmp_path / "moved.safetensors")
    train(replace(run, start=tmp_path / "moved.safetensors"), heedless)
    assert not state_path(run.checkpoint).exists()
