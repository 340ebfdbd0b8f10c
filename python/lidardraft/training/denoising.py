"""Training the generator: pairs become a denoiser, or a ControlNet on one, on disk."""

from __future__ import annotations

import dataclasses
import itertools
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from lidardraft.diffusion.codec import decode_scan, encode_scan
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.diffusion.noise import training_levels
from lidardraft.diffusion.sampler import sample
from lidardraft.errors import TrainingError
from lidardraft.metrics.adherence import adherence
from lidardraft.networks.layers import reduced_precision
from lidardraft.scene.sensor import Sensor
from lidardraft.streets import StreetConfig, streets
from lidardraft.training.learner import LearningConfig
from lidardraft.training.loop import Measures, Report, device_for_training, train
from lidardraft.training.processes import Processes
from lidardraft.training.sources import PairSource, scans_of_step

OWN, OTHER = "objects", "objects of the other street"
_SEED = 2_000_000  # of streets that no training learns from
_STREETS = 2
_CALLS = 8  # of the network a scan, from noise
_DEADLINE = 1_000  # steps after which a network must follow its condition
BANDS = (0.0, 0.05, 0.2, 1.0, float("inf"))  # edges of the separately reported bands of noise


class AdherenceWatch:
    """Two unseen streets, each sampled from the same noise.

    A scan is scored against its own condition image and against the other one. A network that ignores its condition
    makes one scan for both streets, and both scores are equal.
    """

    def __init__(self, sensor: Sensor) -> None:
        config = StreetConfig(sensor=sensor, poses_per_street=1)
        pairs = list(itertools.islice(streets(seed=_SEED, config=config), _STREETS))
        self.sensor = sensor
        self.condition_images = [pair.condition_image for pair in pairs]
        self.condition = torch.from_numpy(np.stack(list(map(encode_scan, self.condition_images))))

    @torch.no_grad()
    def measure(self, denoiser: Denoiser) -> dict[str, float]:
        """Mean adherence on objects, of the scans to their own condition images and to those of the other street."""
        seeds = [0] * len(self.condition)
        *_, states = sample(denoiser, self.sensor, seeds=seeds, condition=self.condition, steps=_CALLS, guidance=1)
        scans = [decode_scan(state, self.sensor) for state in states.cpu().numpy()]
        images = self.condition_images
        own = [adherence(scan, image).objects for scan, image in zip(scans, images, strict=True)]
        other = [adherence(scan, image).objects for scan, image in zip(scans, reversed(images), strict=True)]
        return {OWN: float(np.mean(np.nan_to_num(own))), OTHER: float(np.mean(np.nan_to_num(other)))}

    def check(self, measured: dict[str, float], step: int) -> None:
        """Raise `TrainingError` if the condition is still ignored after 1,000 steps: hours would be wasted."""
        if step >= _DEADLINE and not measured[OWN] > measured[OTHER]:
            raise TrainingError(
                f"the network ignores its condition after {step} steps: of its returns on objects "
                f"{measured[OWN]:.1%} agree with the layout, and {measured[OTHER]:.1%} with another one"
            )


@dataclass(frozen=True, kw_only=True)
class DenoisingConfig(LearningConfig):
    """All parameters that decide the result of one stage, except the pairs and, with a ControlNet, the base.

    A batch holds `batch` whole scans of 64 x 1024, fewer of larger ones, mirrored half the time. The first
    `zero_conv_steps` train the ControlNet's zero convolutions alone. Every `watch_every` steps (0: never) two fixed
    unseen streets are sampled, and a network that ignores its condition is reported (`AdherenceWatch`). A step uses
    every beam and column, or every n-th, with n drawn from `thinnings`: n^2 times as many scans at the same cost. ln
    sigma is normal with `sigma_mean` and `sigma_std`: estimates near the -1.2 and 1.2 of Karras et al. (NeurIPS 2022,
    Table 1), somewhat higher and wider. The other fields are those of `LearningConfig`.
    """

    denoiser: DenoiserConfig
    zero_conv_steps: int = 0
    watch_every: int = 0
    thinnings: tuple[int, ...] = (1,)
    sigma_mean: float = -0.8
    sigma_std: float = 1.6

    def check(self, sensors: Iterable[Sensor]) -> None:
        """Raise `TrainingError` if this recipe cannot train on scans of one of these sensors."""
        self.check_counts()
        cell = tuple(max(self.thinnings) * side for side in self.denoiser.cell)
        for sensor in sensors:
            if any(size % whole for size, whole in zip(sensor.shape, cell, strict=True)):
                raise TrainingError(f"{sensor.name} is {sensor.shape}; this recipe needs multiples of {cell}")


def train_denoiser(
    config: DenoisingConfig,
    source: PairSource,
    run: str | os.PathLike[str],
    *,
    begin: Denoiser | None = None,
    device: str | None = "cpu",
    max_minutes: float = float("inf"),
) -> Iterator[Report]:
    """Train a denoiser on pairs, from fresh weights, those of `begin` or of the base of `begin`. If it has a
    ControlNet, train that alone, on a frozen base.

    `training.loop.train` describes the contents of the folder `run`, and how a run continues; the loss is also reported
    by bands of noise. Raises `TrainingError` as that does, and if the pairs or the device do not fit.
    """
    config.check(source.sensors)
    on = device_for_training(device)
    processes = Processes.from_environment(on)
    denoiser = beginning(config, begin)
    watches = config.watch_every and config.denoiser.condition
    watch = AdherenceWatch(source.sensor or Sensor.preset("hdl64e")) if watches else None

    def watched(step: int) -> Measures:
        if watch is None or step % config.watch_every:
            return {}
        measured = watch.measure(denoiser)
        watch.check(measured, step)
        return {name: torch.tensor(value) for name, value in measured.items()}

    def loss(step: int, batch: _Batch) -> tuple[Tensor, Measures]:
        if denoiser.controlnet is not None:
            denoiser.controlnet.learn(everything=step >= config.zero_conv_steps)
        with reduced_precision(on):
            losses = denoiser.loss(
                batch.clean, batch.sigma, batch.noise, batch.rays, batch.condition, wraps=batch.wraps
            )
        return losses, _by_band(batch.sigma, losses.detach()) | watched(step)

    batch = partial(_batch, source=source, processes=processes, device=on)
    yield from train(config, denoiser, batch, loss, source, run, device=on, max_minutes=max_minutes)


def beginning(config: DenoisingConfig, begin: Denoiser | None) -> Denoiser:
    """The denoiser before its first step; raises `TrainingError` if the recipe's cannot begin with `begin`."""
    needed = config.denoiser
    base = dataclasses.replace(needed, condition=(), controlnet=False)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(config.seed)
        if begin is None:
            if needed.controlnet:
                raise TrainingError("a ControlNet needs a base, which learned without a condition")
            return Denoiser.from_config(needed)
        if begin.config != needed:
            begin = begin.base()
        if begin.config == needed:
            return begin
        for name, has in vars(begin.config).items():
            if has != (needs := getattr(base, name)):
                raise TrainingError(f"the weights to begin with are of another form: {name} is {has}, not {needs}")
        return begin.with_controlnet(needed) if needed.controlnet else begin.with_condition(needed)


def _by_band(sigma: Tensor, losses: Tensor) -> Measures:
    return {
        f"loss, sigma {low:g} to {high:g}": losses.where((low <= sigma) & (sigma < high), torch.nan)
        for low, high in itertools.pairwise(BANDS)
    }


class _Batch(NamedTuple):
    """The tensors of a step, on its device: clean states, noise levels, noise, rays, conditions, or None for a base,
    and whether the columns wrap."""

    clean: Tensor
    sigma: Tensor
    noise: Tensor
    rays: Tensor
    condition: Tensor | None
    wraps: bool


def _batch(
    config: DenoisingConfig, step: int, *, source: PairSource, processes: Processes, device: torch.device
) -> _Batch:
    """The batch of this process in a step. It is a function of the step; the noise differs between kinds of device."""
    random = np.random.default_rng((config.seed, step))
    levels, noises = torch.Generator(), torch.Generator(device)
    levels.manual_seed(int(random.integers(2**62)))
    noises.manual_seed(int(random.integers(2**62)))
    every = int(random.choice(config.thinnings))
    stack = source.stack(step, config.batch * every**2, processes, device)
    scans = scans_of_step(config.batch * every**2, stack.sensor)
    stack = stack.thinned(every)
    # A state is not mirrored, as it is filled from the left.
    if random.random() < 0.5 and not any(stack.sensor.azimuth_offsets):
        stack = stack.mirrored()
    share = list(processes.share(scans))
    clean = stack.states()
    sigma = training_levels(scans, levels, mean=config.sigma_mean, std=config.sigma_std)[share].to(device)
    noise = torch.randn((scans, *clean.shape[1:]), generator=noises, device=device)[share]
    condition = stack.conditions() if config.denoiser.condition else None
    return _Batch(clean, sigma, noise, stack.rays, condition, stack.sensor.wraps)
