"""Small constants as tensors, made once for each device: a GPU that is handed one waits for the host."""

from __future__ import annotations

from functools import lru_cache

import torch


@lru_cache
def constant(values: tuple, device: torch.device, dtype: torch.dtype) -> torch.Tensor:
    """These numbers as a tensor, which nobody may change."""
    # Whoever asks first may be inferring, and others learn: no gradient may pass what inference has made.
    with torch.inference_mode(False):
        return torch.tensor(values, dtype=dtype, device=device)
