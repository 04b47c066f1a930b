"""One step of training: losses, their gradients, and where those move the weights. On a GPU it is recorded."""

from __future__ import annotations

import math

import torch

from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import NetworkBundle
from relight_core.networks.precision import mixed_precision
from relight_core.training.optimiser import Optimiser
from relight_core.training.stages import Stage

_GRADIENT_LIMIT = 5.0
_UNRECORDED = 4
"""Steps before one is recorded: the optimiser makes its moments, and cuDNN tries its algorithms."""

Batch = dict[str, torch.Tensor]


class Step:
    """A stage's step on its networks, launched piece by piece."""

    def __init__(self, stage: Stage, bundle: NetworkBundle, table: ReflectionTable, optimiser: Optimiser, device: str):
        """Get ready to change what of the bundle learns in this stage."""
        self._stage, self._bundle, self._table = stage, bundle, table
        self._optimiser, self._device = optimiser, device
        self._buffers, self._names = list(bundle.buffers()), []

    def __call__(self, batch: Batch) -> dict[str, float]:
        """Learn from a batch that is ready on the device.

        Returns:
            The losses by name; nothing when one of them or a gradient was not finite, which left all as it was.
        """
        statistics = [buffer.clone() for buffer in self._buffers]
        # All numbers at once: a GPU waits whenever it is asked for one.
        *values, norm = self._find_gradients(batch).tolist()
        if not math.isfinite(sum(values) + norm):
            self._restore(statistics)
            return {}
        self._move()
        return dict(zip(self._names, values, strict=True))

    def _find_gradients(self, batch: Batch) -> torch.Tensor:
        """The losses, and the length of their gradient before it is held within its limit."""
        self._optimiser.zero_grad()
        with mixed_precision(self._device):
            losses = self._stage.losses(self._bundle, self._table, batch)
        self._names = list(losses)
        terms = torch.stack([value.float() for value in losses.values()])
        terms.sum().backward()
        norm = torch.nn.utils.clip_grad_norm_(self._optimiser.parameters, _GRADIENT_LIMIT)
        return torch.cat([terms.detach(), norm[None]])

    def _move(self) -> None:
        self._optimiser.step()

    @torch.no_grad()
    def _restore(self, statistics: list[torch.Tensor]) -> None:
        """Undo what a bad batch did to the running statistics: one NaN in them would stay for good."""
        for buffer, kept in zip(self._buffers, statistics, strict=True):
            buffer.copy_(kept)


class RecordedStep(Step):
    """The same, recorded once as two CUDA graphs and played back: thousands of small launches are two.

    Wants batches of one shape, a stage that never asks the host for anything on its way (`Stage.recordable`), and all
    work on one stream that is not the device's default one.
    """

    def __init__(self, *arguments, **named):
        super().__init__(*arguments, **named)
        self._taken = 0
        self._batch: Batch = {}
        self._losses = torch.empty(0)
        self._finding, self._moving = torch.cuda.CUDAGraph(), torch.cuda.CUDAGraph()

    def _find_gradients(self, batch: Batch) -> torch.Tensor:
        self._taken += 1
        if self._taken <= _UNRECORDED:
            return super()._find_gradients(batch)
        if not self._batch:
            self._record(batch)
        for name, value in batch.items():
            self._batch[name].copy_(value)
        self._finding.replay()
        return self._losses

    def _record(self, batch: Batch) -> None:
        self._batch = {name: value.clone() for name, value in batch.items()}
        stream = torch.cuda.current_stream()
        # The loader's threads go on pinning memory meanwhile, which is nothing of this recording's.
        with torch.cuda.graph(self._finding, stream=stream, capture_error_mode="thread_local"):
            self._losses = super()._find_gradients(self._batch)
        pool = self._finding.pool()
        with torch.cuda.graph(self._moving, pool=pool, stream=stream, capture_error_mode="thread_local"):
            super()._move()

    def _move(self) -> None:
        if self._batch:
            self._moving.replay()
        else:
            super()._move()
