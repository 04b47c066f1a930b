"""The training loop: one stage, one time budget, atomic checkpoints, and a stop at the first sign of NaN."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import torch
from torch import nn

from relight_core.errors import InputError
from relight_core.imaging.file_lock import NoLocks, let_go, locked
from relight_core.imaging.files import remove_unfinished, whole_file
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import NetworkBundle, save_bundle
from relight_core.networks.precision import mixed_precision
from relight_core.training.ahead import one_ahead
from relight_core.training.optimiser import Optimiser
from relight_core.training.sheet import draw_samples
from relight_core.training.stages import Stage
from relight_core.training.state import Progress, State, load_state, make_state
from relight_core.training.step import Batch, RecordedStep, Step

_MOST_SKIPPED_IN_A_ROW = 20
_DECAY, _AVERAGED_EVERY = 0.998, 4
"""Of the averaged weights: their decay a step, and how many steps are taken at once."""


class TrainingDiverged(RuntimeError):
    """Losses or gradients stayed non-finite; the last checkpoint is still good."""


@dataclass(frozen=True)
class Budget:
    """How long and how hard to train.

    Attributes:
        minutes, steps: wall-clock length or number of steps, one of them; the learning rate follows a cosine
            over it. Only a number of steps gives the same weights again.
        learning_rate: peak.
        warm_up_steps: linear rise at the start.
        final_fraction: of the peak, at the end.
        checkpoint_seconds: between two checkpoints.
    """

    learning_rate: float
    minutes: float | None = None
    steps: int | None = None
    warm_up_steps: int = 200
    final_fraction: float = 0.02
    checkpoint_seconds: float = 120.0

    def __post_init__(self):
        if (self.minutes is None) == (self.steps is None):
            raise ValueError("give either minutes or steps")

    def spent(self, step: int, seconds: float) -> float:
        """The fraction of the budget that is gone."""
        return step / self.steps if self.steps is not None else seconds / (60 * self.minutes)

    def rate(self, step: int, elapsed: float) -> float:
        """Learning rate at a step, `elapsed` being the fraction of the budget that is spent."""
        cosine = 0.5 * (1 + math.cos(math.pi * min(elapsed, 1.0)))
        return (
            self.learning_rate
            * min(1.0, (step + 1) / self.warm_up_steps)
            * (self.final_fraction + (1 - self.final_fraction) * cosine)
        )


class AveragedWeights:
    """Exponential moving average of a bundle: what is saved, since it scores better than the last step."""

    def __init__(self, bundle: NetworkBundle):
        self.state = {name: value.clone() for name, value in bundle.state_dict().items()}

    def update(self, bundle: NetworkBundle, step: int) -> None:
        """Move toward the current weights, quickly at first; every few steps, for it touches every weight."""
        if step % _AVERAGED_EVERY == 0:
            self._move(bundle, step, _AVERAGED_EVERY)

    def catch_up(self, bundle: NetworkBundle, step: int) -> None:
        """Take the last steps that `update` has left for later: a run of fewer than four would have learnt nothing."""
        if step % _AVERAGED_EVERY:
            self._move(bundle, step, step % _AVERAGED_EVERY)

    def _move(self, bundle: NetworkBundle, step: int, steps: int) -> None:
        decay = min(_DECAY, (1 + step) / (10 + step)) ** steps
        now = bundle.state_dict()
        moving = [name for name, value in now.items() if value.is_floating_point()]
        torch._foreach_lerp_([self.state[name] for name in moving], [now[name] for name in moving], 1 - decay)
        for name in now.keys() - moving:
            self.state[name].copy_(now[name])

    def bundle(self, like: NetworkBundle) -> NetworkBundle:
        """A bundle of its own with the averaged weights."""
        copy = type(like)(like.config)
        copy.load_state_dict(self.state)
        copy.card = dict(like.card)
        return copy


def train_stage(
    stage: Stage,
    bundle: NetworkBundle,
    batches_from: Callable[[int], Iterator[Batch]],
    budget: Budget,
    checkpoint: Path,
    report: Callable[[float, Progress], None],
    device: str = "cpu",
    drawn_by: Mapping[str, int | str] | None = None,
) -> NetworkBundle:
    """Train one stage until its budget is spent; goes on where a run with this checkpoint stopped.

    Mixed precision: bf16 under autocast where the device has it; light, normals and losses stay in fp32 where the
    networks keep them so. A batch with a non-finite loss or gradient is skipped and counted; too many in a row end it.
    A budget that is spent amid such batches is overdrawn until a finite one, or too many.

    Args:
        batches_from: gives the batches from a number on.
        checkpoint: where the averaged weights go. The run's whole state lies beside them until it ends.
        report: called every 50 steps with the fraction of the budget spent and the progress, and with 1 at the end.
        drawn_by: by name, what decides which batches come and which weights the run starts from. A run that is resumed
            has to be given the same.

    Returns:
        The averaged weights, also saved at `checkpoint` (fp32) with a log beside it.

    Raises:
        TrainingDiverged: after 20 non-finite batches in a row, or where what the last step leaves gives no finite
            losses; earlier checkpoints stay.
        InputError: the state of an earlier run beside the checkpoint does not fit, or another run is at it.
    """
    _prepare(stage, bundle, device)
    recorded = device == "cuda" and stage.recordable
    with _only_run(checkpoint), _stream_of_its_own() if recorded else nullcontext():
        step = RecordedStep if recorded else Step
        return _trained(step, stage, bundle, batches_from, budget, checkpoint, report, device, drawn_by or {})


def _trained(
    step_class: type[Step],
    stage: Stage,
    bundle: NetworkBundle,
    batches_from: Callable[[int], Iterator[Batch]],
    budget: Budget,
    checkpoint: Path,
    report: Callable[[float, Progress], None],
    device: str,
    drawn_by: Mapping[str, int | str],
) -> NetworkBundle:
    optimiser = Optimiser(bundle, budget.learning_rate)
    table, average = ReflectionTable().to(device), AveragedWeights(bundle)
    saved_state, settings = state_path(checkpoint), {"stage": stage.name, **drawn_by}
    progress = Progress()
    if saved_state.exists():
        progress = load_state(saved_state, settings, bundle, average.state, optimiser)
    batches = _prepared(stage, bundle, table, batches_from(progress.step), device)
    step = step_class(stage, bundle, table, optimiser, device)
    checkpoints = _Checkpoints(checkpoint, settings, budget.checkpoint_seconds)
    started, batch, ready = time.monotonic() - progress.seconds, None, None
    # While batches are being skipped the run goes on beyond its budget: their weights may be of no use.
    while (elapsed := min(budget.spent(progress.step, progress.seconds), 1.0)) < 1 or progress.in_a_row:
        optimiser.set_learning_rate(budget.rate(progress.step, elapsed))
        batch, ready = next(batches)
        progress.take(step(ready))
        if progress.in_a_row >= _MOST_SKIPPED_IN_A_ROW:
            raise TrainingDiverged(f"{progress.in_a_row} non-finite batches in a row at step {progress.step}")
        average.update(bundle, progress.step)
        progress.seconds = time.monotonic() - started
        if progress.step % 50 == 0:
            report(elapsed, progress)
            progress.note(elapsed)
        checkpoints.after_step(progress, bundle, average, optimiser, batch)
    report(1.0, progress)
    progress.note(1.0)
    average.catch_up(bundle, progress.step)
    if ready is not None and not _is_sound(stage, average.bundle(bundle), table, ready, device):
        raise TrainingDiverged(f"what it learnt up to step {progress.step}, the last one, gives non-finite losses")
    return _ended(checkpoint, average.bundle(bundle), progress, batch)


@torch.no_grad()
def _is_sound(stage: Stage, result: NetworkBundle, table: ReflectionTable, ready: Batch, device: str) -> bool:
    """Whether a run's result, in evaluation mode as it will be used, gives finite losses.

    During training the next batch shows what a step has done; after the last step there is none.
    """
    result.eval().to(device, memory_format=torch.channels_last)
    with mixed_precision(device):
        losses = stage.losses(result, table, ready)
    return bool(torch.isfinite(torch.stack([value.float() for value in losses.values()])).all())


class _Checkpoints:
    """Where a run stands, written now and then: once the batch after it has come out finite.

    A step may leave weights that are finite and of no use any more, and only the next batch tells.
    """

    def __init__(self, checkpoint: Path, settings: dict[str, str | int], every_s: float):
        self._checkpoint, self._settings, self._every_s = checkpoint, settings, every_s
        self._taken_s = time.monotonic()
        self._waiting: tuple[State, NetworkBundle, Batch] | None = None

    def after_step(
        self, progress: Progress, bundle: NetworkBundle, average: AveragedWeights, optimiser: Optimiser, batch: Batch
    ) -> None:
        """Write or drop what waits for this step's outcome, and take a copy of where the run stands when one is due."""
        waiting, self._waiting = self._waiting, None
        if progress.in_a_row:
            return
        state = self._state_if_due(progress, bundle, average, optimiser)
        if waiting is None and state is None:
            return
        with torch.random.fork_rng():  # The next step must not depend on when the clock asks for a checkpoint.
            if waiting is not None:
                self._write(*waiting)
            if state is not None:
                self._waiting = state, average.bundle(bundle), batch

    def _state_if_due(
        self, progress: Progress, bundle: NetworkBundle, average: AveragedWeights, optimiser: Optimiser
    ) -> State | None:
        if time.monotonic() - self._taken_s <= self._every_s:
            return None
        self._taken_s = time.monotonic()
        return make_state(self._settings, progress, bundle, average.state, optimiser)

    def _write(self, state: State, averaged: NetworkBundle, batch: Batch) -> None:
        # The state first: weights without a state beside them are those of a run that has ended.
        state.write(state_path(self._checkpoint))
        _save(self._checkpoint, averaged, batch)


def _ended(checkpoint: Path, result: NetworkBundle, progress: Progress, batch: Batch | None) -> NetworkBundle:
    """The result of a run, with its log beside it and no state any more."""
    _save(checkpoint, result, batch)
    with whole_file(_log_path(checkpoint)) as log:
        log.write_text(json.dumps(progress.log))
    state_path(checkpoint).unlink(missing_ok=True)
    return result


def _save(checkpoint: Path, bundle: NetworkBundle, batch: Batch | None) -> None:
    """The weights, and a look at what they do with the last batch."""
    save_bundle(checkpoint, bundle, half=False)
    if batch is not None and isinstance(bundle, NetworkBundle):
        draw_samples(bundle.eval(), ReflectionTable(), batch, _sheet_path(checkpoint))


def state_path(checkpoint: Path) -> Path:
    """Where the state of a run that is not finished lies."""
    return checkpoint.with_suffix(".state.safetensors")


def _log_path(checkpoint: Path) -> Path:
    return checkpoint.with_suffix(".log.json")


def _sheet_path(checkpoint: Path) -> Path:
    return checkpoint.with_suffix(".samples.png")


def is_begun(checkpoint: Path) -> bool:
    """Whether a run with this checkpoint has left anything that was learnt, finished or not."""
    return checkpoint.exists() or state_path(checkpoint).exists()


@contextmanager
def _only_run(checkpoint: Path) -> Iterator[None]:
    """Keep others from a checkpoint while a run is at it: each would write its own state and weights over the other's.

    A disk without locks, as some network drives are, keeps nobody.
    """
    path, file = checkpoint.with_suffix(".lock"), None
    try:
        with suppress(NoLocks):
            file = _lock(path)
            if file is None:
                raise InputError(f"{checkpoint}: is being trained by another run; let it end, or choose another place")
            for path_of_run in (checkpoint, state_path(checkpoint), _log_path(checkpoint), _sheet_path(checkpoint)):
                remove_unfinished(path_of_run)
        yield
    finally:
        if file is not None:
            let_go(file, path)


def _lock(path: Path) -> BinaryIO | None:
    try:
        return locked(path)
    except NoLocks:
        raise
    except OSError as error:
        raise InputError(f"{path}: can't be written ({error.strerror}); choose another place") from error


@contextmanager
def _stream_of_its_own() -> Iterator[None]:
    """Nothing can be recorded on a GPU's default stream."""
    stream = torch.cuda.Stream()
    stream.wait_stream(torch.cuda.current_stream())
    with torch.cuda.stream(stream):
        yield


def _prepare(stage: Stage, bundle: NetworkBundle, device: str) -> None:
    """Set the stage's networks to training and the others to rest."""
    bundle.train().requires_grad_(False).to(device, memory_format=torch.channels_last)
    learners = stage.learners(bundle.config)
    for name, network in bundle.named_children():
        if name in learners:
            network.requires_grad_(True)
            if stage.settled:
                _settle(network)
        else:
            network.eval()


def _settle(network: nn.Module) -> None:
    """Normalise by the running statistics, as the editor does: those of a few heads make every step another network."""
    for part in network.modules():
        if isinstance(part, nn.BatchNorm2d):
            part.eval()


def _prepared(
    stage: Stage, bundle: NetworkBundle, table: ReflectionTable, batches: Iterator[Batch], device: str
) -> Iterator[tuple[Batch, Batch]]:
    """Every batch as it came, and on its device as the stage learns from it."""

    def on_device(batch: Batch) -> Batch:
        return {name: value.to(device, non_blocking=True) for name, value in batch.items()}

    if stage.prepare is None:
        return ((batch, on_device(batch)) for batch in batches)
    return one_ahead(lambda batch: stage.prepare(bundle, table, on_device(batch)), batches)
