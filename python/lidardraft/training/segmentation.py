"""Training the segmenter: labelled scans of pairs become weights on disk."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from lidardraft.errors import TrainingError
from lidardraft.networks.layers import reduced_precision
from lidardraft.perception.segmenter import Segmenter, SegmenterConfig, features
from lidardraft.semantics import NUM_CLASSES
from lidardraft.training.augmentation import Augmentation, augmented
from lidardraft.training.learner import LearningConfig
from lidardraft.training.loop import Measures, Report, device_for_training, train
from lidardraft.training.sources import MixedSource, PairFolder

_Batch = tuple[Tensor, Tensor]
_COUNTED = 256  # scans for the share of each class


@dataclass(frozen=True, kw_only=True)
class SegmentationConfig(LearningConfig):
    """All parameters that decide the result, except the pairs."""

    segmenter: SegmenterConfig = field(default_factory=SegmenterConfig)
    augmentation: Augmentation = field(default_factory=Augmentation)
    steps: int = 2_000
    batch: int = 2
    learning_rate: float = 0.02
    decay: float = 0.5
    weight_decay: float = 0.02
    save_every: int = 100


def train_segmenter(
    config: SegmentationConfig,
    pairs: MixedSource[PairFolder],
    run: str | os.PathLike[str],
    *,
    begin: Segmenter | None = None,
    device: str | None = "cpu",
    max_minutes: float = float("inf"),
) -> Iterator[Report]:
    """Train a segmenter, from fresh weights or those of `begin`, on the scans of pairs; the condition images are not
    used.

    `training.loop.train` describes the contents of the folder `run`, and how a run continues; the accuracy, the share
    of returns with the right label, is also reported. Raises `TrainingError` as that does, and if the pairs, the
    weights or the device do not fit.
    """
    config.check_counts()
    for folder in pairs.sources:
        if len(folder) == 0:
            raise TrainingError(f"{folder.path} holds no pairs")
    if begin is not None and begin.config != config.segmenter:
        raise TrainingError(f"the weights to begin with are of {begin.config}, not of {config.segmenter}")
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(config.seed)
        segmenter = begin or Segmenter(config.segmenter)
    on = device_for_training(device)
    weights = class_weights(pairs).to(on)

    def loss(_: int, batch: _Batch) -> tuple[Tensor, Measures]:
        x, target = (tensor.to(on) for tensor in batch)
        with reduced_precision(on):
            logits = segmenter(x)
        right = (logits.argmax(1) + 1 == target).float()
        losses = segmentation_loss(logits.float(), target, weights).expand(len(x))
        return losses, {"accuracy": right.where(target > 0, torch.nan)}

    batch = partial(_batch, pairs=pairs)
    yield from train(config, segmenter, batch, loss, pairs, run, device=on, max_minutes=max_minutes)


def class_weights(pairs: MixedSource[PairFolder]) -> Tensor:
    """The weight of an error in each class, f32 [K - 1], mean 1 over all returns: one over the root of its share.

    Classes rarer than one return in 10,000 count no more than that.
    """
    share = np.zeros(NUM_CLASSES - 1)
    for folder, weight in zip(pairs.sources, pairs.weights, strict=True):
        labels = [folder[i].scan.label for i in range(0, len(folder), max(len(folder) // _COUNTED, 1))]
        counts = np.bincount(np.concatenate(labels, axis=None), minlength=NUM_CLASSES)[1:]
        share += weight / sum(pairs.weights) * counts / max(counts.sum(), 1)
    weights = np.maximum(share, 1e-4) ** -0.5
    return torch.from_numpy((weights / (weights * share).sum()).astype(np.float32))


def segmentation_loss(logits: Tensor, target: Tensor, weights: Tensor) -> Tensor:
    """Weighted cross-entropy plus the soft Jaccard loss of Rahman and Wang (ISVC 2016), over the classes in the target.

    logits [B, K - 1, H, W]; target i64 [B, H, W] of class ids, 0 for pixels to be ignored.
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


def _batch(config: SegmentationConfig, step: int, *, pairs: MixedSource[PairFolder]) -> _Batch:
    """Features f32 [B, FEATURES, H, W] and class ids i64 [B, H, W] of a step."""
    random = np.random.default_rng((config.seed, step))
    grid, inputs, targets = config.segmenter.grid, [], []
    for _ in range(config.batch):
        folder = pairs.draw(random)
        scan = augmented(folder, int(random.integers(len(folder))), random, config.augmentation)
        index = grid.nearest(scan.points, grid.pixels(scan.points))
        inputs.append(features(scan.points, scan.intensity, folder.sensor.mount_height, index))
        targets.append(np.where(index >= 0, scan.label[index], 0))
    return torch.from_numpy(np.stack(inputs)), torch.from_numpy(np.stack(targets).astype(np.int64))
