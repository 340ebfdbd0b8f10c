"""What a segmenter learns from made scans, from recorded ones and from both: mIoU on recordings that none has seen.

    python benches/evidence.py [--scans N] [--steps N] [--seeds N] [--data FOLDER] [--work FOLDER]

The recorded set is PandaSet's labelled sweeps (CC BY 4.0); the others are as many scans of the same sensor, made by
recipes. All are trained alike. What is tested on are SemanticKITTI's and nuScenes' images and ika's sweeps, of other
sensors, places and annotators, in the classes that all of them tell apart. No weights are kept. The IoU of each
training that is done are in results.json of the work folder, and a call goes on after them.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import sys
import tempfile
import time
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from iou import ClassScores, confusion_matrix
from lidardraft import RangeImage, Sensor
from lidardraft.dataset.recipe import Recipe
from lidardraft.metrics.sweep import Sweep
from lidardraft.networks import weight_file
from lidardraft.perception.segmenter import Segmenter, SegmenterConfig, SphericalGrid
from lidardraft.semantics import BY_NAME, NUM_CLASSES
from lidardraft.training.recorded_pairs import LabelledCloud, on_grid
from lidardraft.training.segmentation import SegmentationConfig, train_segmenter
from lidardraft.training.sources import MixedSource
from markdown_table import Row, table
from recordings import kitti_images, nuscenes_images, pandar64, vlp32c

# Classes that all of the recordings tell apart.
GROUPS = {
    "road": ("road",),
    "sidewalk": ("sidewalk",),
    "building": ("building", "wall", "fence"),
    "green": ("vegetation", "trunk", "terrain"),
    "car": ("car",),
    "truck, bus": ("truck", "bus", "train"),
    "people, two-wheelers": ("person", "rider", "bicycle", "motorcycle"),
}
_SMALL = SegmenterConfig(grid=SphericalGrid(columns=512), widths=(16, 32, 64))
_COLUMNS = 900  # of the sensor, half of those of PandaSet's
_TABLE = np.zeros(NUM_CLASSES, dtype=np.uint8)
for _number, _names in enumerate(GROUPS.values(), 1):
    _TABLE[[BY_NAME[name].id for name in _names]] = _number

_SENTENCES = """
text = ["a busy crossroads with {n} pedestrians", "{n} cars ahead, parked cars on both sides, trees along the road",
  "a bus ahead, {n} cyclists on the right", "{n} trucks on a motorway", "a residential street with {n} parked cars"]
words.n = ["two", "three", "four", "five"]
"""
RECIPES = {
    "simulated streets": '[[scene]]\nstreet = ["residential", "urban", "avenue", "retail", "country", "motorway"]',
    "simulated sentences": f"[[scene]]{_SENTENCES}",
}


@dataclass(frozen=True)
class LabelledImage:
    """One scan, where a pair would stand."""

    scan: RangeImage


class LabelledImages:
    """Scans of one sensor, as a training draws them."""

    def __init__(self, source: str, images: Sequence[RangeImage]) -> None:
        self.source, self.path, self.images = source, Path(source), list(images)
        self.sensor = images[0].sensor
        self.checksum = zlib.crc32(b"".join(image.depth.tobytes() for image in images))

    def __len__(self) -> int:
        return len(self.images)

    def __getitem__(self, i: int) -> LabelledImage:
        return LabelledImage(self.images[i])


def recorded(data: Path, sensor: Sensor) -> list[RangeImage]:
    """PandaSet's sweeps on the grid of the sensor, those of both places in turn."""
    groups = pandar64(data, sensor.columns).labelled.values()
    images = []
    for sweep in [sweep for group in groups for sweep in group]:
        points, label, intensity = labelled_points(sweep)
        images.append(on_grid(LabelledCloud(points=points, intensity=intensity, label=label), sensor))
    return images


def labelled_points(sweep: Sweep) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points [N, 3], classes [N] and intensities [N] of the returns of a sweep."""
    there = np.linalg.norm(sweep.points, axis=2) > 0
    assert sweep.label is not None
    assert sweep.intensity is not None
    return sweep.points[there], sweep.label[there], sweep.intensity[there]


def made(recipe: str, count: int, seed: int, sensor: Sensor) -> list[RangeImage]:
    """Scans by a recipe."""
    with tempfile.TemporaryDirectory() as folder:
        sensor.save(Path(folder, "sensor.json"))
        path = Path(folder, "recipe.toml")
        path.write_text(f'scans = {count}\nseed = {seed}\n{recipe}\n[[sensor]]\nname = "sensor.json"')
        whole = Recipe.load(path)
    return [whole.scan(k).image for k in range(count)]


def score(segmenter: Segmenter, sweeps: Sequence[Sweep], mount_height: float) -> list[float]:
    """IoU of each of `GROUPS` that the sweeps have, in percent; -1 of others."""
    confusion = np.zeros((len(GROUPS) + 1,) * 2, dtype=np.int64)
    for sweep in sweeps:
        points, label, intensity = labelled_points(sweep)
        found = segmenter.label_points(points, intensity, mount_height)
        confusion += confusion_matrix(_TABLE[label], _TABLE[found], len(GROUPS) + 1)
    scores = ClassScores.from_confusion(confusion)
    return [
        round(100 * float(np.nan_to_num(iou)), 1) if truth else -1.0
        for iou, truth in zip(scores.iou[1:], scores.truth[1:], strict=True)
    ]


def test_sets(data: Path) -> dict[str, tuple[list[Sweep], float]]:
    """The recordings to test on, with the height of their sensor."""
    ika = [sweep for group in vlp32c(data, 0).labelled.values() for sweep in group]
    return {
        "SemanticKITTI": (kitti_images(data), 1.73),
        "nuScenes": (nuscenes_images(data), 1.84),
        "ika": (ika, Sensor.preset("vlp32c").mount_height),
    }


def trained(images: LabelledImages, steps: int, seed: int, run: Path) -> tuple[Segmenter, float]:
    """A small segmenter of a set, and the minutes of one core that it took."""
    start = time.process_time()
    config = SegmentationConfig(segmenter=_SMALL, steps=steps, seed=seed, save_every=steps, warmup=steps // 10)
    for _ in train_segmenter(config, MixedSource((images,), (1.0,)), run):  # type: ignore[type-var, arg-type]
        pass
    return weight_file.load(run / "weights.safetensors", Segmenter), (time.process_time() - start) / 60


def sets(data: Path, count: int, more: int) -> dict[str, LabelledImages]:
    """The sets to train on: `count` scans each, and `more` of streets, which cost nothing."""
    sensor = dataclasses.replace(Sensor.preset("pandar64"), columns=_COLUMNS)
    real = recorded(data, sensor)[:count]
    made_ones = {name: made(recipe, count, 100, sensor) for name, recipe in RECIPES.items()}
    half = len(real) // 2
    mixed = real[::2] + made_ones["simulated streets"][: len(real) - half]
    found = {"recorded": real, **made_ones, "half recorded, half simulated streets": mixed}
    found[f"{more} simulated streets"] = made(RECIPES["simulated streets"], more, 200, sensor)
    return {name: LabelledImages(name, images) for name, images in found.items()}


def as_table(results: dict[str, dict[str, list[list[float]]]]) -> str:
    """mIoU of each set on each recording, the mean of the seeds, and in the next column how far they are apart."""
    rows: dict[str, Row] = {}
    for name, tests in results.items():
        for test, runs in tests.items():
            means = [float(np.mean([iou for iou in run if iou >= 0])) for run in runs]
            rows.setdefault(name, {})[test] = float(np.mean(means))
            rows[name][f"{test}: seeds apart"] = max(means) - min(means)
    return table(rows)


def main() -> int:
    """Train, test and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--scans", type=int, default=12, help="scans of each set (default 12, all of PandaSet's)")
    parser.add_argument("--more", type=int, default=60, help="scans of the larger set of streets (default 60)")
    parser.add_argument("--steps", type=int, default=100, help="steps of each training (default 100)")
    parser.add_argument("--seeds", type=int, default=2, help="trainings of each set (default 2)")
    parser.add_argument("--data", default=os.environ.get("LIDARDRAFT_DATA", ""), help="folder of recordings")
    parser.add_argument("--work", default="out/evidence", help="where results are kept (default out/evidence)")
    arguments = parser.parse_args()
    data, work = Path(arguments.data), Path(arguments.work)
    if not (data / "permissive" / "pandaset").is_dir():
        print("no recordings: LIDARDRAFT_DATA does not name a folder with permissive/ in it", file=sys.stderr)
        return 1
    work.mkdir(parents=True, exist_ok=True)
    kept, results = work / "results.json", dict[str, dict[str, list[list[float]]]]()
    if kept.exists():
        results = json.loads(kept.read_text())
    torch.set_num_threads(1)
    tests = test_sets(data)
    train = sets(data, arguments.scans, arguments.more)
    for seed in range(arguments.seeds):
        for name in ("untrained", *train):
            of_set = results.setdefault(name, {test: [] for test in tests})
            if len(next(iter(of_set.values()))) > seed:
                continue
            torch.manual_seed(seed)
            segmenter, minutes = Segmenter(_SMALL).eval(), 0.0
            if name in train:
                with tempfile.TemporaryDirectory() as run:
                    segmenter, minutes = trained(train[name], arguments.steps, seed, Path(run))
            for test, (sweeps, mount_height) in tests.items():
                of_set[test].append(score(segmenter, sweeps, mount_height))
            kept.write_text(json.dumps(results))
            print(f"{name}, seed {seed}: {minutes:.1f} min", {test: of_set[test][-1] for test in tests}, flush=True)
    print(as_table(results))
    return 0


if __name__ == "__main__":
    sys.exit(main())
