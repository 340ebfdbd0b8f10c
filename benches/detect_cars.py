"""What a detector of cars learns from simulated streets, from recorded scans and from both: AP on recordings.

    python benches/detect_cars.py [--streets N] [--steps N] [--seeds N] [--data FOLDER] [--work FOLDER]

The recordings are PandaSet's (CC BY 4.0), ten scans of one place and two of another: who learns from one is tested on
the other. The detector sees points from above and finds the centres of cars, as CenterPoint does (Yin et al., CVPR
2021). AP is nuScenes' (Caesar et al., CVPR 2020): the mean over matches within 0.5, 1, 2 and 4 m of a car's centre. The
APs of each training that is done are in results.json of the work folder, and a call goes on after them.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from evidence import RECIPES
from lidardraft.dataset.recipe import Recipe
from lidardraft.networks.layers import reduced_precision
from markdown_table import Row, table

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


def recorded(folder: Path) -> list[Scene]:
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


def trained(sets: Sequence[Sequence[Scene]], steps: int, seed: int) -> Detector:
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


def score(detector: Detector, scenes: Sequence[Scene]) -> float:
    """AP in percent, the mean over `MATCHES`."""
    found, truth = [found_cars(detector, scene) for scene in scenes], [scene.cars for scene in scenes]
    return 100 * float(np.mean([average_precision(found, truth, within) for within in MATCHES]))


def main() -> int:
    """Train, test and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--streets", type=int, default=400, help="simulated scans of the larger set (default 400)")
    parser.add_argument("--steps", type=int, default=500, help="steps of each training (default 500)")
    parser.add_argument("--seeds", type=int, default=2, help="trainings of each set (default 2)")
    parser.add_argument("--data", default=os.environ.get("LIDARDRAFT_DATA", ""), help="folder of recordings")
    parser.add_argument("--work", default="out/detect-cars", help="where results are kept (default out/detect-cars)")
    arguments = parser.parse_args()
    folder, work = Path(arguments.data, "permissive", "pandaset"), Path(arguments.work)
    places = {place: recorded(folder / place) for place in ("001", "002")}
    if not all(places.values()):
        print("no recordings: LIDARDRAFT_DATA does not name a folder with permissive/pandaset in it", file=sys.stderr)
        return 1
    work.mkdir(parents=True, exist_ok=True)
    streets, kept = simulated(arguments.streets, work), work / "results.json"
    cars = {place: sum(len(scene.cars) for scene in scenes) for place, scenes in places.items()}
    print(f"{cars} recorded cars, {sum(len(scene.cars) for scene in streets)} simulated", flush=True)
    torch.set_num_threads(1)
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
                detector = trained(scenes, arguments.steps, seed)
                results |= {key: score(detector, places[place]) for place, key in keys.items()}
                kept.write_text(json.dumps(results))
                minutes = (time.process_time() - start) / 60
                print(f"{name}, seed {seed}: {minutes:.1f} min", {p: results[k] for p, k in keys.items()}, flush=True)
    rows: dict[str, Row] = {name: {} for name in ("untrained", *sets)}
    for place, scenes in places.items():
        column = f"{len(scenes)} scans of {place}"
        rows["untrained"][column] = score(Detector().eval(), scenes)
        for name in sets:
            if place in tests[name]:
                APs = [results[f"{name} | {place} | {seed}"] for seed in range(arguments.seeds)]
                rows[name][column] = float(np.mean(APs))
    print(table(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
