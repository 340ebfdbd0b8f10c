"""The training loop: pairs on disk become weights on disk."""

from __future__ import annotations

import dataclasses
import itertools
import json
import os
import time
import zlib
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from lidardraft.diffusion import checkpoint
from lidardraft.diffusion.codec import encode_condition, encode_elevations, encode_scan
from lidardraft.diffusion.denoiser import Denoiser, DenoiserConfig
from lidardraft.diffusion.noise import training_levels
from lidardraft.errors import TrainingError
from lidardraft.training.learner import Learner, LearningConfig
from lidardraft.training.pairs import PairFolder

BANDS = (0.0, 0.05, 0.2, 1.0, float("inf"))  # edges of the noise levels that are reported apart


@dataclass(frozen=True, kw_only=True)
class TrainingConfig(LearningConfig):
    """All that decides the result of one stage, beside the pairs and, in the second, the base.

    Batches are crops of `crop` columns at random places of the ring, mirrored half the time; their first and last
    `margin` columns do not count. The first `zero_conv_steps` of the second stage leave the encoder's copy alone.
    ln sigma is normal with `sigma_mean` and `sigma_std`. The other fields are those of `LearningConfig`.
    """

    denoiser: DenoiserConfig
    zero_conv_steps: int = 0
    crop: int = 256
    margin: int = 16
    sigma_mean: float = -1.0
    sigma_std: float = 1.4

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON types."""
        return {**dataclasses.asdict(self), "denoiser": self.denoiser.to_dict()}

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> TrainingConfig:
        """The inverse of `to_dict`; raises `TypeError` on an unknown or missing field."""
        return cls(**{**fields, "denoiser": DenoiserConfig.from_dict(fields["denoiser"])})


@dataclass(frozen=True, kw_only=True)
class Report:
    """Means since the last report; `bands` holds the loss in each band of `BANDS`, None where no sample fell."""

    step: int
    loss: float
    bands: tuple[float | None, ...]
    gradient: float
    crops_per_second: float
    minutes: float


def train(
    config: TrainingConfig,
    pairs: PairFolder,
    run: str | os.PathLike[str],
    *,
    base: Denoiser | None = None,
    device: str = "cpu",
    max_minutes: float = float("inf"),
) -> Iterator[Report]:
    """Train a denoiser on pairs, or, given a `base`, a ControlNet on it while it stays frozen.

    The folder `run` receives `log.jsonl`, `state.safetensors` to go on from after an interruption or `max_minutes`, and
    `weights.safetensors`, the average of weights. Batch t depends on the seed, the pairs and t only, so that a run in
    slices gives the weights of a run in one. Raises `TrainingError` where the run in the folder is another, the pairs
    or the device do not fit, or the training has gone wrong.
    """
    _check(config, pairs, base)
    run = Path(run)
    try:
        trainer = _Trainer(config, base, torch.device(device), encode_elevations(pairs.sensor))
    except (RuntimeError, AssertionError) as error:  # torch's, for a device it does not have
        raise TrainingError(f"device is {device!r}: {str(error).splitlines()[0]}") from None
    start = trainer.learner.resume(run / "state.safetensors")
    run.mkdir(parents=True, exist_ok=True)
    if start >= config.steps:
        return
    began, reported = time.monotonic(), time.monotonic()
    window: list[tuple[float, list[list[float]]]] = []
    with ThreadPoolExecutor(1) as loader:
        upcoming = loader.submit(_batch, config, pairs, start, base is not None)
        for step in range(start, config.steps):
            batch, upcoming = upcoming.result(), loader.submit(_batch, config, pairs, step + 1, base is not None)
            window.append(trainer.step(step, *batch))
            minutes = (time.monotonic() - began) / 60
            done = step + 1 == config.steps or minutes > max_minutes
            if done or (step + 1) % config.report_every == 0:
                report = _report(step + 1, window, config.batch, time.monotonic() - reported, minutes)
                with (run / "log.jsonl").open("a") as log:
                    log.write(json.dumps(dataclasses.asdict(report)) + "\n")
                trainer.check(report)
                window, reported = [], time.monotonic()
                yield report
            if done or (step + 1) % config.save_every == 0:
                trainer.save(run, step + 1)
            if done:
                return


class _Trainer:
    """A denoiser that learns."""

    def __init__(self, config: TrainingConfig, base: Denoiser | None, device: torch.device, beams: np.ndarray) -> None:
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(config.seed)
            denoiser = Denoiser.from_config(config.denoiser) if base is None else base.with_controlnet()
        self.config, self.device = config, device
        # On a CPU without bfloat16 instructions the emulated ones are slower than float32.
        supported = getattr(torch.cpu, "_is_avx512_bf16_supported", lambda: False)
        self.bfloat16 = device.type == "cuda" or supported()
        self.denoiser = denoiser.to(device).train()
        self.beams = torch.from_numpy(beams).to(device)
        frozen = [p.detach().cpu().numpy().tobytes() for p in denoiser.parameters() if not p.requires_grad]
        self.learner = Learner(self.denoiser, config, [zlib.crc32(b"".join(frozen)), config.of_any_length()])

    def step(
        self, step: int, clean: Tensor, sigma: Tensor, noise: Tensor, condition: Tensor | None
    ) -> tuple[float, list[list[float]]]:
        """One gradient step; the norm of the gradient, and (sigma, loss) of each sample."""
        controlnet = self.denoiser.controlnet
        if controlnet is not None:
            controlnet.encoder.requires_grad_(step >= self.config.zero_conv_steps)
        clean, sigma, noise = clean.to(self.device), sigma.to(self.device), noise.to(self.device)
        condition = None if condition is None else condition.to(self.device)
        with torch.autocast(self.device.type, dtype=torch.bfloat16, enabled=self.bfloat16):
            loss = self.denoiser.loss(clean, sigma, noise, self.beams, condition, self.config.margin)
        gradient = self.learner.step(step, loss.mean())
        return gradient, torch.stack([sigma, loss.detach()], dim=1).tolist()

    def check(self, report: Report) -> None:
        """Stop a run that has gone wrong, in words, rather than let it go on for days."""
        if not np.isfinite(report.loss):
            raise TrainingError(f"the loss is {report.loss} at step {report.step}")
        controlnet = self.denoiser.controlnet
        if controlnet is not None and report.step >= 20:
            for name, weight in controlnet.zero_convs():
                if not weight.any():
                    raise TrainingError(f"zero convolution {name!r} is still zero after {report.step} steps")

    def save(self, run: Path, step: int) -> None:
        """Write the state, then the averaged weights."""
        self.learner.save(run / "state.safetensors", step)
        with self.learner.averaged():
            card = {"training": self.config.to_dict(), "step": step}
            checkpoint.save(self.denoiser, run / "weights.safetensors", card)


def _check(config: TrainingConfig, pairs: PairFolder, base: Denoiser | None) -> None:
    for name, low in (("steps", 1), ("batch", 1), ("margin", 0), ("save_every", 1), ("report_every", 1)):
        if getattr(config, name) < low:
            raise TrainingError(f"{name} is {getattr(config, name)}; it must be at least {low}")
    height, width = pairs.sensor.shape
    rows, columns = config.denoiser.cell
    if height % rows or config.crop % columns:
        raise TrainingError(
            f"{height} rows and crops of {config.crop} columns must be whole cells of {rows} x {columns}"
        )
    if not 2 * config.margin < config.crop <= width:
        raise TrainingError(f"crop is {config.crop}; it must exceed two margins of {config.margin} and fit in {width}")
    if len(pairs) == 0:
        raise TrainingError("the folder holds no pairs")
    if base is not None and base.config != config.denoiser:
        raise TrainingError(f"the base is a {base.config}; this recipe needs a {config.denoiser}")


def _batch(
    config: TrainingConfig, pairs: PairFolder, step: int, conditional: bool
) -> tuple[Tensor, Tensor, Tensor, Tensor | None]:
    """Clean crops, noise levels, noise and conditions of a step."""
    random = np.random.default_rng((config.seed, step))
    generator = torch.Generator().manual_seed(int(random.integers(2**62)))
    clean, conditions = [], []
    for i in random.integers(len(pairs), size=config.batch):
        scan, condition_image = pairs[int(i)]
        start, mirrored = int(random.integers(scan.sensor.columns)), bool(random.random() < 0.5)
        mirrored = mirrored and not any(
            scan.sensor.azimuth_offsets
        )  # the mirror image of staggered beams is another sensor
        clean.append(_crop(encode_scan(scan), start, config.crop, mirrored))
        if conditional:
            conditions.append(_crop(encode_condition(condition_image), start, config.crop, mirrored))
    batch = torch.stack(clean)
    sigma = training_levels(config.batch, generator, mean=config.sigma_mean, std=config.sigma_std)
    noise = torch.randn(batch.shape, generator=generator)
    return batch, sigma, noise, torch.stack(conditions) if conditional else None


def _crop(image: np.ndarray, start: int, width: int, mirrored: bool) -> Tensor:
    """`width` columns of a ring [C, H, W] from column `start` on; `mirrored` left to right."""
    rest = max(start + width - image.shape[-1], 0)
    crop = np.concatenate([image[..., start : start + width], image[..., :rest]], axis=-1)
    return torch.from_numpy(np.ascontiguousarray(crop[..., ::-1] if mirrored else crop))


def _report(
    step: int, window: list[tuple[float, list[list[float]]]], batch: int, seconds: float, minutes: float
) -> Report:
    sigma, loss = np.array([sample for _, samples in window for sample in samples]).T
    bands: list[float | None] = []
    for low, high in itertools.pairwise(BANDS):
        inside = loss[(low <= sigma) & (sigma < high)]
        bands.append(float(inside.mean()) if len(inside) else None)
    return Report(
        step=step,
        loss=float(loss.mean()),
        bands=tuple(bands),
        gradient=float(np.mean([gradient for gradient, _ in window])),
        crops_per_second=len(window) * batch / seconds,
        minutes=minutes,
    )
