"""Noise: its levels, and how it is added."""

from __future__ import annotations

import torch
from torch import Tensor

from lidardraft.diffusion.denoiser_config import LAST_NOISE
from lidardraft.errors import LidarDraftError


def karras_levels(
    steps: int, *, sigma_min: float = LAST_NOISE, sigma_max: float = 20.0, rho: float = 7.0
) -> list[float]:
    """The `steps` falling noise levels of a sampler and a last 0 (Karras et al., NeurIPS 2022, Eq. 5).

    `rho` is theirs (Table 1). Their `sigma_max` is 80, but states are within -1 and 1, so noise of 20 hides them. Their
    `sigma_min` is 0.002; small networks follow layouts better with 1, large ones are smoother with 0.1.
    """
    if steps < 1:
        raise LidarDraftError(f"steps is {steps}; it must be at least 1")
    if not sigma_max > sigma_min:
        raise LidarDraftError(f"sampling starts at the noise level {sigma_max}; it must be greater than {sigma_min}")
    high, low = sigma_max ** (1 / rho), sigma_min ** (1 / rho)
    return [(high + i / max(steps - 1, 1) * (low - high)) ** rho for i in range(steps)] + [0.0]


def training_levels(count: int, generator: torch.Generator, *, mean: float, std: float) -> Tensor:
    """Log-normal noise levels to train on, [count]: `mean` and `std` are those of ln sigma (ibid., Table 1).

    Stratified: each sample comes from its own equal part of the distribution, which lowers the variance of the loss.
    """
    uniform = (torch.randperm(count, generator=generator) + torch.rand(count, generator=generator)) / count
    return torch.exp(mean + std * torch.special.ndtri(uniform.clamp(1e-4, 1 - 1e-4)))


def add_noise(x: Tensor, sigma: Tensor, noise: Tensor) -> Tensor:
    """x + sigma * noise, with one `sigma` a sample [B]."""
    return x + sigma.to(x).reshape(-1, *[1] * (x.dim() - 1)) * noise
