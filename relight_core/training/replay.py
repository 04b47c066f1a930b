"""A replay buffer: samples are used several times, since a GPU takes a step faster than a CPU makes its samples.

The newest pairs are kept on the device, and every batch is drawn from them. The contents of a batch are a pure function
of its number, so that training can be resumed at any batch as if it had never stopped.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import count

import numpy as np
import torch

from relight_core.face.parsing import MIRRORED
from relight_core.imaging.tensor_constants import constant
from relight_core.training.half_kept import Batch, halved, whole_again


@dataclass(frozen=True)
class Replay:
    """How samples are reused.

    Attributes:
        uses: mean number of times that each pair is drawn.
        pairs: pairs in a batch.
        chunk: pairs that the loader delivers at a time.
        kept: size of the buffer in pairs; rounded up to whole chunks, and at least a batch.
        seed: of the random draws.
    """

    uses: int
    pairs: int
    chunk: int
    kept: int
    seed: int

    def __post_init__(self):
        if min(self.uses, self.pairs, self.chunk, self.kept) < 1:
            raise ValueError("uses, pairs, chunk and kept are 1 or more")

    @property
    def slots(self) -> int:
        """Chunks that are kept."""
        return -(-max(self.kept, self.pairs) // self.chunk)

    def chunks_before(self, batch: int) -> int:
        """Number of chunks loaded before a batch is drawn: those of one batch at first."""
        return -(-self.pairs // self.chunk) + batch * self.pairs // (self.uses * self.chunk)

    def drawn(self, batch: int) -> tuple[np.ndarray, np.ndarray]:
        """The buffer indices (pairs,) int of a batch's pairs, and which of these to mirror, (pairs,) bool."""
        random = np.random.default_rng([self.seed, batch])
        filled = min(self.chunks_before(batch), self.slots) * self.chunk
        return random.choice(filled, self.pairs, replace=False), random.random(self.pairs) < 0.5


def replayed(make: Callable[[int], Iterator[Batch]], replay: Replay, first: int, device: str) -> Iterator[Batch]:
    """Batches from a number on, without end.

    Args:
        make: gives chunks of pairs from a number on, as `dataset.stream` has them, floats in any precision.
        device: where they are kept, images in half precision.
    """
    comes_next = max(0, replay.chunks_before(first) - replay.slots)
    chunks, store = make(comes_next), {}
    for number in count(first):
        while comes_next < replay.chunks_before(number):
            _keep(store, next(chunks), comes_next % replay.slots, replay, device)
            comes_next += 1
        places, mirrored = (torch.from_numpy(drawn).to(device) for drawn in replay.drawn(number))
        batch = {name: value[places] for name, value in store.items()}
        yield mirrored_pairs(whole_again(batch), mirrored)


def mirrored_pairs(batch: Batch, which: torch.Tensor) -> Batch:
    """Pairs with some of them in a mirror (see `dataset.samples.mirrored`).

    Args:
        which: (pairs,) bool.
    """
    flipped = {name: value.flip(3 if name == "light" else -1) for name, value in batch.items()}
    flipped["normal"] = flipped["normal"] * constant((-1, 1, 1), which.device, batch["normal"].dtype)[:, None, None]
    flipped["label"] = constant(MIRRORED, which.device, torch.int64)[flipped["label"]]
    return {
        name: torch.where(which.reshape(-1, *[1] * (value.ndim - 1)), flipped[name], value)
        for name, value in batch.items()
    }


def _keep(store: Batch, chunk: Batch, slot: int, replay: Replay, device: str) -> None:
    for name, value in halved(chunk).items():
        if name not in store:
            store[name] = torch.empty(replay.slots * replay.chunk, *value.shape[1:], dtype=value.dtype, device=device)
        store[name][slot * replay.chunk : (slot + 1) * replay.chunk].copy_(value, non_blocking=True)
