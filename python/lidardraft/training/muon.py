"""Muon: gradient steps whose matrices have singular values of about 1 (Jordan et al., 2024, kellerjordan.github.io)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import torch
from torch import Tensor

_NEWTON_SCHULZ = (3.4445, -4.7750, 2.0315)  # the authors' coefficients: near 1 in five steps, not exact
_NEWTON_SCHULZ_STEPS = 5
_MOMENTUM = 0.95
_LEAST_SIDE = 16  # of a matrix; in smaller ones every direction is learned anyway
_ADAM_RATE = 0.1  # of the learning rate
_ADAM_BETAS, _ADAM_EPSILON = (0.9, 0.99), 1e-8


class Muon(torch.optim.Optimizer):
    """Weights that are matrices (convolutions: outputs by all else) move along their orthogonalised momentum, by the
    learning rate `lr`; all other weights by Adam, with a tenth of it."""

    def __init__(self, weights: Iterable[Tensor], *, lr: float, weight_decay: float) -> None:
        super().__init__(weights, {"lr": lr, "weight_decay": weight_decay})

    @torch.no_grad()
    def step(self, closure: Any = None) -> Any:
        """One step along the gradients."""
        assert closure is None
        for group in self.param_groups:
            for weight in group["params"]:
                if weight.grad is None:
                    continue
                if weight.ndim > 1 and min(len(weight), weight[0].numel()) >= _LEAST_SIDE:
                    self._step_of_matrix(weight, weight.grad, group["lr"], group["weight_decay"])
                else:
                    self._step_of_others(weight, weight.grad, _ADAM_RATE * group["lr"])

    def _step_of_matrix(self, weight: Tensor, gradient: Tensor, rate: float, decay: float) -> None:
        state = self.state[weight]
        if not state:
            state["momentum"] = torch.zeros_like(weight)
        momentum = state["momentum"].lerp_(gradient, 1 - _MOMENTUM)
        towards = gradient.lerp(momentum, _MOMENTUM).flatten(1)  # Nesterov's
        rows, columns = towards.shape
        size = rate * max(1.0, rows / columns) ** 0.5
        weight.mul_(1 - rate * decay).add_(orthogonalised(towards).view_as(weight), alpha=-size)

    def _step_of_others(self, weight: Tensor, gradient: Tensor, rate: float) -> None:
        state, (first, second) = self.state[weight], _ADAM_BETAS
        if not state:
            state["step"] = torch.zeros(())
            state["mean"], state["square"] = torch.zeros_like(weight), torch.zeros_like(weight)
        state["step"] += 1
        mean = state["mean"].lerp_(gradient, 1 - first) / (1 - first ** state["step"])
        square = state["square"].lerp_(gradient**2, 1 - second) / (1 - second ** state["step"])
        weight.add_(mean / (square.sqrt() + _ADAM_EPSILON), alpha=-rate)


def orthogonalised(matrix: Tensor) -> Tensor:
    """The matrix [M, N] with singular values between about 0.7 and 1.2, by Newton-Schulz steps.

    The steps are taken on what stands before the matrix, which is square and small, and not on itself.
    """
    a, b, c = _NEWTON_SCHULZ
    tall = matrix.shape[0] > matrix.shape[1]
    x = (matrix.T if tall else matrix) / (matrix.norm() + 1e-7)
    gram, before = x @ x.T, torch.eye(len(x), device=x.device)
    for _ in range(_NEWTON_SCHULZ_STEPS):
        now = before @ gram @ before.T
        before = a * before + (b * now + c * now @ now) @ before
    x = before @ x
    return x.T if tall else x
