"""Muon: momentum whose singular values are all brought near one (Jordan et al. 2024).

PyTorch's own multiplies in bf16, which takes a processor without such instructions fifteen seconds a step of
de-lighting. This one works in fp32, and in the small matrix of products between rows, where it takes a third of the
multiplications.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import torch

_QUINTIC = (3.4445, -4.7750, 2.0315)
"""x -> a x + b x^3 + c x^5: five times over, this takes all of (0.003, 1] into (0.7, 1.2) (Jordan et al. 2024)."""
_TIMES = 5
_MOMENTUM = 0.95
_LEAST_NORM = 1e-7


class Muon(torch.optim.Optimizer):
    """Steps along momentum with its singular values near one; for weights that are matrices."""

    def __init__(self, matrices: Iterable[torch.nn.Parameter], lr: float | torch.Tensor, weight_decay: float):
        """Take charge of matrices (rows, columns).

        Args:
            lr: spectral norm of a step; of one that maps to more than it reads, times the root of their ratio.
                A number, or a tensor of one, which may then be filled with another.
            weight_decay: share of a weight that goes per unit of `lr`.
        """
        super().__init__(matrices, {"lr": lr, "weight_decay": weight_decay})

    @torch.no_grad()
    def step(self, closure: None = None) -> None:
        """Move every matrix that has a gradient, those of one shape together: on a GPU they take as long as one."""
        for group in self.param_groups:
            alike: dict[torch.Size, list[torch.nn.Parameter]] = {}
            for matrix in group["params"]:
                if matrix.grad is not None:
                    alike.setdefault(matrix.shape, []).append(matrix)
            for matrices in alike.values():
                self._move(matrices, group["lr"], group["weight_decay"])

    def _move(self, matrices: list[torch.nn.Parameter], rate: float | torch.Tensor, weight_decay: float) -> None:
        gradients = [matrix.grad for matrix in matrices]
        momenta = [self._momentum(matrix) for matrix in matrices]
        torch._foreach_lerp_(momenta, gradients, 1 - _MOMENTUM)
        ahead = evened(torch.stack(torch._foreach_lerp(gradients, momenta, _MOMENTUM)))
        rows, columns = matrices[0].shape
        ahead = ahead * (rate * math.sqrt(max(1.0, rows / columns)))
        torch._foreach_mul_(matrices, 1 - rate * weight_decay)
        torch._foreach_sub_(matrices, list(ahead))

    def _momentum(self, matrix: torch.nn.Parameter) -> torch.Tensor:
        state = self.state[matrix]
        if not state:
            state["momentum_buffer"] = torch.zeros_like(matrix)
        return state["momentum_buffer"]


def evened(matrices: torch.Tensor) -> torch.Tensor:
    """Matrices (..., rows, columns) of the same singular vectors, with values of about one where there were any.

    An odd polynomial of a matrix X is a polynomial of X X^T, times X; repeated, only the small square one changes.
    """
    if matrices.shape[-2] > matrices.shape[-1]:
        return evened(matrices.mT).mT
    matrices = matrices / torch.linalg.matrix_norm(matrices, keepdim=True).clamp_min(_LEAST_NORM)
    a, b, c = _QUINTIC
    gram = matrices @ matrices.mT
    identity = torch.eye(gram.shape[-1], dtype=gram.dtype, device=gram.device)
    factor = identity
    for _ in range(_TIMES):
        once = a * identity + b * gram + c * (gram @ gram)
        factor = once @ factor
        gram = once @ gram @ once
    return factor @ matrices
