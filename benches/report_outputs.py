"""What comes out: sequences, edited recordings, data sets made by several processes. A part of `make report-outputs`.

    python benches/report_outputs.py [sequences|edits|workers ...] [--data FOLDER] [--frames 100] [--rounds 3]

- Frames a second of 64 x 2048 rays of a crossroads with traffic, with the threads that there are.
- Rolling shutter: casts of frames beside casts in which every body stands where it is when the column fires, one scene
  a column; the largest difference of ranges, and the share of returns from other objects.
- Flicker: of frames a tenth of a second or three apart, brought into one frame, the returns of standing objects within
  30 m: the median distance of a return from the plane through the eight nearest of the other frame, and the median
  difference of the mean intensities of cells of 0.5 m that hold eight returns of both, over the mean of all.
  Independent samples are frames of one layout, each with details and brightness of a seed of its own. Recordings are
  KITTI's drive 0005 (CC BY-NC-SA, Geiger et al., IJRR 2013), three frames apart, where poses are those of KISS-ICP and
  what moves is not known.
- Odometry: KISS-ICP (Vizzo et al., RA-L 2023, `pip install kiss-icp`) on the points as the sensor gives them, against
  the true poses: the largest distance of the two over the length of the path. The first ten frames, in which it
  learns that it moves, are left out.
- Edits: how near inserted cars come to recorded ones: each is removed from its scan, and one of its size is inserted
  there; and how many scans a second are augmented with sampled objects.
- Workers: in turns `lidardraft dataset` with one process, with `--jobs 2`, and two calls at once that share nothing,
  each with half of the shards: more than theirs no two workers can do on the machine as it is then. The medians of all
  rounds, in scans a second, and the processor time that each scan took.
"""

from __future__ import annotations

import argparse
import dataclasses
import itertools
import os
import resource
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from lidardraft import Box, Raycaster, Scan, Sensor, StreetConfig, street_drive
from lidardraft.errors import LayoutError
from lidardraft.formats.kitti import read_bin
from lidardraft.formats.kitti_object import read_label_2
from lidardraft.formats.pandaset import LABELS
from lidardraft.formats.pcd import parse_pcd
from lidardraft.formats.semantickitti import read_label
from lidardraft.scene.effects import sub_rays
from lidardraft.scene.pose import upright
from lidardraft.scene.scenario import AlongLane, Scenario
from lidardraft.simulation.motion.sequence import SequenceSimulator
from lidardraft.simulation.recorded.object_sampling import ObjectSampling
from lidardraft.simulation.recorded.recorded_scan import INSERTED, RecordedScan
from lidardraft.simulation.recorded.scan_edits import Insert, Remove, edit_scan
from lidardraft.simulation.recorded.solid_object import SolidObject
from lidardraft.streets.drives import HALF_LENGTH
from recordings import file_bytes

CROSSROADS = "a busy downtown crossroads with a bus, cyclists and pedestrians, trees along the road"
STREET = "a street with parked cars on both sides, trees, houses, people on the sidewalk and a car ahead"
BEND = "a street that bends to the left with parked cars, trees and houses"
SENSOR = dataclasses.replace(Sensor.preset("hdl64e"), columns=2048)
WITHIN, FAR, PATCH = 0.5, 30.0, 0.5  # m: of neighbours, of returns from the sensor, and of the cells of patches
WARM = 10  # frames
AROUND, SAMPLED = 8, 20_000  # neighbours that make a surface, or returns a patch; returns that are looked at
_FEWEST = 50  # returns of a car that is compared
_MARGIN = 0.15  # m around a box
_BEHIND = 0.3  # m behind a surface: what returns from there is not hidden by it
_COUNTS = {"car": 15, "person": 10, "cyclist": 10}  # as OpenPCDet's configurations for KITTI sample them
_ROUNDS = 20
RECIPE = """
scans = 1
seed = 1
shard_size = 8
[[scene]]
text = ["{count} cars ahead, a bus on the left", "a busy crossroads with {count} pedestrians"]
words.count = { from = 2, to = 6 }
[[scene]]
street = ["urban", "residential", "avenue"]
"""
WAYS = {
    "one process": [["--jobs", "1"]],
    "--jobs 2": [["--jobs", "2"]],
    "two calls": [["--jobs", "1", "--shard", "0/2"], ["--jobs", "1", "--shard", "1/2"]],
}


def frames_a_second(frames: int) -> None:
    """Of the crossroads."""
    simulator = SequenceSimulator(CROSSROADS, SENSOR, frames=frames)
    simulator.frame(0)
    begun, used = time.perf_counter(), time.process_time()
    for number in range(frames):
        simulator.frame(number)
    rate, of_cores = frames / (time.perf_counter() - begun), frames / (time.process_time() - used)
    said = f"frames a second, 64 x 2048, {len(simulator.tracks.actors)} bodies move: {rate:.1f}"
    print(f"{said}; {of_cores:.1f} a second of processor time")


def shutter(columns: int = 64) -> None:
    """Of the crossroads, whose bodies are moved for each column."""
    simulator = SequenceSimulator(CROSSROADS, SENSOR, frames=60, detail=False)
    rays, worst, others = sub_rays(SENSOR, SENSOR.assumed_model), list[float](), list[float]()
    for number in (5, 55):
        cast, at = simulator.cast(number), simulator.time(number)
        rate, pose = simulator.tracks.ego.rate(at, SENSOR.sweep_time), simulator.pose(number)
        poses = SENSOR.poses_in_motion(pose, (rate[:3] @ pose[:3, 0]) * pose[:3, 0], (0, 0, rate[3]))
        for column in range(0, SENSOR.columns, SENSOR.columns // columns):
            caster, since = Raycaster(simulator.layout, by_id=True), SENSOR.column_times()[column] - 0.05
            for name, track in simulator.tracks.actors.items():
                box = next(box for box in simulator.layout.boxes() if box.id.split(".")[0] == name)
                place = track.at(np.array([at]))[0] + since * track.rate(at, SENSOR.sweep_time)
                caster.move(name, upright(tuple(place[:3].tolist()), place[3]))
                assert box.label
            truth = caster.scan(rays, poses[column])
            one, two = cast.depth[:, column], truth.depth[:, column]
            same = (cast.instance[:, column] == truth.instance[:, column]) & (truth.instance[:, column] > 0)
            others.append(float((cast.instance[:, column] != truth.instance[:, column]).mean()))
            worst.append(float(np.abs(one - two)[same].max(initial=0.0)))
    print(f"rolling shutter: {1e3 * max(worst):.2f} mm at most; {np.mean(others):.2%} of rays hit another object")


def flicker(pairs: Iterable[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]) -> str:
    """Of pairs of clouds in one frame: points and intensities of both."""
    distances, changes = list[float](), list[float]()
    for one, bright, two, other in pairs:
        some = two[:: max(1, len(two) // SAMPLED)]
        distance, nearest = cKDTree(one).query(some, AROUND)
        near = one[nearest[distance[:, -1] < WITHIN]]
        middle = near.mean(axis=1)
        normal = np.linalg.svd(near - middle[:, None], full_matrices=False)[2][:, 2]
        off = np.abs(np.einsum("nk,nk->n", normal, some[distance[:, -1] < WITHIN] - middle))
        distances.append(float(np.median(off)))
        cells, which = np.unique(np.floor(np.concatenate([one, two]) / PATCH), axis=0, return_inverse=True)
        first, second = which.ravel()[: len(one)], which.ravel()[len(one) :]
        counts = [np.bincount(part, minlength=len(cells)) for part in (first, second)]
        both = np.minimum(*counts) >= AROUND
        means = [np.bincount(*part, minlength=len(cells))[both] for part in ((first, bright), (second, other))]
        level = (bright.mean() + other.mean()) / 2
        changes.append(float(np.median(np.abs(means[0] / counts[0][both] - means[1] / counts[1][both])) / level))
    return f"{1e3 * np.mean(distances):.1f} mm, {np.mean(changes):.1%} of the mean intensity ({len(distances)} pairs)"


def standing(scan: Scan, moving: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Points in the world and intensities of standing objects near the sensor."""
    gone = {box.instance for box in scan.layout.boxes() if box.id.split(".")[0] in moving}
    points = scan.points().astype(np.float64)
    kept = ~np.isin(scan.instances(), list(gone)) & (np.linalg.norm(points, axis=1) < FAR)
    return points[kept] @ scan.pose[:3, :3].T + scan.pose[:3, 3], scan.intensities()[kept]


def simulated_flicker(frames: int, step: int, seeds: bool) -> str:
    """Of frames of the street `step` apart, each of a world of its own seed with `seeds`."""
    scenario = Scenario(AlongLane(8.0))
    layout = SequenceSimulator(STREET, SENSOR, scenario, frames=1).layout
    made, clouds = None, []
    for number in range(0, frames, step):
        if made is None or seeds:
            made = SequenceSimulator(layout, SENSOR, scenario, frames=frames, seed=number if seeds else 0)
        clouds.append(standing(made.frame(number), list(made.tracks.actors)))
    return flicker((*one, *two) for one, two in itertools.pairwise(clouds))


def odometry(clouds: Iterable[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """The poses [N, 4, 4] that KISS-ICP finds of points [N, 3] and their times, 0 to 1."""
    from kiss_icp.config import load_config
    from kiss_icp.kiss_icp import KissICP

    found, kiss = [], KissICP(load_config(None))
    for points, times in clouds:
        kiss.register_frame(points.astype(np.float64), times.astype(np.float64))
        found.append(kiss.last_pose.copy())
    return np.array(found)


def drift(name: str, simulator: SequenceSimulator) -> None:
    """Of a sequence; of one in which the ego vehicle goes less than a metre nothing is said."""
    scans = list(simulator)
    found = odometry((scan.image.points(), scan.image.times() / SENSOR.sweep_time) for scan in scans)[WARM:]
    true = np.array([scan.poses()[-1] for scan in scans])[WARM:]  # KISS-ICP's poses are those at the end of a sweep
    found, true = np.linalg.inv(found[0]) @ found, np.linalg.inv(true[0]) @ true
    length = float(np.linalg.norm(np.diff(true[:, :3, 3], axis=0), axis=1).sum())
    off = float(np.linalg.norm(found[:, :3, 3] - true[:, :3, 3], axis=1).max())
    share = f": {off / length:.2%}" if length > 1.0 else ""
    print(f"odometry {name}: {off:.2f} m off at most over {length:.1f} m{share}, {len(true)} frames")


def recorded(folder: Path) -> str:
    """Flicker of the recorded drive."""
    clouds = []
    for path in sorted((folder / "kitti" / "raw_drive_0005").glob("*.pcd*"))[:-1]:
        rows = parse_pcd(file_bytes(path)).columns
        points = np.stack([rows["x"], rows["y"], rows["z"]], axis=1).astype(np.float64)
        kept = np.linalg.norm(points, axis=1) > 1.0
        clouds.append((points[kept], np.asarray(rows["intensity"], np.float64)[kept]))
    poses = odometry((points, np.zeros(0)) for points, _ in clouds)  # KITTI has taken the motion out
    near = []
    for (points, bright), pose in zip(clouds, poses, strict=True):
        kept = np.linalg.norm(points, axis=1) < FAR
        near.append((points[kept] @ pose[:3, :3].T + pose[:3, 3], bright[kept]))
    return flicker((*one, *two) for one, two in itertools.pairwise(near))


def report_sequences(arguments: argparse.Namespace, folder: Path | None) -> None:
    """Print all of sequences."""
    frames_a_second(arguments.frames)
    shutter()
    for step in (1, 3):
        print(f"flicker, {step / 10:g} s apart, a sequence: {simulated_flicker(30, step, seeds=False)}")
    print(f"flicker, 0.3 s apart, independent samples: {simulated_flicker(30, 3, seeds=True)}")
    if folder is not None:
        print(f"flicker, 0.3 s apart, recorded: {recorded(folder)}")
    for name, sentence in (("straight ahead", STREET), ("in a bend", BEND)):
        scenario, frames = Scenario(AlongLane(7.0)), arguments.frames + WARM
        drift(name, SequenceSimulator(sentence, SENSOR, scenario, frames=frames))
    config = StreetConfig(sensor=SENSOR, half_length=HALF_LENGTH)
    for number in range(arguments.drives):
        drive = street_drive(number, seed=1, config=config, frames=arguments.frames + WARM)
        drift(f"drive {number}, {drive.layout.intent.district}", drive)


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
        scan = RecordedScan.from_points(points, Sensor.preset("hdl64e"), boxes=boxes, intensity=intensity)
        yield "KITTI object", scan
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


def report_edits(folder: Path) -> None:
    """Print a line for each data set, and how many scans a second are augmented."""
    warnings.simplefilter("ignore")  # of things without a box around recorded cars
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


def rates(calls: list[list[str]], scans: int) -> tuple[float, float]:
    """Scans a second, and seconds of processors that a scan takes, of calls at once that make a set."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "recipe.toml").write_text(RECIPE)
        command = [sys.executable, "-m", "lidardraft", "dataset", "recipe.toml", "-n", str(scans), "-o", "set"]
        begun, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        running = [subprocess.Popen([*command, *more], cwd=folder, stdout=subprocess.DEVNULL) for more in calls]
        if max([process.wait() for process in running]):  # all of them
            raise SystemExit("a call failed")
        took, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return scans / took, used / scans


def report_workers(arguments: argparse.Namespace) -> None:
    """Print a line for each way, with its ratio to one process."""
    found = [[rates(calls, arguments.scans) for calls in WAYS.values()] for _ in range(arguments.rounds)]
    middle = np.median(np.array(found), axis=0)
    for name, (rate, used) in zip(WAYS, middle, strict=True):
        print(f"{name}: {rate:.1f} scans/s, {rate / middle[0, 0]:.2f} times one; {1e3 * used:.0f} ms of a core a scan")


def main() -> None:
    """Print all parts, or those that are named."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help="sequences, edits, workers (default all)")
    parser.add_argument("--data", type=Path, default=os.environ.get("LIDARDRAFT_DATA"), help="folder of recordings")
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--drives", type=int, default=10, help="street drives whose odometry is checked")
    parser.add_argument("--scans", type=int, default=96, help="of a data set")
    parser.add_argument("--rounds", type=int, default=3, help="in which data sets are made")
    arguments = parser.parse_args()
    parts = arguments.parts or ["sequences", "edits", "workers"]
    if not set(parts) <= {"sequences", "edits", "workers"}:
        parser.error("parts are sequences, edits and workers")
    folder = None if arguments.data is None else Path(arguments.data)
    if "sequences" in parts:
        report_sequences(arguments, folder)
    if "edits" in parts and folder is not None:
        report_edits(folder)
    elif "edits" in parts:
        print("edits are left out: neither --data nor LIDARDRAFT_DATA names recordings")
    if "workers" in parts:
        report_workers(arguments)


if __name__ == "__main__":
    main()
