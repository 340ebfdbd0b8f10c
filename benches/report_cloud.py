"""How near the layouts of labelled recordings come to them.

    python benches/report_cloud.py [--data FOLDER] [--only NAME] [--classes]

Each recording is clustered to a layout, and the bare layout is cast: by the sensor's preset, on the grid of the
recording ("near", "near on objects", "empty"), and along the rays of the recorded returns ("along rays"). Near is
within 0.5 m or 5 % of the recorded range; empty are recorded returns where the cast shows nothing. On a projected grid
the preset's lasers leave pixels empty whatever they look at: "holes" is the share of returns that even a closed room
does not show, and nothing can be less empty. "cars" is how many of the annotated cars with 100 returns or more a box
of the layout finds, with an intersection over union of 0.5 or more seen from above. `--classes` tells for each class
what the layouts show along the rays. Seconds are those of one core.
"""

from __future__ import annotations

import argparse
import os
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import object_labels
import recordings
from cases import Group, grouped, layout_of
from lidardraft import Layout, Sensor, layout_from_cloud, raycast
from lidardraft.formats.kitti import read_bin
from lidardraft.formats.semantickitti import read_label
from lidardraft.scene.labelling import ABSOLUTE_TOLERANCE, RELATIVE_TOLERANCE
from lidardraft.scene.layout import Primitive
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.sensor import PRESETS
from lidardraft.semantics import BY_NAME, CLASSES, GROUND
from tables import Row, table

NO_OBJECT = [BY_NAME[name].id for name in ("none", *GROUND)]
DETAILS = ("fine", "objects")
ROOM = Layout(primitives=(Primitive(shape="box", center=(0, 0, 0), size=(60, 60, 60), label="building", id="room"),))
Counts = dict[str, np.ndarray]  # by row: part and whole


def groups(folder: Path) -> Iterator[tuple[str, Group]]:
    """The recordings with labels in the folder, by name, those of a drive or place together."""
    kitti, nuscenes = PRESETS["hdl64e-linear"], recordings.NUSCENES_GRID
    if sweeps := recordings.kitti_images(folder):
        yield "KITTI 00, HDL-64E", grouped(sweeps, PRESETS["hdl64e"], kitti)
    if sweeps := recordings.nuscenes_images(folder):
        yield "nuScenes, HDL-32E", grouped(sweeps, PRESETS["hdl32e"], nuscenes)
    for name, sweeps in recordings.pandar64(folder, 1800).labelled.items():
        yield f"{name}, Pandar64", grouped(sweeps, PRESETS["pandar64"])
    ika = recordings.vlp32c(folder, 1800)
    for name, sweeps in ika.labelled.items():
        yield f"ika {name}, VLP-32C", grouped(sweeps, PRESETS["vlp32c"], fov=ika.fov)


def along_rays(layout: Layout, points: np.ndarray, sensor: Sensor) -> np.ndarray:
    """How far the layout is [N] in the directions of points [N, 3] of the sensor, 0 where it is nowhere."""
    origin = np.array([0.0, 0.0, sensor.mount_height])
    return Raycaster(layout).cast(origin, points.astype(np.float64)).distance


def is_near(recorded: np.ndarray, cast: np.ndarray) -> np.ndarray:
    """Whether a cast range is one, and within 0.5 m or 5 % of the recorded range."""
    tolerance = np.maximum(ABSOLUTE_TOLERANCE, RELATIVE_TOLERANCE * recorded)
    return (cast > 0) & (np.abs(cast - recorded) <= tolerance)


def measure(group: Group, detail: str) -> Row:
    """The row of a group: shares over all of its sweeps; primitives and seconds of one sweep, on average."""
    counts: Counts = defaultdict(lambda: np.zeros(2))
    primitives, seconds = [], []
    room = group.render(raycast(ROOM, group.sensor)).valid
    for sweep in group.sweeps:
        start = time.process_time()
        layout = layout_of(sweep, group.sensor, detail)
        seconds.append(time.process_time() - start)
        primitives.append(len(layout))
        cast = group.render(raycast(layout, group.sensor)).depth
        assert sweep.label is not None
        here, depth = sweep.valid & group.shown, sweep.depth
        on_objects = here & ~np.isin(sweep.label, NO_OBJECT)
        near = is_near(depth, cast)
        rays = along_rays(layout, sweep.points[here], group.sensor)
        for name, of, right in (
            ("near", here, near),
            ("near on objects", on_objects, near),
            ("empty", here, cast == 0),
            ("holes", here, ~room),
            ("along rays", here, _placed(is_near(depth[here], rays), here)),
            ("on objects, along rays", on_objects, _placed(is_near(depth[here], rays), here)),
            ("empty, along rays", here, _placed(rays == 0, here)),
        ):
            counts[name] += np.count_nonzero(of & right), np.count_nonzero(of)
    shares = {name: part / whole for name, (part, whole) in counts.items()}
    return {**shares, "primitives": float(np.mean(primitives)), "seconds": float(np.mean(seconds))}


def _placed(values: np.ndarray, where: np.ndarray) -> np.ndarray:
    image = np.zeros(where.shape, dtype=values.dtype)
    image[where] = values
    return image


def whole_scan(folder: Path, detail: str) -> Row | None:
    """The row of a whole scan of KITTI, with all that its file holds; the seconds are the best of three."""
    path = folder / "kitti" / "odometry_00" / "velodyne" / "000000.bin"
    if not path.is_file():
        return None
    points, _ = read_bin(path)
    labels, _ = read_label(path.parents[1] / "labels" / "000000.label", len(points))
    seconds = []
    for _ in range(3):
        start = time.process_time()
        layout = layout_from_cloud(points, labels, detail=detail)
        seconds.append(time.process_time() - start)
    depth = np.linalg.norm(points, axis=1)
    rays = along_rays(layout, points, PRESETS["hdl64e"])
    near, on_objects = is_near(depth, rays), ~np.isin(labels, NO_OBJECT)
    return {
        "points": float(len(points)),
        "along rays": float(near.mean()),
        "on objects, along rays": float(near[on_objects].mean()),
        "empty, along rays": float((rays == 0).mean()),
        "primitives": float(len(layout)),
        "seconds": min(seconds),
    }


def by_class(group: Group, detail: str) -> dict[str, Row]:
    """For each class the share of a group's returns, and what the layout shows along their rays."""
    counts: Counts = defaultdict(lambda: np.zeros(6))
    for sweep in group.sweeps:
        layout = layout_of(sweep, group.sensor, detail)
        here = sweep.valid & group.shown
        assert sweep.label is not None
        depth, label = sweep.depth[here], sweep.label[here]
        cast = along_rays(layout, sweep.points[here], group.sensor)
        near = is_near(depth, cast)
        for k in np.unique(label):
            mine = label == k
            off = mine & ~near
            counts[CLASSES[k].name] += (
                np.count_nonzero(mine),
                np.count_nonzero(mine & near),
                np.count_nonzero(off & (cast == 0)),
                np.count_nonzero(off & (cast > 0) & (cast < depth)),
                np.count_nonzero(off & (cast > depth)),
                sum(primitive.label == CLASSES[k].name for primitive in layout),
            )
    total = float(sum(values[0] for values in counts.values()))
    names = ("near", "empty", "too near", "too far")
    return {
        label: {
            "of all returns": whole / total,
            **dict(zip(names, values / whole, strict=True)),
            "primitives": number / len(group.sweeps),
        }
        for label, (whole, *values, number) in sorted(counts.items(), key=lambda item: -item[1][0])
    }


def cars(folder: Path) -> dict[str, Row]:
    """For each set of annotated frames: cars with 100 returns or more, and the share of them that a layout finds."""
    rows: dict[str, Row] = {}
    for name, read in (("KITTI objects", object_labels.kitti_frames), ("PandaSet", object_labels.pandaset_frames)):
        counted, found = 0, 0
        for frame in read(folder):
            known = frame.labels > 0
            points, labels = frame.points[known], frame.labels[known]
            layout = layout_from_cloud(points, labels, sensor_height=frame.sensor_height, detail="objects")
            here, there = object_labels.recovered(frame, layout)
            counted, found = counted + here, found + there
        if counted:
            rows[name] = {"cars": float(counted), "found": found / counted}
    return rows


def main() -> None:
    """Print all tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--data", type=Path, default=os.environ.get("LIDARDRAFT_DATA"), metavar="FOLDER")
    parser.add_argument("--only", default="", metavar="NAME", help="recordings whose names hold this")
    parser.add_argument("--classes", action="store_true", help="a table of classes for each")
    given = parser.parse_args()
    if given.data is None:
        parser.error("give the folder of the recordings as --data or LIDARDRAFT_DATA")
    found = {name: group for name, group in groups(given.data) if given.only in name}
    for detail in DETAILS:
        rows = {name: measure(group, detail) for name, group in found.items()}
        print(f"### detail {detail!r}\n\n{table(rows)}\n", flush=True)
    whole = {f"detail {detail!r}": row for detail in DETAILS if (row := whole_scan(given.data, detail))}
    print(f"### a whole scan of KITTI\n\n{table(whole)}\n", flush=True)
    if given.classes:
        for name, group in found.items():
            print(f"### {name}, by class\n\n{table(by_class(group, 'fine'))}\n", flush=True)
    print(f"### cars\n\n{table(cars(given.data))}")


if __name__ == "__main__":
    main()
