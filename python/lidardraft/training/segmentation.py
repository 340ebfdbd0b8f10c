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
from safetensors import SafetensorError, safe_open
from safetensors.torch import save as serialise
from torch import Tensor
from torch.nn import functional

from lidardraft.errors import TrainingError
from lidardraft.files import written_whole
from lidardraft.perception.grid import features
from lidardraft.perception.segmenter import Segmenter, SegmenterConfig
from lidardraft.semantics import NUM_CLASSES
from lidardraft.training.augmentation import Augmentation, augmented
from lidardraft.training.pairs import PairFolder

_COUNTED = 256  # scans that the share of each class is taken from


@dataclass(frozen=True, kw_only=True)
class SegmentationConfig:
    """All that decides the result, beside the pairs.

    The learning rate rises over `warmup` steps, stays, and falls to 0 over the last `decay` of the steps. `ema` is the
    decay of the average of weights that is saved.
    """

    segmenter: SegmenterConfig = field(default_factory=SegmenterConfig)
    augmentation: Augmentation = field(default_factory=Augmentation)
    steps: int = 2_000
    batch: int = 2
    learning_rate: float = 2e-3
    warmup: int = 100
    decay: float = 0.5
    weight_decay: float = 0.02
    max_gradient: float = 1.0
    ema: float = 0.99
    seed: int = 0
    save_every: int = 100
    report_every: int = 20

    def rate(self, step: int) -> float:
        """The learning rate of a step."""
        rise = (step + 1) / max(self.warmup, 1)
        fall = (self.steps - step) / max(self.decay * self.steps, 1)
        return self.learning_rate * min(1.0, rise, fall)


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
    start = trainer.resume(run / "state.safetensors")
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
    """Weights, their average and the optimiser: what a step changes and a run keeps."""

    def __init__(self, config: SegmentationConfig, weights: Tensor, device: torch.device) -> None:
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(config.seed)
            segmenter = Segmenter(config.segmenter)
        self.config, self.device = config, device
        self.segmenter = segmenter.to(device).train()
        self.class_weights = weights.to(device)
        self.weights = dict(self.segmenter.named_parameters())
        self.average = {name: p.detach().clone() for name, p in self.weights.items()}
        self.identity = json.dumps({**dataclasses.asdict(config), **dict.fromkeys(_FREE)})
        self.optimiser = torch.optim.AdamW(
            self.weights.values(), lr=config.learning_rate, betas=(0.9, 0.99), weight_decay=config.weight_decay
        )

    def step(self, step: int, x: Tensor, target: Tensor) -> tuple[float, float, float]:
        """One gradient step; the loss, the share of labels that were right, and the norm of the gradient."""
        for group in self.optimiser.param_groups:
            group["lr"] = self.config.rate(step)
        x, target = x.to(self.device), target.to(self.device)
        with torch.autocast(self.device.type, dtype=torch.bfloat16, enabled=self.device.type == "cuda"):
            logits = self.segmenter(x)
        loss = segmentation_loss(logits.float(), target, self.class_weights)
        self.optimiser.zero_grad(set_to_none=True)
        loss.backward()  # type: ignore[no-untyped-call]
        gradient = torch.nn.utils.clip_grad_norm_(self.weights.values(), self.config.max_gradient)
        self.optimiser.step()
        # A young average is short, so that it forgets its random start.
        decay = min(self.config.ema, (1 + step) / (10 + step))
        torch._foreach_lerp_(list(self.average.values()), [p.detach() for p in self.weights.values()], 1 - decay)
        right = (logits.argmax(1) + 1 == target)[target > 0].float().mean()
        return loss.item(), right.item(), gradient.item()

    def save(self, run: Path, step: int, source: str) -> None:
        """Write the state, then the averaged weights."""
        tensors = {f"weight.{name}": p.detach() for name, p in self.weights.items()}
        tensors |= {f"average.{name}": p for name, p in self.average.items()}
        for name, p in self.weights.items():
            tensors |= {f"{key}.{name}": value for key, value in self.optimiser.state[p].items()}
        metadata = {"step": str(step), "run": self.identity}
        with written_whole(run / "state.safetensors") as temporary:
            temporary.write_bytes(serialise({name: t.cpu().contiguous() for name, t in tensors.items()}, metadata))
        averaged = Segmenter(self.config.segmenter)
        averaged.load_state_dict(self.average)
        card = {"training": dataclasses.asdict(self.config), "step": step, "data": source}
        averaged.save(run / "weights.safetensors", card)

    def resume(self, path: Path) -> int:
        """Take over the state of an earlier slice of the same run, if there is one; the step to go on from."""
        if not path.exists():
            return 0
        try:
            with safe_open(path, framework="pt") as file:
                metadata, tensors = file.metadata(), {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
            identity, step = metadata["run"], int(metadata["step"])
        except (SafetensorError, OSError, KeyError, TypeError, ValueError) as error:
            raise TrainingError(f"{path} is no state of a run: {error}") from None
        if identity != self.identity:
            raise TrainingError(f"{path} is the state of a run with another config; use another folder")
        with torch.no_grad():
            for name, p in self.weights.items():
                p.copy_(tensors[f"weight.{name}"])
                self.average[name].copy_(tensors[f"average.{name}"])
                self.optimiser.state[p] = {
                    "step": tensors[f"step.{name}"],
                    **{key: tensors[f"{key}.{name}"].to(p.device) for key in ("exp_avg", "exp_avg_sq")},
                }
        return step


# What may differ between the slices of one run: how long it is, and how it reports.
_FREE = ("steps", "save_every", "report_every")


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
