import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest
import torch

from lidardraft.networks import weight_file
from lidardraft.perception.segmenter import Segmenter, SegmenterConfig, SphericalGrid
from lidardraft.semantics import BY_NAME, NUM_CLASSES
from lidardraft.training.augmentation import Augmentation
from lidardraft.training.segmentation import (
    SegmentationConfig,
    class_weights,
    segmentation_loss,
    train_segmenter,
)
from lidardraft.training.sources import MixedSource, PairFolder

ROAD, BUILDING = (BY_NAME[name].id for name in ("road", "building"))
STILL = Augmentation(
    **{field.name: 0.0 for field in dataclasses.fields(Augmentation)}
)  # rotated and mirrored all the same
TINY = SegmentationConfig(
    segmenter=SegmenterConfig(grid=SphericalGrid(rows=16, columns=128), widths=(8, 16)),
    steps=6,
    learning_rate=0.05,
    warmup=2,
    report_every=2,
    save_every=100,
)


def test_a_tiny_network_learns_a_few_scans(pairs: PairFolder, tmp_path: Path) -> None:
    config = dataclasses.replace(TINY, steps=40, augmentation=STILL, report_every=10)
    reports = list(train_segmenter(config, MixedSource((pairs,), (1.0,)), tmp_path))
    assert [report.step for report in reports] == [10, 20, 30, 40]
    assert reports[-1].loss < 0.3 * reports[0].loss
    log = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]
    assert log == [dataclasses.asdict(report) for report in reports]
    segmenter = weight_file.load(tmp_path / "weights.safetensors", Segmenter)
    for i in range(len(pairs)):
        scan = pairs[i].scan
        right = (segmenter.label(scan) == scan.label)[scan.valid]
        assert right.mean() > 0.95


def test_the_loss_by_hand() -> None:
    weights = torch.ones(NUM_CLASSES - 1)
    target = torch.tensor([[[0, 1, 2, 2]]])
    sure = torch.full((1, NUM_CLASSES - 1, 1, 4), -30.0)
    sure[0, [5, 0, 1, 1], 0, [0, 1, 2, 3]] = 30.0
    assert segmentation_loss(sure, target, weights).item() == pytest.approx(0, abs=1e-5)
    # one in K - 1 for every class: entropy ln(20); Jaccard (p n) / (3 p + n - p n) of n = 1 and 2 returns, p = 1 / 20
    p = 1 / (NUM_CLASSES - 1)
    jaccard = (p / (3 * p + 1 - p) + 2 * p / (3 * p + 2 - 2 * p)) / 2
    even = segmentation_loss(torch.zeros_like(sure), target, weights).item()
    assert even == pytest.approx(math.log(NUM_CLASSES - 1) + 1 - jaccard, rel=1e-5)


def test_rare_classes_count_more(pairs: PairFolder) -> None:
    weights = class_weights(MixedSource((pairs,), (1.0,)))
    labels = np.concatenate([pairs[i].scan.label for i in range(len(pairs))], axis=None)
    counts = np.bincount(labels, minlength=NUM_CLASSES)[1:]
    ratio = weights[BUILDING - 1] / weights[ROAD - 1]
    assert ratio == pytest.approx(math.sqrt(counts[ROAD - 1] / counts[BUILDING - 1]), rel=1e-5)
    assert (weights.numpy() * counts).sum() / counts.sum() == pytest.approx(1, rel=1e-5)
