"""A straight way from not at all to altogether: rules with one limit would make pictures jump there."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    import numpy as np
    import torch

Values = TypeVar("Values", float, "np.ndarray", "torch.Tensor")


def ramp(value: Values, start: float, full: float) -> Values:
    """0 up to `start`, 1 from `full` on, straight between; `full` may be the smaller one. A number or of any shape."""
    part = (value - start) / (full - start)
    return min(max(part, 0.0), 1.0) if isinstance(part, float) else part.clip(0, 1)


def smooth_ramp(value: Values, start: float, full: float) -> Values:
    """As `ramp`, but without a kink at either end: a cubic, flat at both."""
    part = ramp(value, start, full)
    return part * part * (3 - 2 * part)
