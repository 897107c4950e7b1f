"""Muon, an optimizer for convolutions with orthogonalised steps."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import torch
from torch import Tensor, nn

MOMENTUM = 0.95
BIAS_RATE = 0.2  # relative learning rate of biases and other parameters that form no matrix
BETAS = (0.9, 0.99)  # Adam's, for these parameters


class Muon(torch.optim.Optimizer):
    """Momentum with steps orthogonalised as matrices of output channels by inputs; Adam for biases.

    Parameters
    ----------
    parameters : the network's parameters
    learning_rate : float
        Length of a step in the spectral norm of the matrix.

    References
    ----------
    Jordan et al., *Muon: an optimizer for hidden layers in neural networks*, 2024; Kingma and Ba, *Adam: a method for
    stochastic optimization*, 2015.
    """

    def __init__(self, parameters: Iterable[nn.Parameter], learning_rate: float) -> None:
        super().__init__(parameters, {"lr": learning_rate})

    @torch.no_grad()
    def step(self, closure: Callable[[], float] | None = None) -> None:  # type: ignore[override]
        """Update the parameters by their gradients."""
        for group in self.param_groups:
            for parameter in group["params"]:
                if parameter.grad is not None:
                    turn = _orthogonal_step if parameter.ndim > 1 else _adam_step
                    parameter.add_(turn(parameter.grad, self.state[parameter]), alpha=-group["lr"])


def _orthogonal_step(gradient: Tensor, state: dict[str, Any]) -> Tensor:
    """Return the step of a convolution's weights, (outputs, inputs, 3, 3), at a learning rate of 1."""
    if not state:
        state["momentum"] = torch.zeros_like(gradient)
    momentum: Tensor = state["momentum"].lerp_(gradient, 1 - MOMENTUM)
    ahead = gradient.lerp(momentum, MOMENTUM)  # Nesterov momentum
    matrix = orthogonal(ahead.flatten(1))
    outputs, inputs = matrix.shape
    scale: float = max(1, outputs / inputs) ** 0.5
    return scale * matrix.view_as(ahead)


def _adam_step(gradient: Tensor, state: dict[str, Any]) -> Tensor:
    """Return Adam's step of other parameters, at a learning rate of 1."""
    if not state:
        state.update(step=torch.tensor(0.0), mean=torch.zeros_like(gradient), square=torch.zeros_like(gradient))
    state["step"] += 1
    step = float(state["step"])
    mean: Tensor = state["mean"].lerp_(gradient, 1 - BETAS[0]) / (1 - BETAS[0] ** step)
    square: Tensor = state["square"].lerp_(gradient.square(), 1 - BETAS[1]) / (1 - BETAS[1] ** step)
    change: Tensor = BIAS_RATE * mean / (square.sqrt() + 1e-8)
    return change


def orthogonal(matrix: Tensor) -> Tensor:
    """Return approximately the nearest orthogonal matrix, with singular values between 0.7 and 1.2.

    Five steps of a Newton-Schulz iteration of the fifth order, with Jordan's coefficients.
    """
    wide = matrix if matrix.size(0) <= matrix.size(1) else matrix.T
    x: Tensor = wide / (wide.norm() + 1e-7)
    for _ in range(5):
        square = x @ x.T
        x = 3.4445 * x + (-4.7750 * square + 2.0315 * square @ square) @ x
    return x if wide is matrix else x.T
