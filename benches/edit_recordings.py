"""How near inserted cars come to recorded ones: each is removed from its scan, and one of its size is inserted there.

python benches/edit_recordings.py   (LIDARDRAFT_DATA names the folder of recordings)
"""

from __future__ import annotations

import os
import time
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lidardraft import Box, Sensor
from lidardraft.errors import LayoutError
from lidardraft.formats.kitti import read_bin
from lidardraft.formats.kitti_object import read_label_2
from lidardraft.formats.pandaset import LABELS
from lidardraft.formats.semantickitti import read_label
from lidardraft.simulation.recorded.object_sampling import ObjectSampling
from lidardraft.simulation.recorded.recorded_scan import INSERTED, RecordedScan
from lidardraft.simulation.recorded.scan_edits import Insert, Remove, edit_scan
from lidardraft.simulation.recorded.solid_object import SolidObject

_FEWEST = 50  # returns of a car that is compared
_MARGIN = 0.15  # m around a box
_BEHIND = 0.3  # m behind a surface: what returns from there is not hidden by it
_COUNTS = {"car": 15, "person": 10, "cyclist": 10}  # as OpenPCDet's configurations for KITTI sample them
_ROUNDS = 20


class Comparison(NamedTuple):
    """Of one car: returns recorded and inserted, their mean intensities, rays that it stops, and returns behind it."""

    returns: int
    inserted: int
    intensity: float
    inserted_intensity: float
    stopped: int
    left: int


def scans(folder: Path) -> Iterator[tuple[str, RecordedScan]]:
    """The recorded scans with boxes or labels, by data set."""
    kitti = folder / "kitti"
    for path in sorted((kitti / "object" / "training" / "velodyne").glob("*.bin")):
        points, intensity = read_bin(path)
        boxes = read_label_2(path.parents[1] / "label_2" / f"{path.stem}.txt")
        yield (
            "KITTI object",
            RecordedScan.from_points(points, Sensor.preset("hdl64e"), boxes=boxes, intensity=intensity),
        )
    for path in sorted((kitti / "odometry_00" / "labels").glob("*.label")):
        points, intensity = read_bin(kitti / "odometry_00" / "velodyne" / f"{path.stem}.bin")
        label, instance = read_label(path, len(points))
        fields = {"intensity": intensity, "label": label, "instance": instance}
        yield "SemanticKITTI", RecordedScan.from_points(points, Sensor.preset("hdl64e"), **fields)
    for path in sorted((folder / "permissive" / "pandaset").glob("*/*.npz")):
        yield "PandaSet", _pandaset(path)


def _pandaset(path: Path) -> RecordedScan:
    with np.load(path) as file:
        mine = file["device"] == 0
        boxes = [
            Box(f"car_{k}", "car", k, tuple(file["box_center"][k].tolist()), tuple(file["box_size_lwh"][k].tolist()),
                float(file["box_yaw"][k]))
            for k in np.flatnonzero(file["box_class"] == "Car").tolist()
        ]  # fmt: skip
        fields = {"intensity": file["intensity"][mine] / np.float32(255), "label": LABELS[file["label"][mine]]}
        return RecordedScan.from_points(file["xyz"][mine], Sensor.preset("pandar64"), boxes=boxes, **fields)


def compared(scan: RecordedScan, box: Box, seed: int) -> Comparison | None:
    """A car beside one of its size in its place; nothing where it has few returns."""
    mine = scan.returned & ~scan.is_ground & box.contains(scan.points, _MARGIN)
    if mine.sum() < _FEWEST:
        return None
    bare, id = edit_scan(scan, [Remove(box.id)], seed=seed), f"new_{seed}"  # which decides its paint
    try:
        edited = edit_scan(bare, [Insert("car", box.center[:2], box.yaw, box.size, id=id)], seed=seed)
    except LayoutError:  # clustered boxes may overlap
        return None
    new = edited.made_up == INSERTED
    solid, placed = SolidObject.of_kind("car", size=box.size, name=id, seed=seed), edited.box(id)
    x, y, z = placed.center
    old = np.flatnonzero(edited.returned & (edited.made_up != INSERTED))
    hits = solid.cast((x, y, z - placed.size[2] / 2), placed.yaw, edited.directions[old], 200.0, seed)
    solids = np.array([part.extinction is None for part in solid.caster.layout])  # rays may pass through windows
    left = hits.valid & (edited.distance[old] > hits.distance + _BEHIND) & solids[hits.primitive]
    before = np.flatnonzero(bare.returned)
    hidden = solid.cast((x, y, z - placed.size[2] / 2), placed.yaw, bare.directions[before], 200.0, seed)
    stopped = hidden.valid & (bare.distance[before] > hidden.distance + _BEHIND) & solids[hidden.primitive]
    return Comparison(
        int(mine.sum()), int(new.sum()), float(scan.intensity[mine].mean()), float(edited.intensity[new].mean()),
        int(stopped.sum()), int(left.sum()),
    )  # fmt: skip


def _samples(folder: Path) -> list[dict[str, np.ndarray]]:
    found = []
    for name, scan in scans(folder):
        if name == "KITTI object":
            there = scan.returned
            boxes = [(*box.center, *box.size, box.yaw) for box in scan.boxes]
            names = [
                {"car": "Car", "rider": "Cyclist", "person": "Pedestrian"}.get(b.label, "Misc") for b in scan.boxes
            ]
            points = np.column_stack([scan.points[there], scan.intensity[there]])
            found.append({"points": points, "gt_boxes": np.array(boxes, np.float32), "gt_names": np.array(names)})
    return found


def _augmented(folder: Path, seed: int) -> tuple[float, float]:
    samples, sampling = _samples(folder), ObjectSampling(_COUNTS, Sensor.preset("hdl64e"), seed=seed)
    begun, used = time.perf_counter(), time.process_time()
    for number in range(_ROUNDS):
        sampling(samples[number % len(samples)])
    return _ROUNDS / (time.perf_counter() - begun), _ROUNDS / (time.process_time() - used)


def main() -> None:
    """Print a line for each data set, and how many scans a second are augmented."""
    warnings.simplefilter("ignore")  # of things without a box around recorded cars
    folder = Path(os.environ["LIDARDRAFT_DATA"])
    found: dict[str, list[Comparison]] = {}
    for name, scan in scans(folder):
        cars = [box for box in scan.boxes if box.label == "car"]
        rows = [row for number, box in enumerate(cars) if (row := compared(scan, box, number)) is not None]
        found.setdefault(name, []).extend(rows)
    print("| | cars | returns, inserted over recorded: median (quartiles) | mean intensity, the same | "
          "rays newly stopped | returns left behind |\n|---|---:|---:|---:|---:|---:|")  # fmt: skip
    for name, rows in found.items():
        table = np.array(rows, float)
        ratio = table[:, 1] / table[:, 0]
        bright = table[:, 1] @ table[:, 3] / (table[:, 0] @ table[:, 2]) * table[:, 0].sum() / table[:, 1].sum()
        low, middle, high = np.quantile(ratio, (0.25, 0.5, 0.75))
        print(f"| {name} | {len(rows)} | {middle:.2f} ({low:.2f} to {high:.2f}) | {bright:.2f} | "
              f"{table[:, 4].sum():.0f} | {table[:, 5].sum():.0f} |")  # fmt: skip
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        rates = list(pool.map(_augmented, [folder] * 2, range(2)))
    print(f"\n{sum(_COUNTS.values())} objects a scan: {sum(wall for wall, _ in rates):.1f} scans/s in two processes; "
          f"{rates[0][1]:.1f} a second of processor time")  # fmt: skip


if __name__ == "__main__":
    main()
