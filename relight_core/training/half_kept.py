"""Batches in half precision, to be kept for later."""

from __future__ import annotations

import torch

Batch = dict[str, torch.Tensor]


def halved(batch: Batch) -> Batch:
    """Images in half precision, labels in bytes, lights as they are."""
    return {name: value.to(_kept_type(name, value)) for name, value in batch.items()}


def whole_again(batch: Batch) -> Batch:
    """The reverse of `halved`: floats in single precision and labels as int64."""
    return {name: value.float() if value.is_floating_point() else value.long() for name, value in batch.items()}


def _kept_type(name: str, value: torch.Tensor) -> torch.dtype:
    if not value.is_floating_point():
        return torch.uint8
    return torch.float32 if name == "light" else torch.float16
