"""How fast samples are made on one core, and what part of a training step waits for them."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import cv2
import torch

from relight_core.dataset.stream import SampleStream
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import NetworkBundle
from relight_core.networks.precision import mixed_precision
from relight_core.training.optimiser import Optimiser
from relight_core.training.run import Run, training_batches, training_device
from relight_core.training.stages import STAGES

_STAGE = "warm-delight"
_HEADS_PER_ROUND = 8


@dataclass(frozen=True)
class LoaderSpeed:
    """Of one size, on one core; a sample is one lit and photographed image with all its channels.

    Attributes:
        wall_per_s: samples a second by the clock: true on an idle machine.
        cpu_per_s: samples a second of the process's own time, which others' load changes less.
    """

    size: int
    samples: int
    wall_per_s: float
    cpu_per_s: float


def loader_speed(heads: Path, lights: Path, size: int, rounds: int = 1) -> LoaderSpeed:
    """Time rounds of the stream, in each of which a few heads are read, lit and painted many times.

    What happens once per process (reading lights, drawing textures, lighting the first heads) is left out.
    """
    with _one_thread():
        stream = SampleStream(heads, lights, "train", size, seed=0)
        samples = iter(stream)
        next(samples)
        # Whole heads from the first sample of one on: each part comes in its true proportion.
        count = rounds * _HEADS_PER_ROUND * stream.paints_per_head
        wall, cpu = time.perf_counter(), time.process_time()
        for _ in islice(samples, count):
            pass
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    return LoaderSpeed(size, 2 * count, 2 * count / wall, 2 * count / cpu)


def waiting_share(heads: Path, lights: Path, size: int, steps: int) -> float:
    """The part of de-lighting's training steps that is spent waiting for the loader, in [0, 1].

    The first steps, while the loader fills its queue, are left out.
    """
    stage, device = STAGES[_STAGE], training_device()
    run = Run(_STAGE, heads, lights, Path(), size=size, workers=1)
    bundle = NetworkBundle(run.config).to(device, memory_format=torch.channels_last)
    bundle.delight.train().requires_grad_(True)
    optimiser, table = Optimiser(bundle.delight, stage.learning_rate), ReflectionTable().to(device)
    batches = training_batches(run, stage, 0)
    waited = started = 0.0
    for number in range(steps + 2):
        if number == 2:
            waited, started = 0.0, time.perf_counter()
        asked = time.perf_counter()
        batch = {name: value.to(device) for name, value in next(batches).items()}
        waited += time.perf_counter() - asked
        with mixed_precision(device):
            total = sum(stage.losses(bundle, table, batch).values())
        optimiser.zero_grad()
        total.backward()
        optimiser.step()
        if device == "cuda":
            torch.cuda.synchronize()
    return waited / (time.perf_counter() - started)


@contextmanager
def _one_thread() -> Iterator[None]:
    before = torch.get_num_threads(), cv2.getNumThreads()
    torch.set_num_threads(1)
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before[0])
        cv2.setNumThreads(before[1])
