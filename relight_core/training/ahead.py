"""What batches need before a step can learn from them, done one batch ahead on a thread of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Batch, Ready = TypeVar("Batch"), TypeVar("Ready")


def one_ahead(prepare: Callable[[Batch], Ready], batches: Iterator[Batch]) -> Iterator[tuple[Batch, Ready]]:
    """Every batch with `prepare` of it, which runs while the caller is busy with the batch before.

    Batches are taken on the caller's thread; what `prepare` raises comes with the batch that it was about.
    """
    with ThreadPoolExecutor(1, thread_name_prefix="relight-batch") as thread:
        batch = next(batches, None)
        coming = None if batch is None else thread.submit(prepare, batch)
        while coming is not None:
            following = next(batches, None)
            ready = coming.result()
            coming = None if following is None else thread.submit(prepare, following)
            yield batch, ready
            batch = following
