"""A run's batches."""

from pathlib import Path

import torch
from torch.utils.data import IterableDataset

from relight_core.training import run as run_module
from relight_core.training.run import Run, training_batches
from relight_core.training.stages import STAGES


class Numbers(IterableDataset):
    def __init__(self, *_, first_batch, **__):
        self.first = first_batch

    def __iter__(self):
        return iter([{"number": torch.tensor(self.first + n)} for n in range(8)])


def test_taking_batches_draws_nothing_from_the_stream_that_steps_draw_from(monkeypatch):
    monkeypatch.setattr(run_module, "SampleStream", Numbers)
    run = Run("warm-delight", Path("heads"), Path("lights"), Path("w"), steps=9, pairs=2, workers=0)
    before = torch.get_rng_state()
    batches = training_batches(run, STAGES["warm-delight"], 3)
    assert next(batches)["number"].tolist() == [3, 4]
    assert torch.equal(torch.get_rng_state(), before)
