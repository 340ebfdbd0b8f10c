"""What networks learn from made scans, from recorded ones and from both, tested on recordings that none has seen.

    python benches/evidence.py segmenter|detector [--scans N] [--more N] [--steps N] [--seeds N] [--data FOLDER]

The recorded sets are PandaSet's (CC BY 4.0), the others are of the same sensor, made by recipes; all are trained alike.

- segmenter: mIoU on SemanticKITTI's and nuScenes' images and ika's sweeps, of other sensors, places and annotators, in
  the classes that all of them tell apart.
- detector: it sees points from above and finds the centres of cars, as CenterPoint does (Yin et al., CVPR 2021).
  PandaSet has ten scans of one place and two of another: who learns from one is tested on the other. AP is nuScenes'
  (Caesar et al., CVPR 2020): the mean over matches within 0.5, 1, 2 and 4 m of a car's centre.

No weights are kept. What each training reached is in results.json of the work folder, and a call goes on after them.
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
from torch import nn
from torch.nn import functional

from lidardraft import RangeImage, Sensor
from lidardraft.dataset.recipe import Recipe
from lidardraft.metrics.sweep import Sweep
from lidardraft.networks import weight_file
from lidardraft.networks.layers import reduced_precision
from lidardraft.perception.segmenter import Segmenter, SegmenterConfig, SphericalGrid
from lidardraft.semantics import BY_NAME, NUM_CLASSES
from lidardraft.training.recorded_pairs import LabelledCloud, on_grid
from lidardraft.training.segmentation import SegmentationConfig, train_segmenter
from lidardraft.training.sources import MixedSource
from recordings import kitti_images, nuscenes_images, pandar64, vlp32c
from segment_streets import ClassScores, confusion_matrix
from tables import Row, table

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
REACH = 40.0  # m, of the view from above, to each side
PIXEL, CELL = 0.25, 0.5  # m, of what the network sees and of what it says
SLICES = np.arange(-0.25, 2.76, 0.5)  # m over the ground
CELLS = round(2 * REACH / CELL)
MATCHES = (0.5, 1.0, 2.0, 4.0)  # m
LEAST_POINTS = 5  # of a car that is learned and looked for
FAR = 38.0  # m, of a car
BATCH = 1  # scans of a step
ROAD = 7  # PandaSet's class
CPU = torch.device("cpu")


@dataclass(frozen=True)
class LabelledImage:
    """One scan, where a pair would stand."""

    scan: RangeImage


class LabelledImages:
    """Scans of one sensor, as a training draws them."""

    def __init__(self, source: str, images: Sequence[RangeImage]) -> None:
        self.source, self.path, self.images = source, Path(source), list(images)
        self.sensor = images[0].sensor
        self.sensors = (self.sensor,)
        self.checksum = zlib.crc32(b"".join(image.depth.tobytes() for image in images))

    def __len__(self) -> int:
        return len(self.images)

    def __getitem__(self, i: int) -> LabelledImage:
        return LabelledImage(self.images[i])


def recorded_images(data: Path, sensor: Sensor) -> list[RangeImage]:
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


def segmenter_score(segmenter: Segmenter, sweeps: Sequence[Sweep], mount_height: float) -> list[float]:
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


def trained_segmenter(images: LabelledImages, steps: int, seed: int, run: Path) -> tuple[Segmenter, float]:
    """A small segmenter of a set, and the minutes of one core that it took."""
    start = time.process_time()
    config = SegmentationConfig(segmenter=_SMALL, steps=steps, seed=seed, save_every=steps, warmup=steps // 10)
    for _ in train_segmenter(config, MixedSource((images,), (1.0,)), run):  # type: ignore[type-var, arg-type]
        pass
    return weight_file.load(run / "weights.safetensors", Segmenter), (time.process_time() - start) / 60


def sets(data: Path, count: int, more: int) -> dict[str, LabelledImages]:
    """The sets to train on: `count` scans each, and `more` of streets, which cost nothing."""
    sensor = dataclasses.replace(Sensor.preset("pandar64"), columns=_COLUMNS)
    real = recorded_images(data, sensor)[:count]
    made_ones = {name: made(recipe, count, 100, sensor) for name, recipe in RECIPES.items()}
    half = len(real) // 2
    mixed = real[::2] + made_ones["simulated streets"][: len(real) - half]
    found = {"recorded": real, **made_ones, "half recorded, half simulated streets": mixed}
    found[f"{more} simulated streets"] = made(RECIPES["simulated streets"], more, 200, sensor)
    return {name: LabelledImages(name, images) for name, images in found.items()}


def segmenter_table(results: dict[str, dict[str, list[list[float]]]]) -> str:
    """mIoU of each set on each recording, the mean of the seeds, and in the next column how far they are apart."""
    rows: dict[str, Row] = {}
    for name, tests in results.items():
        for test, runs in tests.items():
            means = [float(np.mean([iou for iou in run if iou >= 0])) for run in runs]
            rows.setdefault(name, {})[test] = float(np.mean(means))
            rows[name][f"{test}: seeds apart"] = max(means) - min(means)
    return table(rows)


def report_segmenters(data: Path, work: Path, arguments: argparse.Namespace) -> None:
    """Train and test segmenters, and print the table."""
    kept, results = work / "results.json", dict[str, dict[str, list[list[float]]]]()
    if kept.exists():
        results = json.loads(kept.read_text())
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
                    segmenter, minutes = trained_segmenter(train[name], arguments.steps, seed, Path(run))
            for test, (sweeps, mount_height) in tests.items():
                of_set[test].append(segmenter_score(segmenter, sweeps, mount_height))
            kept.write_text(json.dumps(results))
            print(f"{name}, seed {seed}: {minutes:.1f} min", {test: of_set[test][-1] for test in tests}, flush=True)
    print(segmenter_table(results))


@dataclass(frozen=True)
class Scene:
    """Points [N, 3], z over the ground, and the cars in reach [M, 5]: x, y, length, width [m] and yaw [rad]."""

    points: np.ndarray
    cars: np.ndarray

    def turned(self, angle: float, mirrored: bool, scale: float) -> Scene:
        """The scene turned about the sensor, and mirrored or scaled before."""
        flip = np.float32([1.0, -1.0 if mirrored else 1.0])
        cos, sin = np.cos(angle), np.sin(angle)
        turn = np.array([[cos, -sin], [sin, cos]], np.float32)
        points, cars = self.points * np.float32(scale), self.cars.copy()
        points[:, :2] = points[:, :2] * flip @ turn.T
        cars[:, :2] = cars[:, :2] * flip @ turn.T * scale
        cars[:, 2:4] *= scale
        cars[:, 4] = cars[:, 4] * flip[1] + angle
        return Scene(points, cars)


def recorded_scenes(folder: Path) -> list[Scene]:
    """PandaSet's scans of one place, what its Pandar64 saw; pick-ups are cars."""
    scenes = []
    for path in sorted(folder.glob("*.npz")):
        with np.load(path) as file:
            mine = file["device"] == 0
            points, label = file["xyz"][mine].astype(np.float32), file["label"][mine]
            is_car = np.isin(file["box_class"], ["Car", "Pickup Truck"])
            center, size, yaw = (file[name][is_car] for name in ("box_center", "box_size_lwh", "box_yaw"))
        cars = np.column_stack([center[:, :2], size[:, :2], yaw]).astype(np.float32)
        road = points[(label == ROAD) & (np.hypot(points[:, 0], points[:, 1]) < 20)]
        plane = np.linalg.lstsq(_with_one(road), road[:, 2], rcond=None)[0]  # the frame is tilted by 0.75 degrees
        points[:, 2] -= _with_one(points) @ plane
        seen = [np.count_nonzero(inside(points, car)) >= LEAST_POINTS for car in cars]
        scenes.append(Scene(points, in_reach(cars[np.array(seen)])))
    return scenes


def _with_one(points: np.ndarray) -> np.ndarray:
    return np.column_stack([points[:, :2], np.ones(len(points), np.float32)])


def inside(points: np.ndarray, car: np.ndarray) -> np.ndarray:
    """Which points stand on the car's footprint, more than 0.2 m over the ground."""
    x, y, length, width, yaw = car
    cos, sin = np.cos(yaw), np.sin(yaw)
    dx, dy = points[:, 0] - x, points[:, 1] - y
    along, across = dx * cos + dy * sin, dy * cos - dx * sin
    return (np.abs(along) < length / 2) & (np.abs(across) < width / 2) & (points[:, 2] > 0.2)


def in_reach(cars: np.ndarray) -> np.ndarray:
    """Those of which the centre is in reach [M, 5]."""
    return cars[np.hypot(cars[:, 0], cars[:, 1]) < FAR]


def simulated(count: int, work: Path) -> list[Scene]:
    """Scans of streets by the preset of the same sensor."""
    recipe = work / "streets.toml"
    recipe.write_text(f'scans = {count}\nseed = 1\n{RECIPES["simulated streets"]}\n[[sensor]]\nname = "pandar64"')
    loaded, scenes = Recipe.load(recipe), []
    for k in range(count):
        scan = loaded.scan(k)
        cars = [
            (*box.center[:2], *box.size[:2], box.yaw)
            for box, returns in zip(scan.boxes(), scan.returns_per_box(), strict=True)
            if box.label == "car" and returns >= LEAST_POINTS
        ]
        points = scan.points() + np.float32([0, 0, scan.image.sensor.mount_height])
        scenes.append(Scene(points, in_reach(np.array(cars, np.float32).reshape(-1, 5))))
    return scenes


def view_from_above(points: np.ndarray) -> np.ndarray:
    """How many points stand in each cell, by height and quarter of the cell: logarithms, f32 [24, CELLS, CELLS]."""
    at = np.floor((points[:, :2] + REACH) / PIXEL).astype(int)
    height = np.searchsorted(SLICES, points[:, 2]) - 1
    size, levels = 2 * CELLS, len(SLICES) - 1
    kept = ((at >= 0) & (at < size)).all(axis=1) & (height >= 0) & (height < levels)
    index = (height[kept] * size + at[kept, 1]) * size + at[kept, 0]
    counts = np.bincount(index, minlength=levels * size * size).astype(np.float32)
    quarters = np.log1p(counts).reshape(levels, CELLS, 2, CELLS, 2).transpose(0, 2, 4, 1, 3)
    return quarters.reshape(levels * 4, CELLS, CELLS)


def targets(cars: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Heat of centres [CELLS, CELLS], the cells of the centres [M, 2] (y, x), and what to say there [M, 6]."""
    place = (cars[:, :2] + REACH) / CELL
    cell = place.astype(int)
    heat, grid = np.zeros((CELLS, CELLS), np.float32), np.arange(CELLS) + 0.5
    for x, y in cell + 0.5:
        blob = np.exp(-((grid[:, None] - y) ** 2 + (grid - x) ** 2) / (2 * 1.5**2))
        heat = np.maximum(heat, blob.astype(np.float32))
    double = 2 * cars[:, 4]  # a car looks alike from both ends
    said = np.column_stack([place - cell - 0.5, np.log(cars[:, 2:4]), np.cos(double), np.sin(double)])
    return heat, cell[:, ::-1].copy(), said.astype(np.float32)


class Detector(nn.Module):
    """A U-Net from views [B, 24, CELLS, CELLS] to a logit of heat, offset, log size and twice the yaw [B, 7, ...]."""

    def __init__(self) -> None:
        super().__init__()
        widths = (32, 64, 96)
        before = (4 * (len(SLICES) - 1), *widths)
        self.down = nn.ModuleList(
            nn.Sequential(_layer(before[k], width, 1 if k == 0 else 2), _layer(width, width))
            for k, width in enumerate(widths)
        )
        self.up = nn.ModuleList(_layer(widths[k + 1] + widths[k], widths[k]) for k in (1, 0))
        self.head = nn.Conv2d(widths[0], 7, 1)
        with torch.no_grad():
            self.head.bias[0] = -4.0

    def forward(self, views: torch.Tensor) -> torch.Tensor:
        stages = [views]
        for layer in self.down:
            stages.append(layer(stages[-1]))
        *stages, found = stages[1:]
        for layer in self.up:
            wider = functional.interpolate(found, scale_factor=2.0, mode="nearest")
            found = layer(torch.cat([wider, stages.pop()], dim=1))
        said: torch.Tensor = self.head(found)
        return said


def _layer(width: int, to: int, stride: int = 1) -> nn.Sequential:
    return nn.Sequential(nn.Conv2d(width, to, 3, stride, 1, bias=False), nn.GroupNorm(to // 16, to), nn.SiLU())


def loss_of(said: torch.Tensor, cars: Sequence[np.ndarray]) -> torch.Tensor:
    """CenterNet's: a focal loss of the heat, and the absolute error of the rest at the centres, by car."""
    total, count = said.new_zeros(()), 0
    for one, truth in zip(said.float(), cars, strict=True):
        heat, cells, rest = (torch.from_numpy(array) for array in targets(truth))
        chance = one[0].sigmoid().clamp(1e-4, 1 - 1e-4)
        focal = torch.where(
            heat == 1.0, (1 - chance) ** 2 * chance.log(), (1 - heat) ** 4 * chance**2 * (1 - chance).log()
        )
        total = total - focal.sum() + (one[1:, cells[:, 0], cells[:, 1]].T - rest).abs().sum()
        count += len(cells)
    return total / max(count, 1)


def trained_detector(sets: Sequence[Sequence[Scene]], steps: int, seed: int) -> Detector:
    """A detector that draws its scans from each of the sets as often."""
    torch.manual_seed(seed)
    chance, detector = np.random.default_rng(seed), Detector()
    optimizer = torch.optim.AdamW(detector.parameters(), 2e-3, weight_decay=0.01)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, 2e-3, total_steps=steps)
    for _ in range(steps):
        drawn = []
        for _ in range(BATCH):
            scenes = sets[chance.integers(len(sets))]
            angle, scale = chance.uniform(0, 2 * np.pi), chance.uniform(0.95, 1.05)
            turned = scenes[chance.integers(len(scenes))].turned(angle, bool(chance.integers(2)), scale)
            drawn.append(Scene(turned.points, in_reach(turned.cars)))
        views = torch.from_numpy(np.stack([view_from_above(scene.points) for scene in drawn]))
        with reduced_precision(CPU):
            said = detector(views)
        optimizer.zero_grad()
        loss_of(said, [scene.cars for scene in drawn]).backward()
        nn.utils.clip_grad_norm_(detector.parameters(), 5.0)
        optimizer.step()
        schedule.step()
    return detector.eval()


@torch.no_grad()
def found_cars(detector: Detector, scene: Scene) -> np.ndarray:
    """Centres of cars and how sure they are [K, 3]: peaks of the heat, the surest first."""
    with reduced_precision(CPU):
        said = detector(torch.from_numpy(view_from_above(scene.points))[None]).float()[0]
    heat = said[0].sigmoid()
    peaks = torch.where(functional.max_pool2d(heat[None], 5, 1, 2)[0] == heat, heat, 0)
    score, index = peaks.flatten().topk(200)
    y, x = index // CELLS, index % CELLS
    offset = said[1:3].flatten(1)[:, index]
    centres = torch.stack([x + 0.5 + offset[0], y + 0.5 + offset[1]], dim=1) * CELL - REACH
    found = torch.column_stack([centres, score]).numpy()
    return found[np.hypot(found[:, 0], found[:, 1]) < FAR]


def average_precision(found: Sequence[np.ndarray], truth: Sequence[np.ndarray], within: float) -> float:
    """Of detections [K, 3] in each scene: the surest first, each takes the nearest car that is still free.

    Mean over 101 recalls of the best precision from there on.
    """
    ranked = sorted(((float(one[2]), k, one[:2]) for k, some in enumerate(found) for one in some), key=lambda r: -r[0])
    free = [np.ones(len(cars), bool) for cars in truth]
    hits = np.zeros(len(ranked), bool)
    for n, (_, k, at) in enumerate(ranked):
        away = np.where(free[k], np.hypot(*(truth[k][:, :2] - at).T), np.inf)
        if len(away) and away.min() < within:
            hits[n] = True
            free[k][away.argmin()] = False
    recall = np.cumsum(hits) / max(sum(map(len, truth)), 1)
    precision = np.cumsum(hits) / np.arange(1, len(hits) + 1)
    best = np.maximum.accumulate(precision[::-1])[::-1]
    return float(np.mean([best[recall >= r].max(initial=0.0) for r in np.linspace(0, 1, 101)]))


def detector_score(detector: Detector, scenes: Sequence[Scene]) -> float:
    """AP in percent, the mean over `MATCHES`."""
    found, truth = [found_cars(detector, scene) for scene in scenes], [scene.cars for scene in scenes]
    return 100 * float(np.mean([average_precision(found, truth, within) for within in MATCHES]))


def report_detectors(data: Path, work: Path, arguments: argparse.Namespace) -> None:
    """Train and test detectors, and print the table."""
    places = {place: recorded_scenes(data / "permissive/pandaset" / place) for place in ("001", "002")}
    streets, kept = simulated(arguments.more, work), work / "results.json"
    cars = {place: sum(len(scene.cars) for scene in scenes) for place, scenes in places.items()}
    print(f"{cars} recorded cars, {sum(len(scene.cars) for scene in streets)} simulated", flush=True)
    few, many = f"{len(places['002'])} simulated", f"{len(streets)} simulated"
    tests = {few: ("001", "002"), many: ("001", "002")}
    sets: dict[str, list[Sequence[Scene]]] = {few: [streets[: len(places["002"])]], many: [streets]}
    for place, other in (("001", "002"), ("002", "001")):
        sets[f"recorded: {place}"] = [places[place]]
        sets[f"recorded: {place}, and {many}"] = [places[place], streets]
        tests |= dict.fromkeys((f"recorded: {place}", f"recorded: {place}, and {many}"), (other,))
    results: dict[str, float] = json.loads(kept.read_text()) if kept.exists() else {}
    for seed in range(arguments.seeds):
        for name, scenes in sets.items():
            keys = {place: f"{name} | {place} | {seed}" for place in tests[name]}
            if not all(key in results for key in keys.values()):
                start = time.process_time()
                detector = trained_detector(scenes, arguments.steps, seed)
                results |= {key: detector_score(detector, places[place]) for place, key in keys.items()}
                kept.write_text(json.dumps(results))
                minutes = (time.process_time() - start) / 60
                print(f"{name}, seed {seed}: {minutes:.1f} min", {p: results[k] for p, k in keys.items()}, flush=True)
    rows: dict[str, Row] = {name: {} for name in ("untrained", *sets)}
    for place, scenes in places.items():
        column = f"{len(scenes)} scans of {place}"
        rows["untrained"][column] = detector_score(Detector().eval(), scenes)
        for name in sets:
            if place in tests[name]:
                APs = [results[f"{name} | {place} | {seed}"] for seed in range(arguments.seeds)]
                rows[name][column] = float(np.mean(APs))
    print(table(rows))


def main() -> int:
    """Train, test and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("network", choices=("segmenter", "detector"))
    parser.add_argument("--scans", type=int, default=12, help="of a set of a segmenter (default 12, all of PandaSet's)")
    parser.add_argument("--more", type=int, help="scans of the larger set of streets (default 60; detector 400)")
    parser.add_argument("--steps", type=int, help="steps of each training (default 100; detector 500)")
    parser.add_argument("--seeds", type=int, default=2, help="trainings of each set (default 2)")
    parser.add_argument("--data", default=os.environ.get("LIDARDRAFT_DATA", ""), help="folder of recordings")
    parser.add_argument("--work", help="where results are kept (default out/evidence/NETWORK)")
    arguments = parser.parse_args()
    kinds = {"segmenter": (report_segmenters, 60, 100), "detector": (report_detectors, 400, 500)}
    report, more, steps = kinds[arguments.network]
    arguments.more, arguments.steps = arguments.more or more, arguments.steps or steps
    data, work = Path(arguments.data), Path(arguments.work or f"out/evidence/{arguments.network}")
    if not (data / "permissive" / "pandaset").is_dir():
        print("no recordings: LIDARDRAFT_DATA does not name a folder with permissive/ in it", file=sys.stderr)
        return 1
    work.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(1)
    report(data, work, arguments)
    return 0


if __name__ == "__main__":
    sys.exit(main())
