"""Training the segmenter: labelled scans of pairs become weights on disk."""

from __future__ import annotations

import os
from collections.abc import Generator, Iterator
from dataclasses import dataclass, field
from functools import partial

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from lidardraft.errors import TrainingError
from lidardraft.perception.segmenter import Segmenter, SegmenterConfig, features
from lidardraft.semantics import NUM_CLASSES
from lidardraft.training.augmentation import Augmentation, augmented
from lidardraft.training.learner import LearningConfig
from lidardraft.training.loop import Batch, Measures, Report, device_for_training, prefetched, train
from lidardraft.training.pairs import PairFolder

_COUNTED = 256  # scans that the share of each class is taken from


@dataclass(frozen=True, kw_only=True)
class SegmentationConfig(LearningConfig):
    """All that decides the result, beside the pairs."""

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
    pairs: PairFolder,
    run: str | os.PathLike[str],
    *,
    device: str = "cpu",
    max_minutes: float = float("inf"),
) -> Iterator[Report]:
    """Train a segmenter on the scans of pairs; the condition images are not looked at.

    What the folder `run` receives, and how a run goes on, is said at `training.loop.train`; the accuracy, the share of
    returns that are labelled right, is also reported. Raises `TrainingError` as that does, and where the pairs or the
    device cannot be.
    """
    config.check_counts()
    if len(pairs) == 0:
        raise TrainingError("the folder holds no pairs")
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(config.seed)
        segmenter = Segmenter(config.segmenter)
    on = device_for_training(device)
    weights = class_weights(pairs).to(on)

    def batches(start: int) -> Generator[Batch, None, None]:
        return prefetched(partial(_batch, config, pairs), start)

    def loss(_: int, batch: Batch) -> tuple[Tensor, Measures]:
        x, target = batch
        # On a CPU its gradients were infinite in bfloat16 after eleven steps.
        with torch.autocast(on.type, dtype=torch.bfloat16, enabled=on.type == "cuda"):
            logits = segmenter(x)
        right = (logits.argmax(1) + 1 == target)[target > 0]
        losses = segmentation_loss(logits.float(), target, weights).expand(len(x))
        return losses, {"accuracy": right.float()}

    yield from train(config, segmenter, batches, loss, pairs, run, device=on, max_minutes=max_minutes)


def class_weights(pairs: PairFolder) -> Tensor:
    """What an error in each class counts, f32 [K - 1], mean 1 over all returns: one over the root of its share.

    Rarer classes than one return in 10,000 count no more than those.
    """
    step = max(len(pairs) // _COUNTED, 1)
    labels = [pairs[i].scan.label for i in range(0, len(pairs), step)]
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


def _batch(config: SegmentationConfig, pairs: PairFolder, step: int) -> Batch:
    """Features f32 [B, FEATURES, H, W] and class ids i64 [B, H, W] of a step."""
    random = np.random.default_rng((config.seed, step))
    grid, inputs, targets = config.segmenter.grid, [], []
    for i in random.integers(len(pairs), size=config.batch):
        scan = augmented(pairs, int(i), random, config.augmentation)
        index = grid.nearest(scan.points, grid.pixels(scan.points))
        inputs.append(features(scan.points, scan.intensity, pairs.sensor.mount_height, index))
        targets.append(np.where(index >= 0, scan.label[index], 0))
    return torch.from_numpy(np.stack(inputs)), torch.from_numpy(np.stack(targets).astype(np.int64))
