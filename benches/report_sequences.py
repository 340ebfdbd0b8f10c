"""Sequences: frames a second, the error of the rolling shutter, flicker of what stands, and odometry.

    python benches/report_sequences.py [--data FOLDER] [--frames 100]

- Frames a second of 64 x 2048 rays of a crossroads with traffic, with the threads that there are.
- Rolling shutter: casts of frames beside casts in which every body stands where it is when the column fires, one scene
  a column; the largest difference of ranges, and the share of returns from other objects.
- Flicker: of frames a tenth of a second or three apart, brought into one frame, the returns of what stands within
  30 m: the median distance of a return from the plane through the eight nearest of the other frame, and the median
  difference of the mean intensities of cells of 0.5 m that hold eight returns of both, over the mean of all.
  Independent samples are frames of one layout, each with details and brightness of a seed of its own. Recordings are
  KITTI's drive 0005 (CC BY-NC-SA, Geiger et al., IJRR 2013), three frames apart, where poses are those of KISS-ICP and
  what moves is not known.
- Odometry: KISS-ICP (Vizzo et al., RA-L 2023, `pip install kiss-icp`) on the points as the sensor gives them, against
  the true poses: the largest distance of the two over the length of the path. The first ten frames, in which it
  learns that it moves, are left out.
"""

from __future__ import annotations

import argparse
import dataclasses
import itertools
import os
import time
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from lidardraft import Raycaster, Scan, Sensor, StreetConfig, street_drive
from lidardraft.formats.pcd import parse_pcd
from lidardraft.scene.effects import sub_rays
from lidardraft.scene.pose import upright
from lidardraft.scene.scenario import AlongLane, Scenario
from lidardraft.simulation.motion.sequence import SequenceSimulator
from lidardraft.streets.drives import HALF_LENGTH
from recordings import file_bytes

CROSSROADS = "a busy downtown crossroads with a bus, cyclists and pedestrians, trees along the road"
STREET = "a street with parked cars on both sides, trees, houses, people on the sidewalk and a car ahead"
BEND = "a street that bends to the left with parked cars, trees and houses"
SENSOR = dataclasses.replace(Sensor.preset("hdl64e"), columns=2048)
WITHIN, FAR, PATCH = 0.5, 30.0, 0.5  # m: of neighbours, of returns from the sensor, and of the cells of patches
WARM = 10  # frames
AROUND, SAMPLED = 8, 20_000  # neighbours that make a surface, or returns a patch; returns that are looked at


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
    """Points in the world and intensities of what stands near the sensor."""
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


def main() -> None:
    """Print all of it."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--data", default=os.environ.get("LIDARDRAFT_DATA"), help="folder of recordings")
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--drives", type=int, default=10, help="street drives whose odometry is checked")
    arguments = parser.parse_args()
    frames_a_second(arguments.frames)
    shutter()
    for step in (1, 3):
        print(f"flicker, {step / 10:g} s apart, a sequence: {simulated_flicker(30, step, seeds=False)}")
    print(f"flicker, 0.3 s apart, independent samples: {simulated_flicker(30, 3, seeds=True)}")
    if arguments.data:
        print(f"flicker, 0.3 s apart, recorded: {recorded(Path(arguments.data))}")
    for name, sentence in (("straight ahead", STREET), ("in a bend", BEND)):
        scenario, frames = Scenario(AlongLane(7.0)), arguments.frames + WARM
        drift(name, SequenceSimulator(sentence, SENSOR, scenario, frames=frames))
    config = StreetConfig(sensor=SENSOR, half_length=HALF_LENGTH)
    for number in range(arguments.drives):
        drive = street_drive(number, seed=1, config=config, frames=arguments.frames + WARM)
        drift(f"drive {number}, {drive.layout.intent.district}", drive)


if __name__ == "__main__":
    main()
