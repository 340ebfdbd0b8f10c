"""The sampler, which removes noise: a generator over any `denoise(x, sigma)`, x [B, ...] and sigma [B]."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence

import torch
from torch import Tensor

from lidardraft.diffusion.channels import STATE_CHANNELS
from lidardraft.diffusion.codec import encode_rays
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.denoiser_config import GUIDANCE, LAST_NOISE, STEPS
from lidardraft.diffusion.noise import karras_levels
from lidardraft.errors import SensorError
from lidardraft.networks.layers import reduced_precision
from lidardraft.scene.sensor import Sensor

Denoise = Callable[[Tensor, Tensor], Tensor]


def sample(
    denoiser: Denoiser,
    sensor: Sensor,
    *,
    seeds: Sequence[int],
    condition: Tensor | None = None,
    steps: int = STEPS,
    guidance: float = GUIDANCE,
    last_noise: float = LAST_NOISE,
) -> Iterator[Tensor]:
    """The states [B, 8, H, W] after each step of `sample_multistep`, one sample a seed; the last one is the result.

    `condition` is [B, 8, H, W], or one for all [1, 8, H, W]; without it the samples are unconditional. `guidance`
    multiplies the ControlNet's change of its base, which takes a second call of the network unless it is 1
    (classifier-free guidance, Ho and Salimans, 2022). Samples begin as pure noise; the last call is made at
    `last_noise`. Works on the device of the weights. Raises `SensorError` if the image cannot be cut into the network's
    cells.
    """
    rows, columns = denoiser.cell
    if sensor.shape[0] % rows or sensor.shape[1] % columns:
        raise SensorError(f"{sensor.name} is {sensor.shape}; these weights need multiples of ({rows}, {columns})")
    device = next(denoiser.parameters()).device
    rays = torch.from_numpy(encode_rays(sensor)).to(device)
    sigmas, shape = karras_levels(steps, sigma_min=last_noise), (STATE_CHANNELS, *sensor.shape)
    noise = [torch.randn(shape, generator=torch.Generator().manual_seed(int(seed))) for seed in seeds]
    if condition is not None:
        condition = condition.to(device).expand(len(seeds), -1, -1, -1)

    with reduced_precision(device):
        reading = None if condition is None else denoiser.read(condition, rays, wraps=sensor.wraps)

    def denoise(x: Tensor, sigma: Tensor) -> Tensor:
        with reduced_precision(device):
            clean = denoiser.denoise(x, sigma, rays, condition, wraps=sensor.wraps, reading=reading)
            if reading is None or guidance == 1:
                return clean
            return torch.lerp(denoiser.denoise(x, sigma, rays, wraps=sensor.wraps), clean, guidance)

    return sample_multistep(denoise, sigmas[0] * torch.stack(noise).to(device), sigmas)


def sample_multistep(denoise: Denoise, x: Tensor, sigmas: Sequence[float]) -> Iterator[Tensor]:
    """The state after each step along `sigmas`, from x at the level sigmas[0] to 0; one call a step.

    DPM-Solver++(2M), Lu et al., 2022, Algorithm 2: the previous step gives the second order; the first step and a step
    to 0 have the first.
    """
    before: tuple[Tensor, float] | None = None
    for sigma, below in itertools.pairwise(sigmas):
        clean = denoise(x, x.new_full((len(x),), sigma))
        estimate = clean
        if before is not None and below > 0:
            earlier, above = before
            # r = h_before / h in the half log signal-to-noise ratio -ln(sigma), in which the method is a multistep one.
            r = math.log(above / sigma) / math.log(sigma / below)
            estimate = clean + (clean - earlier) / (2 * r)
        x = below / sigma * x + (1 - below / sigma) * estimate
        before = clean, sigma
        yield x
