"""The sampler: noise is removed here. A generator over any `denoise(x, sigma)`, x [B, ...] and sigma [B]."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence

import torch
from torch import Tensor

from lidardraft.diffusion.codec import STATE_CHANNELS, encode_elevations
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.noise import gaussian, karras_levels
from lidardraft.errors import SensorError
from lidardraft.networks.precision import reduced_precision
from lidardraft.scene.sensor import Sensor

Denoise = Callable[[Tensor, Tensor], Tensor]


def sample(
    denoiser: Denoiser, sensor: Sensor, *, seeds: Sequence[int], condition: Tensor | None = None, steps: int = 20
) -> Iterator[Tensor]:
    """The states [B, 3, H, W] after each step of `sample_multistep`, one sample a seed; the last one is the result.

    `condition` [B, K + 2, H, W], or one for all [1, K + 2, H, W]; without it the samples are unconditional. Works on
    the device of the weights. Raises `SensorError` where the image cannot be cut into the network's cells.
    """
    rows, columns = denoiser.config.cell
    if sensor.shape[0] % rows or sensor.shape[1] % columns:
        raise SensorError(f"{sensor.name} is {sensor.shape}; these weights need multiples of ({rows}, {columns})")
    device = next(denoiser.parameters()).device
    beams = torch.from_numpy(encode_elevations(sensor)).to(device)
    sigmas = karras_levels(steps)
    noise = torch.stack([gaussian((STATE_CHANNELS, *sensor.shape), seed) for seed in seeds]).to(device)
    if condition is not None:
        condition = condition.to(device).expand(len(seeds), -1, -1, -1)

    def denoise(x: Tensor, sigma: Tensor) -> Tensor:
        with reduced_precision(device):
            return denoiser.denoise(x, sigma, beams, condition, wraps=sensor.wraps)

    return sample_multistep(denoise, sigmas[0] * noise, sigmas)


def sample_multistep(denoise: Denoise, x: Tensor, sigmas: Sequence[float]) -> Iterator[Tensor]:
    """The state after each step along `sigmas`, from pure noise x = sigmas[0] * gaussian to 0; one call a step.

    DPM-Solver++(2M), Lu et al., 2022, Algorithm 2: the step before gives the second order; the first step and a step to
    0 have the first.
    """
    before: tuple[Tensor, float] | None = None
    for sigma, below in itertools.pairwise(sigmas):
        clean = denoise(x, x.new_full((len(x),), sigma))
        estimate = clean
        if before is not None and below > 0:
            earlier, above = before
            # r = h_before / h in the half log signal-to-noise ratio -ln(sigma), where the method is a multistep one.
            r = math.log(above / sigma) / math.log(sigma / below)
            estimate = clean + (clean - earlier) / (2 * r)
        x = below / sigma * x + (1 - below / sigma) * estimate
        before = clean, sigma
        yield x
