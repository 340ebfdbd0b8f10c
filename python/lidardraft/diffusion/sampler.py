"""The sampler: noise is removed here, or as in the paper in `langevin.py`.

Both are generators over any `denoise(x, sigma)`, x [B, ...] and sigma [B].
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence

import torch
from torch import Tensor

from lidardraft.diffusion.codec import STATE_CHANNELS, encode_rays
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.langevin import sample_langevin
from lidardraft.diffusion.noise import geometric_levels, karras_levels
from lidardraft.diffusion.sampling_defaults import GUIDANCE, STEPS
from lidardraft.errors import SensorError
from lidardraft.networks.precision import reduced_precision
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
    langevin: int | None = None,
) -> Iterator[Tensor]:
    """The states [B, 8, H, W] after each step of `sample_multistep`, one sample a seed; the last one is the result.

    `condition` [B, 17, H, W], or one for all [1, 17, H, W]; without it the samples are unconditional. What a ControlNet
    changes of its base is multiplied by `guidance`, which takes a second call of the network where it is not 1
    (classifier-free guidance, Ho and Salimans, 2022). They begin as pure noise. With `langevin` a step is a level of
    `sample_langevin` with so many updates, as in the paper: LiDARGen takes 232 of 5. Works on the device of the
    weights. Raises `SensorError` where the image cannot be cut into the network's cells.
    """
    rows, columns = denoiser.cell
    if sensor.shape[0] % rows or sensor.shape[1] % columns:
        raise SensorError(f"{sensor.name} is {sensor.shape}; these weights need multiples of ({rows}, {columns})")
    device = next(denoiser.parameters()).device
    rays = torch.from_numpy(encode_rays(sensor)).to(device)
    levels = karras_levels if langevin is None else geometric_levels
    sigmas = levels(steps)
    streams = [torch.Generator().manual_seed(seed) for seed in seeds]

    def noise() -> Tensor:
        shape = (STATE_CHANNELS, *sensor.shape)
        return torch.stack([torch.randn(shape, generator=stream) for stream in streams]).to(device)

    x = sigmas[0] * noise()
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

    if langevin is not None:
        return sample_langevin(denoise, x, sigmas, noise, updates=langevin)
    return sample_multistep(denoise, x, sigmas)


def sample_multistep(denoise: Denoise, x: Tensor, sigmas: Sequence[float]) -> Iterator[Tensor]:
    """The state after each step along `sigmas`, from x at the level sigmas[0] to 0; one call a step.

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
