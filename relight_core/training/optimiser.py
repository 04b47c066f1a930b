"""The optimiser: orthogonalised momentum for the convolutions between other layers, AdamW for the rest."""

from __future__ import annotations

import torch
from torch import nn

from relight_core.networks.blocks import ConvBlock
from relight_core.training.muon import Muon

_MATRIX_RATE = 20.0
"""Muon's steps have a spectral norm, Adam's an element size, in units of their rates; this is what makes
one rate fit both (0.02 beside 1e-3, as in Jordan et al. 2024, Muon)."""


class Optimiser:
    """Muon (Jordan et al. 2024) on the weights of every `ConvBlock` of more than three inputs, AdamW on all others.

    A convolution is a matrix from (kernel height, kernel width, inputs) to outputs. Muon's step along it has
    singular values of about one, so that rare directions learn as fast as common ones: the de-lighting
    network reached AdamW's loss after half of the steps or less.
    """

    def __init__(self, network: nn.Module, learning_rate: float):
        """Take charge of what in a network (channels last) has `requires_grad`."""
        hidden = {id(block.conv.weight) for block in network.modules() if isinstance(block, ConvBlock)}
        trained = [weight for weight in network.parameters() if weight.requires_grad]
        self.parameters = trained
        self._convolutions = [w for w in trained if id(w) in hidden and w.shape[1] > 3]
        # The matrices share the convolutions' memory, so a step on the former moves the latter.
        self._matrices = [nn.Parameter(_as_matrix(weight.detach())) for weight in self._convolutions]
        apart = {id(weight) for weight in self._convolutions}
        others = [weight for weight in trained if id(weight) not in apart]
        # On a GPU the rate lies where a recorded step reads it (see `training.step`).
        on_gpu = any(weight.is_cuda for weight in trained)
        rates = [factor * learning_rate for factor in (1.0, _MATRIX_RATE)]
        if on_gpu:
            rates = [torch.tensor(rate, device=trained[0].device) for rate in rates]
        adam = {"weight_decay": 1e-4, "fused": True, "capturable": on_gpu}
        self._steps = [torch.optim.AdamW(others, lr=rates[0], **adam)]
        if self._matrices:
            self._steps.append(Muon(self._matrices, lr=rates[1], weight_decay=0.01))

    def set_learning_rate(self, learning_rate: float) -> None:
        """Use another rate from the next step on (AdamW's; Muon's follows)."""
        for optimiser, factor in zip(self._steps, (1.0, _MATRIX_RATE), strict=False):
            for group in optimiser.param_groups:
                if isinstance(group["lr"], torch.Tensor):
                    group["lr"].fill_(factor * learning_rate)
                else:
                    group["lr"] = factor * learning_rate

    def zero_grad(self) -> None:
        """Forget the gradients."""
        for weight in self.parameters:
            weight.grad = None

    def step(self) -> None:
        """Move all weights along their gradients."""
        for weight, matrix in zip(self._convolutions, self._matrices, strict=True):
            matrix.grad = None if weight.grad is None else _as_matrix(weight.grad)
        for optimiser in self._steps:
            optimiser.step()

    def moments(self) -> dict[str, torch.Tensor]:
        """Everything a next step depends on beside weights, gradients and rate, by name."""
        return {
            f"{number}.{index}.{name}": torch.as_tensor(value)
            for number, optimiser in enumerate(self._steps)
            for index, moments in optimiser.state_dict()["state"].items()
            for name, value in moments.items()
        }

    def load_moments(self, moments: dict[str, torch.Tensor]) -> None:
        """Take up what `moments` gave.

        Raises:
            ValueError: they are about other weights.
        """
        for number, optimiser in enumerate(self._steps):
            weights = [weight for group in optimiser.param_groups for weight in group["params"]]
            state: dict[int, dict[str, torch.Tensor]] = {}
            for name, value in moments.items():
                owner, index, moment = name.split(".", 2)
                if int(owner) == number:
                    like = weights[int(index)].detach()
                    state.setdefault(int(index), {})[moment] = _laid_out_like(like, value)
            if len(state) not in (0, len(weights)):
                raise ValueError(f"it is about {len(state)} weights, this stage changes {len(weights)}")
            optimiser.load_state_dict({**optimiser.state_dict(), "state": state})


def _as_matrix(weight: torch.Tensor) -> torch.Tensor:
    """A convolution's weights (outputs, inputs, h, w), channels last in memory, seen as (outputs, h * w * inputs)."""
    return weight.permute(0, 2, 3, 1).flatten(1)


def _laid_out_like(weight: torch.Tensor, moment: torch.Tensor) -> torch.Tensor:
    """A moment in its weight's own memory layout: fused steps pair them by address."""
    if moment.ndim == 0:
        return moment
    if moment.shape != weight.shape:
        raise ValueError("it is about other networks or another stage")
    return torch.empty_like(weight).copy_(moment)
