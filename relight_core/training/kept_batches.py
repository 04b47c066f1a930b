"""Batches that are made once and kept on disk, so that several networks learn from exactly the same ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path

from safetensors import SafetensorError, safe_open

from relight_core.errors import InputError
from relight_core.imaging.files import whole_file
from relight_core.networks.tensor_file import checksum, tensor_file
from relight_core.training.half_kept import Batch, halved, whole_again

_CHECKSUM = "sha256"


def kept_batches(
    folder: Path, make: Callable[[int], Iterator[Batch]], first: int = 0, among: int | None = None
) -> Iterator[Batch]:
    """Batches from a number on: read from the folder, or made and kept there if they are missing.

    Images are kept in half precision, labels in a byte. A batch that has just been made is read back, so that it is
    rounded like all others. About 1 MB for four pairs at 64 pixels.

    Args:
        make: gives the batches from a number on; called only when one is missing.
        among: number of different batches, which are repeated; None for no limit.

    Raises:
        InputError: a kept batch is damaged, or one can't be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    making, comes_next = iter(()), None
    for place in count(first):
        number = place if among is None else place % among
        path = folder / f"batch-{number:06d}.safetensors"
        if not path.exists():
            making = making if number == comes_next else make(number)
            _keep(path, next(making))
            comes_next = number + 1
        yield _read(path)


def _keep(path: Path, batch: Batch) -> None:
    small = {name: value.contiguous() for name, value in halved(batch).items()}
    with whole_file(path) as beside:
        # safetensors' own writing to a file raises errors of its own on a full disk.
        beside.write_bytes(tensor_file(small, {_CHECKSUM: checksum(small)}))


def _read(path: Path) -> Batch:
    try:
        with safe_open(path, framework="pt") as file:
            batch = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
            # Older batches have no checksum.
            told = (file.metadata() or {}).get(_CHECKSUM)
        if told not in (None, checksum(batch)):
            raise ValueError("damaged: its checksum differs")
    except (OSError, SafetensorError, ValueError) as error:
        raise InputError(f"{path}: this batch can't be read ({error}); delete it, it is made again") from error
    return whole_again(batch)
