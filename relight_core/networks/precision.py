"""What a device multiplies quickly: bf16 where it has instructions for it, else fp32."""

from __future__ import annotations

import torch


def has_bf16(device: str) -> bool:
    """Whether a device multiplies bf16 natively. A processor that doesn't emulates it, at a tenth of fp32's speed."""
    return device != "cpu" or torch.cpu._is_avx512_bf16_supported()


def mixed_precision(device: str) -> torch.autocast:
    """bf16 under autocast where the device has it; a context that changes nothing where it has not."""
    return torch.autocast(device, torch.bfloat16, enabled=has_bf16(device))
