"""PandaSet (Xiao et al., ITSC 2021): folders NNN with lidar/, annotations/cuboids/ and annotations/semseg/, tables of
pandas.

Points and cuboids are in the world frame, each point by the vehicle's pose at its time. lidar/poses.json and
timestamps.json hold the poses at the end of each sweep, in a frame with x to the right, y ahead and z up. Sweeps are of
a Pandar64 and of a forward PandarGT, which is left out.
"""

from __future__ import annotations

import math
import os
from functools import lru_cache
from pathlib import Path

import numpy as np

from lidardraft.errors import FormatError, one_of
from lidardraft.files import expecting, named, read_text
from lidardraft.formats.pickled_table import read_pickled_table
from lidardraft.json_fields import parse_list
from lidardraft.scene.box import Box
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME

# The class of each of PandaSet's labels, from 1 on.
CLASSES = {
    "Smoke": "none",
    "Exhaust": "none",
    "Spray or rain": "none",
    "Reflection": "none",
    "Vegetation": "vegetation",
    "Ground": "terrain",
    "Road": "road",
    "Lane Line Marking": "road",
    "Stop Line Marking": "road",
    "Other Road Marking": "road",
    "Sidewalk": "sidewalk",
    "Driveway": "road",
    "Car": "car",
    "Pickup Truck": "car",
    "Medium-sized Truck": "truck",
    "Semi-truck": "truck",
    "Towed Object": "other",
    "Motorcycle": "motorcycle",
    "Other Vehicle - Construction Vehicle": "truck",
    "Other Vehicle - Uncommon": "truck",
    "Other Vehicle - Pedicab": "other",
    "Emergency Vehicle": "truck",
    "Bus": "bus",
    "Personal Mobility Device": "bicycle",
    "Motorized Scooter": "motorcycle",
    "Bicycle": "bicycle",
    "Train": "train",
    "Trolley": "train",
    "Tram / Subway": "train",
    "Pedestrian": "person",
    "Pedestrian with Object": "person",
    "Animals - Bird": "none",
    "Animals - Other": "none",
    "Pylons": "other",
    "Road Barriers": "other",
    "Signs": "traffic-sign",
    "Cones": "other",
    "Construction Signs": "traffic-sign",
    "Temporary Construction Barriers": "other",
    "Rolling Containers": "other",
    "Building": "building",
    "Other Static Object": "other",
}
LABELS = np.array([0, *(BY_NAME[name].id for name in CLASSES.values())], dtype=np.uint8)  # our ids by theirs
_PANDAR64, _PANDAR_GT = 0, 1  # in columns d and cuboids.sensor_id; -1 is both
_HALF_SWEEP = 0.05  # s; a sweep ends at its time
# The Pandar64 in the frame of the poses, in metres and its axes as columns. Seen from here, points are nearest to its
# beams: 0.006 degrees off (0.06 from the origin), in both drives that were measured, 001 and 002.
_PLACE = (0.0, 0.82, 1.86)
_UP = math.radians(0.9)
_TURN = np.array([(0.0, -1.0, 0.0), (math.cos(_UP), 0.0, -math.sin(_UP)), (math.sin(_UP), 0.0, math.cos(_UP))])


def sweeps_of(root: str | os.PathLike[str]) -> list[Path]:
    """The sweeps of all drives, in their order."""
    return sorted(Path(root).glob("[0-9][0-9][0-9]/lidar/*.pkl.gz"))


def read_sweep(path: str | os.PathLike[str]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Points f32 [N, 3] of the Pandar64, in its frame in the middle of the sweep; `intensity`, 0 to 255, `ring` i64
    and, if the drive has annotations/semseg, `label` u8 [N].

    The laser of a point is the one with the elevation of the point, seen from the sensor's place at its time. Raises
    `FormatError`.
    """
    path = Path(path).absolute()
    table = _table(path, "x", "y", "z", "i", "t", "d")
    mine = table["d"] == _PANDAR64
    world, times = np.stack([table[axis][mine] for axis in "xyz"], axis=1), table["t"][mine]
    points = _seen_from(_middle(path, path.parents[1]), world)
    x, y, z = _seen_from(_poses_at(path.parents[1], times), world).T
    elevations = np.array(Sensor.preset("pandar64").elevations)
    ring = np.searchsorted(-(elevations[1:] + elevations[:-1]) / 2, -np.arctan2(z, np.hypot(x, y)))
    fields = {"intensity": table["i"][mine], "ring": ring}
    labels = path.parents[1] / "annotations" / "semseg" / path.name
    if labels.exists():
        fields["label"] = _read_semseg(labels, len(mine))[mine]
    return points.astype(np.float32), fields


def boxes_of(sweep: Path) -> list[Box]:
    """The boxes of a sweep (`read_cuboids`); an empty list if the data set has none of it."""
    path = sweep.parents[1] / "annotations" / "cuboids" / sweep.name
    return read_cuboids(path) if path.exists() else []


def read_cuboids(path: str | os.PathLike[str]) -> list[Box]:
    """The boxes of annotations/cuboids/NN.pkl.gz in the frame of their sweep, without those of the PandarGT alone.
    Raises `FormatError`."""
    path = Path(path).absolute()
    places, sizes = (tuple(f"{name}.{axis}" for axis in "xyz") for name in ("position", "dimensions"))
    table = _table(path, "yaw", "cuboids.sensor_id", *places, *sizes)
    names = table.get("label", [None])
    if unknown := [name for name in names if name not in CLASSES]:
        raise FormatError(f"{path}: a box is {unknown[0]!r}; it must be {one_of(CLASSES, str(unknown[0]))}")
    ridden = np.asarray(table.get("attributes.rider_status", names) == "With Rider")
    labels = ["rider" if rides else CLASSES[name] for name, rides in zip(names, ridden, strict=True)]
    pose, yaw = _middle(path, path.parents[2]), table["yaw"]
    centers = _seen_from(pose, np.stack([table[column] for column in places], axis=1))
    length_axes = np.stack([-np.sin(yaw), np.cos(yaw), np.zeros(len(yaw))], axis=1)  # a yaw of 0 is along y
    ahead = _turned_back(pose, length_axes) @ _TURN
    width, length, height = (table[column].tolist() for column in sizes)
    with named(path):
        return [
            Box(
                id=f"{label}_{number + 1}",
                label=label,
                instance=(number + 1) * BY_NAME[label].is_thing,
                center=tuple(centers[number].tolist()),
                size=(length[number], width[number], height[number]),
                yaw=math.atan2(ahead[number, 1], ahead[number, 0]),
            )
            for number, label in enumerate(labels)
            if label != "none" and table["cuboids.sensor_id"][number] != _PANDAR_GT
        ]


def _read_semseg(path: Path, count: int) -> np.ndarray:
    raw = _table(path, "class")["class"]
    if len(raw) != count:
        raise FormatError(f"{path} has {len(raw)} labels; the sweep has {count} points")
    if wrong := set(raw.tolist()) - set(range(1, len(CLASSES) + 1)):
        raise FormatError(f"{path} has class {min(wrong)}; PandaSet has 1 to {len(CLASSES)}")
    return LABELS[raw.astype(np.int64)]


def _table(path: Path, *columns: str) -> dict[str, np.ndarray]:
    """A table that has these columns, of finite numbers."""
    table = read_pickled_table(path)
    for column in columns:
        if column not in table or table[column].dtype.kind not in "fi" or not np.isfinite(table[column]).all():
            raise FormatError(f"{path}: there is no column {column} of finite numbers")
    return table


def _seen_from(pose: np.ndarray, world: np.ndarray) -> np.ndarray:
    """Points [N, 3] of the world in the frame of the Pandar64, with the vehicle at `pose` [7] or [N, 7]."""
    seen: np.ndarray = (_turned_back(pose, world - pose[..., :3]) - _PLACE) @ _TURN
    return seen


def _turned_back(pose: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Directions [N, 3] of the world in the frame of `pose`."""
    real, axis = pose[..., 3:4], -pose[..., 4:]
    turned: np.ndarray = vectors + 2 * np.cross(axis, np.cross(axis, vectors) + real * vectors)
    return turned


def _middle(path: Path, drive: Path) -> np.ndarray:
    """The pose [7] in the middle of the sweep of a file."""
    times, number = _drive(drive)[0], path.name.removesuffix(".pkl.gz")
    if not number.isdecimal() or int(number) >= len(times):
        raise FormatError(f"{path}: the drive has poses of sweeps 0 to {len(times) - 1}, none of {number}")
    return _poses_at(drive, times[int(number)] - _HALF_SWEEP)


def _poses_at(drive: Path, times: np.ndarray) -> np.ndarray:
    """The vehicle's poses at times [...]: x y z, and a unit quaternion w x y z; [..., 7]."""
    known, poses = _drive(drive)
    found = np.stack([np.interp(times, known, column) for column in poses.T], axis=-1)
    found[..., 3:] /= np.linalg.norm(found[..., 3:], axis=-1, keepdims=True)
    return found


@lru_cache(maxsize=2)
def _drive(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """The times [F] of a drive's poses, and the poses [F, 7]."""
    path, parts = folder / "lidar" / "poses.json", {"position": "xyz", "heading": "wxyz"}
    text = read_text(path)
    with named(path), expecting("a list of poses, each a position x y z and a heading w x y z"):
        rows = [[row[part][axis] for part, axes in parts.items() for axis in axes] for row in parse_list(text)]
        poses = np.array(rows, dtype=np.float64).reshape(-1, 7)
        if not np.isfinite(poses).all() or not np.linalg.norm(poses[:, 3:], axis=1).all():
            raise FormatError("a pose is not finite, or its heading is 0")
    path = folder / "lidar" / "timestamps.json"
    text = read_text(path)
    with named(path), expecting("a list of times"):
        times = np.array(parse_list(text), dtype=np.float64)
        if times.shape != (len(poses),) or not len(poses) or not (np.diff(times) > 0).all():
            raise FormatError(f"it must hold a time for each of the {len(poses)} poses, the later the larger")
    opposite = (poses[1:, 3:] * poses[:-1, 3:]).sum(axis=1) < 0
    poses[1:, 3:] *= np.cumprod(np.where(opposite, -1.0, 1.0))[:, None]  # q and -q are one rotation
    return times, poses
