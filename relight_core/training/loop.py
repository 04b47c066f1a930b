"""The training loop: one stage, one time budget, atomic checkpoints, and a stop at the first sign of NaN."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import torch

from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import NetworkBundle, save_bundle
from relight_core.training.stages import Stage

_GRADIENT_LIMIT = 5.0
_MOST_SKIPPED_IN_A_ROW = 20


class TrainingDiverged(RuntimeError):
    """Losses or gradients stayed non-finite; the last checkpoint is still good."""


@dataclass(frozen=True)
class Budget:
    """How long and how hard to train.

    Attributes:
        minutes: wall-clock length; the learning rate follows a cosine over it.
        learning_rate: peak.
        warm_up_steps: linear rise at the start.
        final_fraction: of the peak, at the end.
        checkpoint_seconds: between two checkpoints.
    """

    minutes: float
    learning_rate: float
    warm_up_steps: int = 200
    final_fraction: float = 0.02
    checkpoint_seconds: float = 120.0

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

    def __init__(self, bundle: NetworkBundle, decay: float = 0.998, every: int = 4):
        self._decay, self._every = decay, every
        self._state = {name: value.clone() for name, value in bundle.state_dict().items()}

    def update(self, bundle: NetworkBundle, step: int) -> None:
        """Move toward the current weights, quickly at first; every few steps, for it touches every weight."""
        if step % self._every:
            return
        decay = min(self._decay**self._every, (1 + step) / (10 + step))
        for name, value in bundle.state_dict().items():
            if value.is_floating_point():
                self._state[name].lerp_(value, 1 - decay)
            else:
                self._state[name].copy_(value)

    def bundle(self, like: NetworkBundle) -> NetworkBundle:
        """A bundle of its own with the averaged weights."""
        copy = NetworkBundle(like.config)
        copy.load_state_dict(self._state)
        copy.card = dict(like.card)
        return copy


def train_stage(
    stage: Stage,
    bundle: NetworkBundle,
    batches: Iterator[dict[str, torch.Tensor]],
    budget: Budget,
    checkpoint: Path,
    report: Callable[[int, float, dict[str, float]], None],
    device: str = "cpu",
) -> NetworkBundle:
    """Train one stage until its budget is spent.

    Mixed precision: bf16 under autocast; light, normals and losses stay in fp32 where the networks keep
    them so. A batch with a non-finite loss or gradient is skipped and counted; too many in a row end it.

    Args:
        report: called every 50 steps with the step, the fraction of the budget spent, averaged losses.

    Returns:
        The averaged weights, also saved at `checkpoint` (fp32) with a log beside it.

    Raises:
        TrainingDiverged: after 20 non-finite batches in a row.
    """
    bundle.train().requires_grad_(False).to(device, memory_format=torch.channels_last)
    trained = [getattr(bundle, name).requires_grad_(True) for name in stage.trains]
    for name in {"delight", "specular_shadow", "composition"} - set(stage.trains):
        getattr(bundle, name).eval()
    parameters = [p for network in trained for p in network.parameters()]
    optimiser = torch.optim.AdamW(parameters, lr=budget.learning_rate, weight_decay=1e-4, fused=True)
    table, average = ReflectionTable().to(device), AveragedWeights(bundle)
    started = saved = time.monotonic()
    step, skipped, smoothed, log = 0, 0, {}, []
    while (elapsed := (time.monotonic() - started) / (60 * budget.minutes)) < 1:
        for group in optimiser.param_groups:
            group["lr"] = budget.rate(step, elapsed)
        losses = _step(stage, bundle, table, next(batches), optimiser, parameters, device)
        skipped = 0 if losses else skipped + 1
        if skipped > _MOST_SKIPPED_IN_A_ROW:
            raise TrainingDiverged(f"{skipped} non-finite batches in a row at step {step}")
        step += 1
        average.update(bundle, step)
        for name, value in losses.items():
            smoothed[name] = value if name not in smoothed else 0.98 * smoothed[name] + 0.02 * value
        if step % 50 == 0:
            report(step, elapsed, smoothed)
            log.append({"step": step, "elapsed": elapsed, **smoothed})
        if time.monotonic() - saved > budget.checkpoint_seconds:
            saved = time.monotonic()
            save_bundle(checkpoint, average.bundle(bundle), half=False)
    result = average.bundle(bundle)
    save_bundle(checkpoint, result, half=False)
    checkpoint.with_suffix(".log.json").write_text(json.dumps(log))
    return result


def _step(stage, bundle, table, batch, optimiser, parameters, device) -> dict[str, float]:
    """One optimiser step; the losses by name, or nothing when the batch had to be skipped."""
    batch = {name: value.to(device, non_blocking=True) for name, value in batch.items()}
    statistics = [buffer.clone() for buffer in bundle.buffers()]
    with torch.autocast(device, torch.bfloat16):
        losses = stage.losses(bundle, table, batch)
    total = torch.stack([value.float() for value in losses.values()]).sum()
    optimiser.zero_grad(set_to_none=True)
    if not torch.isfinite(total):
        return _skipped(bundle, statistics)
    total.backward()
    norm = torch.nn.utils.clip_grad_norm_(parameters, _GRADIENT_LIMIT)
    if not torch.isfinite(norm):
        return _skipped(bundle, statistics)
    optimiser.step()
    return {name: float(value.detach()) for name, value in losses.items()}


@torch.no_grad()
def _skipped(bundle: NetworkBundle, statistics: list[torch.Tensor]) -> dict[str, float]:
    """Undo what a bad batch did to the running statistics: one NaN in them would stay for good."""
    for buffer, kept in zip(bundle.buffers(), statistics, strict=True):
        buffer.copy_(kept)
    return {}
