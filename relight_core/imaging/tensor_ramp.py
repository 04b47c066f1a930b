"""A straight way from not at all to altogether: rules with one limit would make pictures jump there."""

from __future__ import annotations

import torch


def ramp(value: torch.Tensor, start: float, full: float) -> torch.Tensor:
    """0 up to `start`, 1 from `full` on, straight between; `full` may be the smaller one. Of any shape, in [0, 1]."""
    return ((value - start) / (full - start)).clamp(0, 1)
