"""Images as tensors and back, and tensors of images at other sizes."""

from __future__ import annotations

import numpy as np
import torch
import torch.nn.functional as F


def as_image(tensor: torch.Tensor) -> np.ndarray:
    """(1, C, S, S) to (S, S, C), or (S, S) for one channel; float32."""
    array = np.ascontiguousarray(tensor[0].permute(1, 2, 0).float().cpu().numpy())
    return array[..., 0] if array.shape[-1] == 1 else array


def as_tensor(image: np.ndarray, device: torch.device | str = "cpu") -> torch.Tensor:
    """(S, S, C) or (S, S), float32, to (1, C, S, S)."""
    return torch.from_numpy(np.ascontiguousarray(np.atleast_3d(image))).permute(2, 0, 1)[None].to(device)


def enlarge(tensor: torch.Tensor, size: int | tuple[int, int]) -> torch.Tensor:
    """(B, C, s, s) to (B, C, size, size), or of a height and a width, bilinear."""
    return F.interpolate(tensor.float(), size=size, mode="bilinear", align_corners=False)


def resized(tensor: torch.Tensor, size: int) -> torch.Tensor:
    """(B, C, s, s) to (B, C, size, size): averages where that is smaller, bilinear where it is larger."""
    if tensor.shape[-1] == size:
        return tensor
    return F.interpolate(tensor, size=size, mode="area") if tensor.shape[-1] > size else enlarge(tensor, size)
