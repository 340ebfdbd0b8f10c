"""Training the generator: pairs on disk become a denoiser, or a ControlNet on one, on disk."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from lidardraft.diffusion.codec import encode_condition, encode_elevations, encode_scan
from lidardraft.diffusion.denoiser import Denoiser, DenoiserConfig
from lidardraft.diffusion.noise import training_levels
from lidardraft.errors import TrainingError
from lidardraft.networks.precision import reduced_precision
from lidardraft.scene.sensor import Sensor
from lidardraft.training.learner import LearningConfig
from lidardraft.training.loop import Batch, Measures, Report, device_for_training, train
from lidardraft.training.pairs import PairFolder

BANDS = (0.0, 0.05, 0.2, 1.0, float("inf"))  # edges of the noise levels that are reported apart
_SILENT = 20  # steps after which a zero convolution must have learned


@dataclass(frozen=True, kw_only=True)
class DenoisingConfig(LearningConfig):
    """All that decides the result of one stage, beside the pairs and, in the second, the base.

    Batches are crops of `crop` columns at random places, mirrored half the time. The first `zero_conv_steps` of the
    second stage leave the encoder's copy alone. ln sigma is normal with `sigma_mean` and `sigma_std`. The other fields
    are those of `LearningConfig`.
    """

    denoiser: DenoiserConfig
    zero_conv_steps: int = 0
    crop: int = 256
    sigma_mean: float = -1.0
    sigma_std: float = 1.4

    def check(self, sensor: Sensor) -> None:
        """Raise `TrainingError` where scans of this sensor cannot be trained on so."""
        self.check_counts()
        height, width = sensor.shape
        rows, columns = self.denoiser.cell
        if height % rows or self.crop % columns:
            raise TrainingError(
                f"{height} rows and crops of {self.crop} columns must be whole cells of {rows} x {columns}"
            )
        if not 1 <= self.crop <= width:
            raise TrainingError(f"crop is {self.crop}; it must be 1 to {width}, the columns of {sensor.name}")


def train_denoiser(
    config: DenoisingConfig,
    pairs: PairFolder,
    run: str | os.PathLike[str],
    *,
    base: Denoiser | None = None,
    device: str = "cpu",
    max_minutes: float = float("inf"),
) -> Iterator[Report]:
    """Train a denoiser on pairs, or, given a `base`, a ControlNet on it while it stays frozen.

    What the folder `run` receives, and how a run goes on, is said at `training.loop.train`; the loss is also reported
    by bands of noise. Raises `TrainingError` as that does, and where the pairs or the device do not fit.
    """
    config.check(pairs.sensor)
    if len(pairs) == 0:
        raise TrainingError("the folder holds no pairs")
    if base is not None and base.config != config.denoiser:
        raise TrainingError(f"the base is a {base.config}; this recipe needs a {config.denoiser}")
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(config.seed)
        denoiser = Denoiser.from_config(config.denoiser) if base is None else base.with_controlnet()
    on = device_for_training(device)
    beams = torch.from_numpy(encode_elevations(pairs.sensor)).to(on)
    wraps = pairs.sensor.wraps and config.crop == pairs.sensor.columns

    def batch(step: int) -> Batch:
        return _batch(config, pairs, step, conditional=base is not None)

    def loss(step: int, batch: Batch) -> tuple[Tensor, Measures]:
        if denoiser.controlnet is not None:
            denoiser.controlnet.encoder.requires_grad_(step >= config.zero_conv_steps)
        clean, sigma, noise, *condition = batch
        with reduced_precision(on):
            losses = denoiser.loss(clean, sigma, noise, beams, *condition, wraps=wraps)
        return losses, _by_band(sigma, losses.detach())

    for report in train(config, denoiser, batch, loss, pairs, run, device=on, max_minutes=max_minutes):
        _check_zero_convs(denoiser, report.step)
        yield report


def _by_band(sigma: Tensor, losses: Tensor) -> Measures:
    return {
        f"loss, sigma {low:g} to {high:g}": losses[(low <= sigma) & (sigma < high)]
        for low, high in itertools.pairwise(BANDS)
    }


def _check_zero_convs(denoiser: Denoiser, step: int) -> None:
    """Stop a run that has gone wrong, in words, rather than let it go on for days."""
    if denoiser.controlnet is not None and step >= _SILENT:
        for name, weight in denoiser.controlnet.zero_convs():
            if not weight.any():
                raise TrainingError(f"zero convolution {name!r} is still zero after {step} steps")


def _batch(config: DenoisingConfig, pairs: PairFolder, step: int, *, conditional: bool) -> Batch:
    """Clean crops, noise levels, noise and, where asked for, conditions of a step."""
    random = np.random.default_rng((config.seed, step))
    generator = torch.Generator().manual_seed(int(random.integers(2**62)))
    sensor = pairs.sensor
    starts = sensor.columns if sensor.wraps else sensor.columns - config.crop + 1
    clean, conditions = [], []
    for i in random.integers(len(pairs), size=config.batch):
        scan, condition_image = pairs[int(i)]
        start, mirrored = int(random.integers(starts)), bool(random.random() < 0.5)
        mirrored = mirrored and not any(sensor.azimuth_offsets)  # the mirror image of staggered beams is another sensor
        clean.append(_crop(encode_scan(scan), start, config.crop, mirrored))
        if conditional:
            conditions.append(_crop(encode_condition(condition_image), start, config.crop, mirrored))
    batch = torch.stack(clean)
    sigma = training_levels(config.batch, generator, mean=config.sigma_mean, std=config.sigma_std)
    noise = torch.randn(batch.shape, generator=generator)
    return batch, sigma, noise, *([torch.stack(conditions)] if conditional else [])


def _crop(image: np.ndarray, start: int, width: int, mirrored: bool) -> Tensor:
    """`width` columns of an image [C, H, W] from column `start` on, around the ring; `mirrored` left to right."""
    rest = max(start + width - image.shape[-1], 0)
    crop = np.concatenate([image[..., start : start + width], image[..., :rest]], axis=-1)
    return torch.from_numpy(np.ascontiguousarray(crop[..., ::-1] if mirrored else crop))
