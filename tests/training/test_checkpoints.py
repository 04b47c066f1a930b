"""What a run leaves on disk when its batches or its weights go bad, and that it goes on from there."""

import errno
import itertools
import os
from dataclasses import replace

import pytest
import safetensors.torch
import torch
from small_runs import quiet, recorded, some_batch

from relight_core.errors import InputError
from relight_core.networks.bundle import BundleConfig, NetworkBundle, load_bundle
from relight_core.training import loop
from relight_core.training.loop import Budget, TrainingDiverged, is_begun, state_path, train_stage
from relight_core.training.optimiser import Optimiser
from relight_core.training.stages import STAGES
from relight_core.training.state import Progress, load_state

STAGE = STAGES["warm-delight"]


pytestmark = pytest.mark.usefixtures("seeded")


def spoiled(batch):
    return batch | {"light": torch.full_like(batch["light"], float("nan"))}


def train(
    batches, path, steps=30, rate=5e-3, report=quiet, stage=STAGE, kind=Budget, minutes=None, checkpoint_seconds=0
):
    budget = kind(rate, minutes, steps, warm_up_steps=1, checkpoint_seconds=checkpoint_seconds)
    bundle = NetworkBundle(BundleConfig.tiny())
    return train_stage(stage, bundle, lambda first: batches, budget, path, report)


class SlowSteps:
    """A clock that stands still but for a stage's losses, which take ten seconds."""

    def __init__(self, monkeypatch):
        self.seconds, self.seen = 100.0, []
        self.stage = replace(STAGE, losses=self._losses)
        monkeypatch.setattr(loop.time, "monotonic", lambda: self.seconds)

    def _losses(self, bundle, table, batch):
        self.seconds += 10
        self.seen.append(self.seconds)
        return STAGE.losses(bundle, table, batch)


def kept_progress(path):
    bundle = NetworkBundle(BundleConfig.tiny())
    bundle.requires_grad_(False).delight.requires_grad_(True)
    state = {name: value.clone() for name, value in bundle.state_dict().items()}
    return load_state(state_path(path), {"stage": STAGE.name}, bundle, state, Optimiser(bundle, 1e-3))


def test_what_non_finite_batches_leave_is_older_than_they_and_goes_on(tmp_path):
    good, path = some_batch(), tmp_path / "w.safetensors"
    with pytest.raises(TrainingDiverged):
        train(itertools.chain([good] * 3, itertools.repeat(spoiled(good))), path)
    assert 1 <= kept_progress(path).step <= 3
    assert kept_progress(path).in_a_row == 0
    losses = []
    result = train(itertools.repeat(good), path, steps=6, stage=recorded(STAGE, losses))
    assert len(losses) in (3, 4, 5)
    assert all(torch.isfinite(value).all() for value in result.state_dict().values())
    assert not state_path(path).exists()


class Leap(Budget):
    """One step, the one numbered 3 from 0, throws the weights away, and no number among them stops being finite."""

    def rate(self, step, elapsed):
        return 1e30 if step == 3 else super().rate(step, elapsed)


def test_weights_that_explode_are_never_written(tmp_path):
    path = tmp_path / "w.safetensors"
    with pytest.raises(TrainingDiverged):
        train(itertools.repeat(some_batch()), path, kind=Leap)
    assert kept_progress(path).step == 3
    assert all(value.abs().max() < 1e6 for value in load_bundle(path).state_dict().values())


def test_weights_that_explode_in_the_first_step_leave_nothing(tmp_path):
    with pytest.raises(TrainingDiverged):
        train(itertools.repeat(some_batch()), tmp_path / "w.safetensors", rate=1e30)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("rate", [1e5, 1e30])
def test_a_last_step_that_throws_the_weights_away_is_told(tmp_path, rate):
    with pytest.raises(TrainingDiverged, match="step 1, the last one"):
        train(itertools.repeat(some_batch()), tmp_path / "w.safetensors", 1, rate)
    assert list(tmp_path.iterdir()) == []


def test_what_was_written_before_a_last_step_that_throws_the_weights_away_stays(tmp_path):
    path = tmp_path / "w.safetensors"
    with pytest.raises(TrainingDiverged, match="step 4, the last one"):
        train(itertools.repeat(some_batch()), path, 4, kind=Leap)
    assert kept_progress(path).step == 3
    assert all(value.abs().max() < 1e6 for value in load_bundle(path).state_dict().values())


def test_a_checkpoint_that_a_bad_batch_cost_is_made_up_for(tmp_path):
    good, path = some_batch(), tmp_path / "w.safetensors"
    batches = itertools.chain([good, good, spoiled(good), good, good], itertools.repeat(spoiled(good)))
    with pytest.raises(TrainingDiverged):
        train(batches, path)
    assert (kept_progress(path).step, kept_progress(path).skipped) == (4, 1)
    assert all(torch.isfinite(value).all() for value in load_bundle(path).state_dict().values())


def test_a_budget_that_ends_amid_non_finite_batches_waits_for_a_good_one(tmp_path):
    good, told = some_batch(), []
    batches = itertools.chain([good] * 4, [spoiled(good)] * 4, itertools.repeat(good))
    train(batches, tmp_path / "w.safetensors", 6, report=lambda done, now: told.append((done, now.step, now.skipped)))
    assert told == [(1.0, 9, 4)]
    with pytest.raises(TrainingDiverged):
        train(itertools.chain([good] * 4, itertools.repeat(spoiled(good))), tmp_path / "v.safetensors", 6)


def test_of_a_budget_of_time_a_run_that_goes_on_has_what_is_left(tmp_path, monkeypatch):
    clock, path = SlowSteps(monkeypatch), tmp_path / "w.safetensors"
    good, plan = some_batch(), {"minutes": 1, "stage": clock.stage}
    with pytest.raises(TrainingDiverged):
        train(itertools.chain([good] * 3, itertools.repeat(spoiled(good))), path, None, **plan)
    kept = kept_progress(path)
    assert (kept.step, kept.seconds) == (2, 20)
    clock.seconds = 90000.0
    clock.seen.clear()
    train(itertools.repeat(good), path, None, **plan)
    # Four steps, and one look at what came out.
    assert clock.seen == [90010, 90020, 90030, 90040, 90050]


def test_a_checkpoint_is_due_when_its_time_has_passed_since_the_last(tmp_path, monkeypatch):
    clock, written = SlowSteps(monkeypatch), []
    save = loop.save_bundle

    def noted(*args, **settings):
        written.append(clock.seconds - 100)
        save(*args, **settings)

    monkeypatch.setattr(loop, "save_bundle", noted)
    train(itertools.repeat(some_batch()), tmp_path / "w.safetensors", 11, stage=clock.stage, checkpoint_seconds=25)
    # Of where the run stood after 30, 60 and 90 seconds, once the next step is known to be sound, and of its end.
    assert written == [40, 70, 100, 120]


def test_a_run_that_was_killed_between_its_first_state_and_weights_is_begun(tmp_path):
    path = tmp_path / "w.safetensors"
    assert not is_begun(path)
    state_path(path).touch()
    assert is_begun(path)
    state_path(path).unlink()
    path.touch()
    assert is_begun(path)


def test_the_last_report_tells_the_end(tmp_path):
    done = []
    train(itertools.repeat(some_batch()), tmp_path / "w.safetensors", 2, report=lambda part, _: done.append(part))
    assert done == [1.0]


@pytest.mark.parametrize("where", ["weights.composition.", "average.delight.", "optimiser."])
def test_a_damaged_state_is_refused_before_anything_is_learnt_from_it(where, tmp_path):
    good, path, learnt = some_batch(), tmp_path / "w.safetensors", []
    with pytest.raises(TrainingDiverged):
        train(itertools.chain([good] * 3, itertools.repeat(spoiled(good))), path)
    with safetensors.safe_open(state_path(path), framework="pt") as file:
        tensors, header = {name: file.get_tensor(name) for name in file.keys()}, file.metadata()  # noqa: SIM118
    name = next(name for name, value in tensors.items() if name.startswith(where) and value.is_floating_point())
    tensors[name].view(-1)[0] = float("nan")
    safetensors.torch.save_file(tensors, state_path(path), metadata=header)
    with pytest.raises(InputError, match=r"damaged.*delete it"):
        train(itertools.repeat(good), path, stage=recorded(STAGE, learnt))
    assert learnt == []


@pytest.mark.parametrize("where", ["tensors", "progress"])
def test_a_state_with_one_bit_of_another_value_is_refused_before_anything_is_learnt_from_it(where, tmp_path):
    good, path, learnt = some_batch(), tmp_path / "w.safetensors", []
    with pytest.raises(TrainingDiverged):
        train(itertools.chain([good] * 3, itertools.repeat(spoiled(good))), path)
    data = bytearray(state_path(path).read_bytes())
    at = len(data) - 1 if where == "tensors" else data.index(b'"skipped') + 12
    data[at] ^= 1
    state_path(path).write_bytes(data)
    with pytest.raises(InputError, match=r"damaged: its checksum differs.*delete it"):
        train(itertools.repeat(good), path, stage=recorded(STAGE, learnt))
    assert learnt == []


def test_a_state_of_before_there_were_checksums_is_gone_on_from(tmp_path):
    good, path, learnt = some_batch(), tmp_path / "w.safetensors", []
    with pytest.raises(TrainingDiverged):
        train(itertools.chain([good] * 3, itertools.repeat(spoiled(good))), path)
    with safetensors.safe_open(state_path(path), framework="pt") as file:
        tensors, header = {name: file.get_tensor(name) for name in file.keys()}, file.metadata()  # noqa: SIM118
    del header["sha256"]
    safetensors.torch.save_file(tensors, state_path(path), metadata=header)
    train(itertools.repeat(good), path, steps=6, stage=recorded(STAGE, learnt))
    assert 3 <= len(learnt) <= 5


def test_what_a_killed_run_was_writing_is_removed_by_the_next_and_nothing_else_is(tmp_path):
    endings = (".safetensors", ".state.safetensors", ".log.json", ".samples.png")
    left = [tmp_path / f".w{ending}-0123456789ab.part" for ending in endings]
    others = [tmp_path / ".v.safetensors-0123456789ab.part", tmp_path / ".w.safetensors-mine.part"]
    for file in left + others:
        file.touch()
    train(itertools.repeat(some_batch()), tmp_path / "w.safetensors", steps=1)
    assert {path.name for path in tmp_path.iterdir() if path.suffix == ".part"} == {path.name for path in others}


def test_what_another_run_is_writing_stays(tmp_path):
    good, path = some_batch(), tmp_path / "w.safetensors"
    part = tmp_path / ".w.state.safetensors-0123456789ab.part"

    def batches_amid_which_another_begins():
        part.touch()
        with pytest.raises(InputError, match="another run"):
            train(itertools.repeat(good), path, steps=1)
        yield good

    train(batches_amid_which_another_begins(), path, steps=1)
    assert part.exists()


def test_a_checkpoint_has_one_run_at_a_time(tmp_path):
    good, path, refusals = some_batch(), tmp_path / "w.safetensors", []

    def batches_amid_which_others_begin():
        while True:
            with pytest.raises(InputError, match="another run") as refused:
                train(itertools.repeat(good), path, steps=1)
            refusals.append(str(refused.value))
            yield good

    train(batches_amid_which_others_begin(), path, steps=2)
    assert len(refusals) == 2
    assert not list(tmp_path.glob("*.lock"))
    train(itertools.repeat(good), path, steps=1)


@pytest.mark.skipif(os.name == "nt", reason="locks are others there")
def test_a_disk_without_locks_is_trained_on_too(tmp_path, monkeypatch):
    def none(descriptor, wish):
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr("fcntl.flock", none)
    train(itertools.repeat(some_batch()), tmp_path / "w.safetensors", steps=1)
    assert (tmp_path / "w.safetensors").exists()


def test_losses_are_smoothed_from_the_first_on_and_skipped_batches_counted():
    progress = Progress()
    for losses in ({"relit": 1.0}, {}, {}, {"relit": 2.0}):
        progress.take(losses)
    assert (progress.step, progress.skipped, progress.in_a_row) == (4, 2, 0)
    assert progress.smoothed == {"relit": pytest.approx(0.98 * 1.0 + 0.02 * 2.0)}
    progress.take({})
    assert (progress.step, progress.skipped, progress.in_a_row) == (5, 3, 1)
