"""A training run that can be put down and taken up again as if nothing had happened."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field
from pathlib import Path

import torch
from safetensors import SafetensorError, safe_open
from torch import nn

from relight_core.errors import InputError
from relight_core.imaging.files import check_regular, whole_file
from relight_core.networks.tensor_file import checksum, tensor_file
from relight_core.training.optimiser import Optimiser

_FORMATS, _FORMAT = "relight-training-", "relight-training-4"
_LEARNT = ("weights.", "average.")
_CHECKSUM = "sha256"


@dataclass
class Progress:
    """Where a run stands.

    Attributes:
        step: steps taken, skipped ones counted in; also the number of the next batch.
        seconds: time spent, over all its parts.
        skipped: batches that were not finite, in all.
        in_a_row: the same, without a good one between.
        smoothed: running means of the losses.
        log: where the losses stood, every 50 steps and at the end.
    """

    step: int = 0
    seconds: float = 0.0
    skipped: int = 0
    in_a_row: int = 0
    smoothed: dict[str, float] = field(default_factory=dict)
    log: list[dict[str, float]] = field(default_factory=list)

    def take(self, losses: dict[str, float]) -> None:
        """Count one step; no losses stand for a batch that had to be skipped."""
        self.step += 1
        self.skipped += not losses
        self.in_a_row = 0 if losses else self.in_a_row + 1
        for name, value in losses.items():
            self.smoothed[name] = 0.98 * self.smoothed.get(name, value) + 0.02 * value

    def note(self, elapsed: float) -> None:
        """Add to the log where the losses stand, unless it ends there."""
        if not self.log or self.log[-1]["step"] != self.step:
            self.log.append({"step": self.step, "elapsed": elapsed, **self.smoothed})


@dataclass(frozen=True)
class State:
    """Everything a run's next step depends on, as of one moment: what is learnt later does not change it.

    Attributes:
        header: format, settings and progress, as text, and a checksum of all of it and of the tensors.
        tensors: by name, on the CPU: weights, their running average, the optimiser's moments, random state.
    """

    header: dict[str, str]
    tensors: dict[str, torch.Tensor]

    def write(self, path: Path) -> None:
        """Write it whole or not at all.

        Raises:
            ValueError: a weight or its running average is not finite; the file stays as it was.
        """
        for name, value in self.tensors.items():
            if name.startswith(_LEARNT) and not torch.isfinite(value).all():
                raise ValueError(f"{name} is not finite: not saved")
        with whole_file(path) as beside:
            beside.write_bytes(tensor_file(self.tensors, self.header))


def make_state(
    settings: dict[str, str | int],
    progress: Progress,
    weights: nn.Module,
    average: dict[str, torch.Tensor],
    optimiser: Optimiser,
) -> State:
    """A copy of where a run stands.

    Args:
        settings: by name, what is learnt and from which batches: a run that goes on has to be given the same.
    """
    tensors = {f"weights.{name}": value for name, value in weights.state_dict().items()}
    tensors |= {f"average.{name}": value for name, value in average.items()}
    tensors |= {f"optimiser.{name}": value for name, value in optimiser.moments().items()}
    tensors["random"] = torch.get_rng_state()
    if torch.cuda.is_available():
        tensors["random_on_gpu"] = torch.cuda.get_rng_state()
    tensors = {name: value.detach().cpu().contiguous().clone() for name, value in tensors.items()}
    header = {"format": _FORMAT, "settings": json.dumps(settings), "progress": json.dumps(progress.__dict__)}
    return State(header | {_CHECKSUM: _checksum(header, tensors)}, tensors)


def _checksum(header: dict[str, str], tensors: dict[str, torch.Tensor]) -> str:
    words = sorted((name, word) for name, word in header.items() if name != _CHECKSUM)
    return hashlib.sha256(repr((words, checksum(tensors))).encode()).hexdigest()


def load_state(
    path: Path,
    settings: dict[str, str | int],
    weights: nn.Module,
    average: dict[str, torch.Tensor],
    optimiser: Optimiser,
) -> Progress:
    """Read what `State.write` wrote into the run's own objects.

    Raises:
        InputError: the file is damaged, of an earlier version, or belongs to networks of another shape or to a run
            with other settings.
    """
    try:
        check_regular(path)
        with safe_open(path, framework="pt") as file:
            header = file.metadata() or {}
            _check_format(path, header.get("format", ""))
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        # Older states have no checksum.
        if header.get(_CHECKSUM, now := _checksum(header, tensors)) != now:
            raise ValueError("damaged: its checksum differs")
        _check_settings(path, json.loads(header["settings"]), settings)
        if any(value.isnan().any() for value in tensors.values()):
            raise ValueError("damaged: it holds what is no number")
        progress = Progress(**json.loads(header["progress"]))
        _check_shapes(path, _below("weights.", tensors), weights)
        weights.load_state_dict(_below("weights.", tensors))
        for name, value in _below("average.", tensors).items():
            average[name].copy_(value)
        optimiser.load_moments(_below("optimiser.", tensors))
        torch.set_rng_state(tensors["random"])
        if torch.cuda.is_available() and "random_on_gpu" in tensors:
            torch.cuda.set_rng_state(tensors["random_on_gpu"])
    except (OSError, SafetensorError, RuntimeError, KeyError, IndexError, TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: this state can't be gone on from ({error}); delete it to start again") from error
    return progress


def _check_format(path: Path, found: str) -> None:
    if found == _FORMAT:
        return
    what = "an earlier version's training run" if found.startswith(_FORMATS) else "not the state of a training run"
    raise InputError(f"{path}: {what}; delete it to start again")


def _check_settings(path: Path, begun_with: dict[str, str | int], given: dict[str, str | int]) -> None:
    for name, value in given.items():
        # Older states don't tell everything.
        if begun_with.get(name, value) != value:
            raise InputError(
                f"{path}: its run began with {name} {begun_with[name]} and not {value}; "
                "go on as it began, or delete it to start again"
            )


def _check_shapes(path: Path, saved: dict[str, torch.Tensor], weights: nn.Module) -> None:
    """Raise InputError for networks of other layers in a line; PyTorch would name every weight of them."""
    has = {name: value.shape for name, value in weights.state_dict().items()}
    other = [
        name for name in sorted(has.keys() | saved.keys()) if name not in saved or has.get(name) != saved[name].shape
    ]
    if other:
        raise InputError(
            f"{path}: its run began with other networks ({other[0]} and {len(other) - 1} more differ); "
            "go on as it began, or delete it to start again"
        )


def _below(prefix: str, tensors: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    return {name.removeprefix(prefix): value for name, value in tensors.items() if name.startswith(prefix)}
