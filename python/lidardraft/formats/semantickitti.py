"""SemanticKITTI: .label files of one uint32 a point, class in the low 16 bits, instance in the high 16 bits.

The tables follow semantic-kitti.yaml (Behley et al., ICCV 2019). Reading merges: moving or not; parking and lane
marking (road); other ground (terrain); other vehicle (truck); bicyclist or motorcyclist (rider); other structure and
other object (other); outlier and unlabelled (none). Writing merges wall (fence) and traffic light (other object), which
SemanticKITTI lacks; in a sequence, moving bicycles and motorcycles have the class of their rider.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import read_bytes, write_text, written_whole
from lidardraft.formats.frame import Annotation, Drives, Frame, by_split, timed
from lidardraft.formats.kitti import write_bin
from lidardraft.scene.pose import inverse
from lidardraft.semantics import BY_NAME, CLASSES, NUM_CLASSES

CLASS_FROM_RAW: dict[int, str] = {
    0: "none",  # unlabeled
    1: "none",  # outlier
    10: "car",
    11: "bicycle",
    13: "bus",
    15: "motorcycle",
    16: "train",  # on-rails
    18: "truck",
    20: "truck",  # other-vehicle
    30: "person",
    31: "rider",  # bicyclist
    32: "rider",  # motorcyclist
    40: "road",
    44: "road",  # parking
    48: "sidewalk",
    49: "terrain",  # other-ground
    50: "building",
    51: "fence",
    52: "other",  # other-structure
    60: "road",  # lane-marking
    70: "vegetation",
    71: "trunk",
    72: "terrain",
    80: "pole",
    81: "traffic-sign",
    99: "other",  # other-object
    252: "car",  # 252 to 259 are moving
    253: "rider",
    254: "person",
    255: "rider",
    256: "train",
    257: "bus",
    258: "truck",
    259: "truck",
}

# The lowest raw id of a class is the one written, with four exceptions: two have a better one, two have none.
RAW_FROM_CLASS: dict[str, int] = {
    **{name: raw for raw, name in reversed(CLASS_FROM_RAW.items())},
    "terrain": 72,
    "other": 99,
    "wall": 51,
    "traffic-light": 99,
}

# Of moving objects: the lowest such id of the class; a ridden vehicle has that of moving-bicyclist or -motorcyclist.
RAW_OF_MOVING = {name: raw for raw, name in reversed(CLASS_FROM_RAW.items()) if raw >= 252}
RAW_OF_MOVING |= {"bicycle": 253, "motorcycle": 255}

_INSTANCE_LIMIT = 2**16 - 1
OUTLIER = 1
_CAMERA = np.array([(0.0, -1, 0, 0), (0, 0, -1, 0), (1, 0, 0, 0), (0, 0, 0, 1)])  # camera_from_lidar


def read_label(
    path: str | os.PathLike[str], count: int, *, of: str | os.PathLike[str] = "the scan"
) -> tuple[np.ndarray, np.ndarray]:
    """Class ids u8 [count] of `semantics.CLASSES` and instances u32 [count], counted by SemanticKITTI for each class.

    `of` is the name of the scan in messages, as either file may be the wrong one. Raises `FormatError` if the file does
    not hold `count` labels or has a class that SemanticKITTI lacks.
    """
    name, data = os.fspath(path), read_bytes(path)
    if len(data) != 4 * count:
        said = f"{len(data) / 4:g} labels; {os.fspath(of)} has {count} points"
        raise FormatError(f"{name} has {len(data)} bytes, {said} (four bytes a label)")
    words = np.frombuffer(data, dtype="<u4")
    raw = words & 0xFFFF
    table = np.full(2**16, NUM_CLASSES, dtype=np.uint8)
    for raw_id, class_name in CLASS_FROM_RAW.items():
        table[raw_id] = BY_NAME[class_name].id
    label = table[raw]
    unknown = np.flatnonzero(label == NUM_CLASSES)
    if len(unknown):
        raise FormatError(f"{name}: point {unknown[0]} has class {raw[unknown[0]]}, which SemanticKITTI does not have")
    return label, words >> 16


def write_label(
    path: str | os.PathLike[str], label: np.ndarray, instance: np.ndarray, *, raw: np.ndarray | None = None
) -> None:
    """Write class ids [N] of `semantics.CLASSES` and instances [N] as SemanticKITTI labels; its class `raw` [N] takes
    precedence unless it is 0."""
    name = os.fspath(path)
    if label.ndim != 1 or instance.shape != label.shape:
        raise FormatError(f"{name}: label {label.shape} and instance {instance.shape} must both be [N]")
    for values, what, limit in ((label, "class", NUM_CLASSES - 1), (instance, "instance", _INSTANCE_LIMIT)):
        outside = np.flatnonzero((values < 0) | (values > limit))
        if len(outside):
            raise FormatError(f"{name}: point {outside[0]} has {what} {values[outside[0]]}; it must be 0 to {limit}")
    table = np.array([RAW_FROM_CLASS[row.name] for row in CLASSES], dtype="<u4")
    words = table[label] if raw is None else np.where(raw, raw, table[label])
    words = words.astype("<u4") | (instance.astype("<u4") << np.uint32(16))
    with written_whole(path) as temporary:
        temporary.write_bytes(words.astype("<u4").tobytes())


def write_sequences(folder: Path, drives: Drives, first: int) -> None:
    """Write sequences/00, 01, ... of the drives: velodyne/, labels/, poses.txt, times.txt and calib.txt.

    Poses are those of the camera relative to its first one, as in KITTI's odometry; `Tr` places it at the sensor, with
    x right, y down and z ahead.
    """
    splits = dict[str, str]()
    for number, drive in enumerate(drives, first):
        splits[f"{number:02d}"] = _write_sequence(folder / "sequences" / f"{number:02d}", drive)
    if parts := by_split(splits):
        write_text(folder / "splits.json", json.dumps(parts))


def _write_sequence(folder: Path, drive: Iterable[Frame]) -> str:
    """Write a sequence; returns its split."""
    for part in ("velodyne", "labels"):
        (folder / part).mkdir(parents=True)
    poses, times, split = list[np.ndarray](), list[float](), ""
    for number, (time, frame) in enumerate(timed(drive)):
        write_bin(folder / "velodyne" / f"{number:06d}.bin", frame.points, frame.intensity)
        raw = np.zeros(len(frame.label), np.uint32)
        for each in filter(Annotation.moves, frame.annotations):
            raw[each.holds(frame.instance)] = RAW_OF_MOVING[each.ridden or each.box.label]
        write_label(folder / "labels" / f"{number:06d}.label", frame.label, frame.instance, raw=raw)
        poses.append(frame.pose)
        times.append(time)
        split = frame.split
    of_camera = [_CAMERA @ inverse(poses[0]) @ pose @ _CAMERA.T for pose in poses]
    write_text(folder / "poses.txt", "".join(f"{_row(pose)}\n" for pose in of_camera))
    write_text(folder / "times.txt", "".join(f"{time:.6e}\n" for time in times))
    flat = {**{f"P{camera}": np.eye(4) for camera in range(4)}, "Tr": _CAMERA}
    write_text(folder / "calib.txt", "".join(f"{key}: {_row(matrix)}\n" for key, matrix in flat.items()))
    return split


def _row(matrix: np.ndarray) -> str:
    return " ".join(f"{value:.12e}" for value in matrix[:3].ravel())
