"""The training loop of the segmenter: labelled scans of streets become weights on disk."""

from __future__ import annotations

import dataclasses
import json
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from lidardraft.errors import TrainingError
from lidardraft.perception.grid import features
from lidardraft.perception.segmenter import Segmenter, SegmenterConfig
from lidardraft.semantics import NUM_CLASSES
from lidardraft.training.augmentation import Augmentation, augmented
from lidardraft.training.learner import Learner, LearningConfig
from lidardraft.training.pairs import PairFolder

_COUNTED = 256  # scans that the share of each class is taken from


@dataclass(frozen=True, kw_only=True)
class SegmentationConfig(LearningConfig):
    """All that decides the result, beside the pairs."""

    segmenter: SegmenterConfig = field(default_factory=SegmenterConfig)
    augmentation: Augmentation = field(default_factory=Augmentation)
    steps: int = 2_000
    batch: int = 2
    learning_rate: float = 2e-3
    decay: float = 0.5
    weight_decay: float = 0.02
    ema: float = 0.99
    save_every: int = 100


@dataclass(frozen=True)
class SegmentationReport:
    """Means since the last report: the loss, the share of returns that are labelled right, the gradient's norm."""

    step: int
    loss: float
    accuracy: float
    gradient: float
    scans_per_second: float
    minutes: float


def train_segmenter(
    config: SegmentationConfig,
    pairs: PairFolder,
    run: str | os.PathLike[str],
    *,
    device: str = "cpu",
    max_minutes: float = float("inf"),
) -> Iterator[SegmentationReport]:
    """Train a segmenter on the scans of pairs; the drawings are not looked at.

    The folder `run` receives `log.jsonl`, `state.safetensors` to go on from after an interruption or `max_minutes`, and
    `weights.safetensors`, the average of weights. Batch t depends on the seed, the pairs and t only, so that a run in
    slices gives the weights of a run in one. Raises `TrainingError` where the run in the folder is another, the config
    or the device cannot be, or the training has gone wrong.
    """
    _check(config, pairs)
    run = Path(run)
    try:
        trainer = _Trainer(config, class_weights(pairs), torch.device(device))
    except (RuntimeError, AssertionError) as error:  # torch's, for a device it does not have
        raise TrainingError(f"device is {device!r}: {str(error).splitlines()[0]}") from None
    start = trainer.learner.resume(run / "state.safetensors")
    run.mkdir(parents=True, exist_ok=True)
    began, reported = time.monotonic(), time.monotonic()
    window: list[tuple[float, float, float]] = []
    for step in range(start, config.steps):
        window.append(trainer.step(step, *_batch(config, pairs, step)))
        minutes = (time.monotonic() - began) / 60
        last = step + 1 == config.steps or minutes > max_minutes
        report = None
        if last or (step + 1) % config.report_every == 0:
            rate = len(window) * config.batch / (time.monotonic() - reported)
            loss, accuracy, gradient = np.mean(window, axis=0).tolist()
            report = SegmentationReport(step + 1, loss, accuracy, gradient, rate, minutes)
            with (run / "log.jsonl").open("a") as log:
                log.write(json.dumps(dataclasses.asdict(report)) + "\n")
            if not np.isfinite(report.loss):
                raise TrainingError(f"the loss is {report.loss} at step {step + 1}")
            window, reported = [], time.monotonic()
        if last or (step + 1) % config.save_every == 0:
            trainer.save(run, step + 1, pairs.source)
        if report:
            yield report
        if last:
            return


def class_weights(pairs: PairFolder) -> Tensor:
    """What an error in each class counts, f32 [K - 1], mean 1 over all returns: one over the root of its share.

    Rarer classes than one return in 10,000 count no more than those.
    """
    step = max(len(pairs) // _COUNTED, 1)
    labels = [pairs[i][0].label for i in range(0, len(pairs), step)]
    counts = np.bincount(np.concatenate(labels, axis=None), minlength=NUM_CLASSES)[1:]
    share = counts / max(counts.sum(), 1)
    weights = np.maximum(share, 1e-4) ** -0.5
    return torch.from_numpy((weights / (weights * share).sum()).astype(np.float32))


def segmentation_loss(logits: Tensor, target: Tensor, weights: Tensor) -> Tensor:
    """Weighted cross-entropy plus the soft Jaccard loss of Rahman and Wang (ISVC 2016), over the classes there are.

    logits [B, K - 1, H, W]; target i64 [B, H, W] of class ids, 0 where nothing is to be learned.
    """
    known = target > 0
    logits, target = logits.permute(0, 2, 3, 1)[known], target[known] - 1
    if len(target) == 0:
        return logits.sum()
    entropy = functional.cross_entropy(logits, target, weights)
    share = logits.softmax(dim=1)
    truth = functional.one_hot(target, len(weights)).to(share.dtype)
    both, size = (share * truth).sum(0), truth.sum(0)
    jaccard = both / (share.sum(0) + size - both)
    return entropy + 1 - jaccard[size > 0].mean()


class _Trainer:
    """A segmenter that learns."""

    def __init__(self, config: SegmentationConfig, weights: Tensor, device: torch.device) -> None:
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(config.seed)
            segmenter = Segmenter(config.segmenter)
        self.config, self.device = config, device
        self.segmenter = segmenter.to(device).train()
        self.class_weights = weights.to(device)
        self.learner = Learner(self.segmenter, config, config.of_any_length())

    def step(self, step: int, x: Tensor, target: Tensor) -> tuple[float, float, float]:
        """One gradient step; the loss, the share of labels that were right, and the norm of the gradient."""
        x, target = x.to(self.device), target.to(self.device)
        with torch.autocast(self.device.type, dtype=torch.bfloat16, enabled=self.device.type == "cuda"):
            logits = self.segmenter(x)
        loss = segmentation_loss(logits.float(), target, self.class_weights)
        gradient = self.learner.step(step, loss)
        right = (logits.argmax(1) + 1 == target)[target > 0].float().mean()
        return loss.item(), right.item(), gradient

    def save(self, run: Path, step: int, source: str) -> None:
        """Write the state, then the averaged weights."""
        self.learner.save(run / "state.safetensors", step)
        with self.learner.averaged():
            card = {"training": dataclasses.asdict(self.config), "step": step, "data": source}
            self.segmenter.save(run / "weights.safetensors", card)


def _check(config: SegmentationConfig, pairs: PairFolder) -> None:
    for name in ("steps", "batch", "save_every", "report_every"):
        if getattr(config, name) < 1:
            raise TrainingError(f"{name} is {getattr(config, name)}; it must be at least 1")
    if len(pairs) == 0:
        raise TrainingError("the folder holds no pairs")


def _batch(config: SegmentationConfig, pairs: PairFolder, step: int) -> tuple[Tensor, Tensor]:
    """Features f32 [B, FEATURES, H, W] and class ids i64 [B, H, W] of a step."""
    random = np.random.default_rng((config.seed, step))
    grid, inputs, targets = config.segmenter.grid, [], []
    for i in random.integers(len(pairs), size=config.batch):
        scan = augmented(pairs, int(i), random, config.augmentation)
        index = grid.nearest(scan.points, grid.pixels(scan.points))
        inputs.append(features(scan.points, scan.intensity, pairs.sensor.mount_height, index))
        targets.append(np.where(index >= 0, scan.label[index], 0))
    return torch.from_numpy(np.stack(inputs)), torch.from_numpy(np.stack(targets).astype(np.int64))
