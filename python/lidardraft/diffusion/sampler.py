"""The samplers, which remove noise: a fast one, and the annealed Langevin dynamics of the paper's base.

Both are generators over any `denoise(x, sigma)`, x [B, ...] and sigma [B].
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np
import torch
from torch import Tensor

from lidardraft.diffusion.channels import STATE_CHANNELS
from lidardraft.diffusion.codec import encode_rays
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.denoiser_config import GUIDANCE, LAST_NOISE, STEPS
from lidardraft.diffusion.noise import geometric_levels, karras_levels, score_from_denoised
from lidardraft.errors import LidarDraftError, SensorError
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
    langevin: int | None = None,
) -> Iterator[Tensor]:
    """The states [B, 8, H, W] after each step of `sample_multistep`, one sample a seed; the last one is the result.

    `condition` [B, 17, H, W], or one for all [1, 17, H, W]; without it the samples are unconditional. What a ControlNet
    changes of its base is multiplied by `guidance`, which takes a second call of the network where it is not 1
    (classifier-free guidance, Ho and Salimans, 2022). They begin as pure noise; the last call is made at `last_noise`.
    With `langevin` a step is a level of `sample_langevin` with so many updates, as in the paper: LiDARGen takes 232 of
    5. Works on the device of the weights. Raises `SensorError` if the image cannot be cut into the network's cells.
    """
    rows, columns = denoiser.cell
    if sensor.shape[0] % rows or sensor.shape[1] % columns:
        raise SensorError(f"{sensor.name} is {sensor.shape}; these weights need multiples of ({rows}, {columns})")
    device = next(denoiser.parameters()).device
    rays = torch.from_numpy(encode_rays(sensor)).to(device)
    sigmas = karras_levels(steps, sigma_min=last_noise) if langevin is None else geometric_levels(steps)
    streams = [torch.Generator().manual_seed(int(seed)) for seed in seeds]

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


def sample_langevin(
    denoise: Denoise,
    x: Tensor,
    sigmas: Sequence[float],
    noise: Callable[[], Tensor],
    *,
    updates: int = 5,
) -> Iterator[Tensor]:
    """The state after each level of `sigmas`, which fall geometrically, from x at the level sigmas[0].

    LiDARGen (Zyrianov et al., ECCV 2022) samples so, as NCSNv2 does (Song and Ermon, "Improved Techniques for Training
    Score-Based Generative Models", NeurIPS 2020, Algorithm 1).

    A level takes `updates` calls and as many of `noise()`, which gives new standard normal noise like x; the last one
    is denoised by one call more, as LiDARGen does. Raises `LidarDraftError` on `updates` less than 1.
    """
    if updates < 1:
        raise LidarDraftError(f"updates is {updates}; it must be at least 1")
    ratio = sigmas[0] / sigmas[1] if len(sigmas) > 1 else 1.0
    step = langevin_step(ratio, updates)
    for number, sigma in enumerate(sigmas, start=1):
        level = x.new_full((len(x),), sigma)
        size = step * sigma**2
        for _ in range(updates):
            score = score_from_denoised(x, denoise(x, level), level)
            x = x + size * score + (2 * size) ** 0.5 * noise()
        yield x if number < len(sigmas) else denoise(x, level)


def langevin_step(ratio: float, updates: int) -> float:
    """The step size of a level in units of its variance, for levels that fall by `ratio` and so many updates each.

    NCSNv2's Technique 4: of data at a single point the spread after the updates is as close as it can be to that of the
    level. LiDARGen's constants are NCSNv2's for CIFAR-10: ratio 1.0376, 5 updates, 0.062.
    """
    steps = np.geomspace(1e-4, 1, 4000)
    settled = 1 / (1 - steps / 2)
    spread = (1 - steps) ** (2 * updates) * (ratio**2 - settled) + settled
    return float(steps[np.abs(spread - 1).argmin()])
