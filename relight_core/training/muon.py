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

    def __init__(self, matrices: Iterable[torch.nn.Parameter], lr: float, weight_decay: float):
        """Take charge of matrices (rows, columns).

        Args:
            lr: spectral norm of a step; of one that maps to more than it reads, times the root of their ratio.
            weight_decay: share of a weight that goes per unit of `lr`.
        """
        super().__init__(matrices, {"lr": lr, "weight_decay": weight_decay})

    @torch.no_grad()
    def step(self, closure: None = None) -> None:
        """Move every matrix that has a gradient."""
        for group in self.param_groups:
            for matrix in group["params"]:
                if matrix.grad is not None:
                    self._move(matrix, group["lr"], group["weight_decay"])

    def _move(self, matrix: torch.nn.Parameter, rate: float, weight_decay: float) -> None:
        state = self.state[matrix]
        if not state:
            state["momentum_buffer"] = torch.zeros_like(matrix)
        momentum = state["momentum_buffer"].lerp_(matrix.grad, 1 - _MOMENTUM)
        ahead = matrix.grad.lerp(momentum, _MOMENTUM)
        rows, columns = matrix.shape
        matrix.mul_(1 - rate * weight_decay)
        matrix.add_(evened(ahead), alpha=-rate * math.sqrt(max(1.0, rows / columns)))


def evened(matrix: torch.Tensor) -> torch.Tensor:
    """A matrix of the same singular vectors, with singular values of about one where they were not next to nothing.

    An odd polynomial of a matrix X is a polynomial of X X^T, times X; repeated, only the small square one changes.
    """
    if matrix.shape[0] > matrix.shape[1]:
        return evened(matrix.T).T
    matrix = matrix / matrix.norm().clamp_min(_LEAST_NORM)
    a, b, c = _QUINTIC
    gram = matrix @ matrix.T
    identity = torch.eye(len(gram), dtype=gram.dtype, device=gram.device)
    factor = identity
    for _ in range(_TIMES):
        once = torch.addmm(torch.add(a * identity, gram, alpha=b), gram, gram, alpha=c)
        factor = once @ factor
        gram = once @ gram @ once
    return factor @ matrix
