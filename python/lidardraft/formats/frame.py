"""Frames, in drives: the values from which the formats of other data sets are written."""

from __future__ import annotations

import importlib
import io
import itertools
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from lidardraft.errors import FormatError, one_of
from lidardraft.files import new_folder, write_text
from lidardraft.scene.box import Box
from lidardraft.scene.pose import in_upright_frame, inverse, upright
from lidardraft.scene.sensor import Sensor

# The module of `formats`, its function that writes drives into an empty folder, and a description of the format.
FORMATS = {
    "kitti": ("kitti_object", "write_kitti_object", "KITTI's 3D object benchmark"),
    "semantickitti": ("semantickitti", "write_sequences", "SemanticKITTI, a sequence a folder"),
    "nuscenes": ("nuscenes", "write_nuscenes", "nuScenes with lidarseg"),
    "openpcdet": ("openpcdet", "write_openpcdet", "OpenPCDet's custom data sets"),
    "mmdet3d": ("mmdet3d", "write_mmdet3d", "MMDetection3D's custom data sets"),
    "pcd": ("pcd", "write_pcd_folder", "PCD files with ring, label and instance"),
    "ply": ("ply", "write_ply_folder", "PLY files with the same"),
    "las": ("las", "write_las", "LAS files with the same"),
    "ros2": ("ros2", "write_ros2", "ROS 2 bags (MCAP), one a drive, which Foxglove opens too"),
    "webdataset": ("webdataset", "write_webdataset", "WebDataset shards"),
}
AS_SEEN = ("ros2",)  # formats with points distorted by the sensor's motion, which consumers take out
BY_DRIVE = ("semantickitti", "nuscenes", "ros2")  # formats that number drives, and not frames
UNBOXED = ("semantickitti", "pcd", "ply", "las")  # formats without boxes
MOVING = 0.3  # m/s, the least speed of a moving object; an estimate
VALIDATION_SHARE = 0.2  # of a data set's frames, its last ones
_RECORD = [(name, "<f4") for name in ("x", "y", "z", "intensity")]
_RECORD += [("ring", "<u2"), ("time", "<f4"), ("label", "u1"), ("instance", "<u4")]
_RIDDEN = ("bicycle", "motorcycle")
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Annotation:
    """A sensor-frame box, the number of points on its object, and the share of the object that others hide.

    A rider and its vehicle are one object with the label rider; `ridden` is then bicycle or motorcycle, and
    `ridden_instance` its number. The box is larger than the object's own by `margin` [m] on each side.
    """

    box: Box
    num_points: int
    occlusion: float
    ridden: str = ""
    ridden_instance: int | None = None
    margin: float = 0.0

    def holds(self, instance: np.ndarray) -> np.ndarray:
        """Whether each of the points of `instance` [N] is on the object, bool [N]."""
        return np.isin(instance, [each for each in (self.box.instance, self.ridden_instance) if each is not None])

    def moves(self) -> bool:
        """Whether it is known to move over the ground."""
        return self.box.velocity is not None and math.hypot(*self.box.velocity) > MOVING

    def grown(self, margin: float) -> Annotation:
        """The annotation with a box that is larger by `margin` [m] on each side."""
        length, width, height = (extent + 2 * margin for extent in self.box.size)
        return replace(self, box=replace(self.box, size=(length, width, height)), margin=margin)


def with_riders_merged(annotations: Sequence[Annotation]) -> tuple[Annotation, ...]:
    """The annotations with each rider and its vehicle merged, as data sets count them: the parts of one object ID of a
    layout, as ID.rider and ID.bicycle, become ID."""
    vehicles = {a.box.id.partition(".")[0]: a for a in annotations if a.box.label in _RIDDEN}
    riders = {a.box.id.partition(".")[0]: a for a in annotations if a.box.label == "rider"}
    pairs = {name: (riders[name], vehicle) for name, vehicle in vehicles.items() if name in riders}
    alone = [a for a in annotations if a.box.id.partition(".")[0] not in pairs]
    return (*alone, *(_merged(name, *pair) for name, pair in pairs.items()))


def _merged(name: str, rider: Annotation, vehicle: Annotation) -> Annotation:
    place = vehicle.box.center, vehicle.box.yaw
    corners = np.concatenate([in_upright_frame(part.box.corners(), *place) for part in (rider, vehicle)])
    least, most = corners.min(axis=0), corners.max(axis=0)
    pose = upright(*place)
    center = pose[:3, :3] @ ((least + most) / 2) + pose[:3, 3]
    box = replace(rider.box, id=name, center=tuple(center.tolist()), size=tuple((most - least).tolist()))
    return Annotation(
        replace(box, yaw=vehicle.box.yaw),
        rider.num_points + vehicle.num_points,
        (rider.occlusion + vehicle.occlusion) / 2,
        vehicle.box.label,
        vehicle.box.instance,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Frame:
    """One labelled scan, taken at `pose` (world_from_sensor [4, 4]) in the middle of its sweep.

    Of each of N points, in the sensor frame: `points` f32 [N, 3] [m], `intensity` f32 [N] in 0 to 1, `ring` u16 [N] (0
    is the highest beam), `label` u8 [N] of `semantics.CLASSES`, `instance` u32 [N]. `time` f32 [N] [s] after the first
    column goes with raw points, in the frame of their own column. It is None for points without the sensor's own
    motion, which must not be taken out again.

    Frames of one `world`, the JSON of the provenance, intent and notes of a layout, show the same objects under the
    same ids. `start` is the time of the first column since the start of the drive [s]; None if unknown (`timed`).
    `mount` is that of `Scan`, `channel` the name of the sensor among several of one vehicle. `split` is the use of the
    frame: "train", "val" or "test".
    """

    sensor: Sensor
    pose: np.ndarray
    points: np.ndarray
    intensity: np.ndarray
    ring: np.ndarray
    label: np.ndarray
    instance: np.ndarray
    time: np.ndarray | None = None
    annotations: tuple[Annotation, ...] = ()
    world: str = ""
    start: float | None = None
    mount: tuple[float, float, float, float] | None = None
    channel: str = ""
    split: str = ""

    def seen(self) -> list[Annotation]:
        """The annotations of objects with at least one point."""
        return [annotation for annotation in self.annotations if annotation.num_points]

    def ego_from_sensor(self) -> np.ndarray:
        """The pose [4, 4] of the sensor on its vehicle, whose origin is on the road."""
        x, y, z, yaw = self.mount or (0.0, 0.0, self.sensor.mount_height, 0.0)
        return upright((x, y, z), yaw)

    def world_from_ego(self) -> np.ndarray:
        """The pose [4, 4] of the road under the vehicle."""
        return self.pose @ inverse(self.ego_from_sensor())

    def fields(self) -> dict[str, np.ndarray]:
        """The values of each point other than place and intensity, by name; absent ones are left out."""
        named = {name: getattr(self, name) for name in ("ring", "time", "label", "instance")}
        return {name: values for name, values in named.items() if values is not None}


Drives = Iterable[Iterable[Frame]]  # the frames of a drive are in order of time


def timed(drive: Iterable[Frame]) -> Iterator[tuple[float, Frame]]:
    """Frames with their time since the first one [s]: their own start times, or a sweep time apart."""
    first = None
    for number, frame in enumerate(drive):
        start = frame.start if frame.start is not None else number * max(frame.sensor.sweep_time, 1e-6)
        first = start if first is None else first
        yield start - first, frame


def writer_of(format: str) -> Callable[..., None]:
    """The function that writes drives in one of `FORMATS` into a new folder, `write(output, drives, first=0)`. A part
    of a data set numbers frames, and drives, from `first` on.

    Raises `FormatError` for another name. The function raises it if `output` exists already or cannot be written, and
    if there are no drives, or one without frames; then it leaves nothing behind.
    """
    if format not in FORMATS:
        raise FormatError(f"format is {format!r}; it must be {one_of(FORMATS, format)}")
    module, function, _ = FORMATS[format]
    fill = getattr(importlib.import_module(f"lidardraft.formats.{module}"), function)

    def write(output: str | os.PathLike[str], drives: Drives, first: int = 0) -> None:
        with new_folder(output) as folder:
            fill(folder, _some(map(_some, drives)), first)

    return write


def _some(items: Iterable[T]) -> Iterator[T]:
    """The items; raises `FormatError` at the end if there were none."""
    none = True
    for item in items:
        none = False
        yield item
    if none:
        raise FormatError("there are no scans to write")


def numbered(drives: Drives, first: int) -> Iterator[tuple[str, Frame]]:
    """All frames with the names 000000, 000001, ..."""
    return ((f"{number:06d}", frame) for number, frame in enumerate(itertools.chain.from_iterable(drives), first))


def write_each(ending: str, by: Callable[[Path, np.ndarray], None], folder: Path, drives: Drives, first: int) -> None:
    """Write a file of `point_records` for each frame."""
    for name, frame in numbered(drives, first):
        by(folder / f"{name}{ending}", point_records(frame))


def point_records(frame: Frame) -> np.ndarray:
    """The points as packed records [N] of x y z intensity and the frame's `fields`."""
    fields = {"intensity": frame.intensity, **frame.fields()}
    records = np.empty(len(frame.points), [row for row in _RECORD if row[0] in ("x", "y", "z", *fields)])
    records["x"], records["y"], records["z"] = frame.points.T
    for field, values in fields.items():
        records[field] = values
    return records


def npy(array: np.ndarray) -> bytes:
    """The content of a .npy file."""
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def write_image_sets(folder: Path, splits: Mapping[str, str]) -> None:
    """Write ImageSets/train.txt, val.txt and so on, and trainval.txt, from the frames' names and splits. If no frame
    has a split, the last fifth of them, one at least, is for validation."""
    names = list(splits)
    most = min(len(names) - 1, round(len(names) * (1 - VALIDATION_SHARE)))
    parts = by_split(splits) or {"train": names[:most], "val": names[most:]}
    parts = {"train": [], "val": [], **parts, "trainval": parts.get("train", []) + parts.get("val", [])}
    (folder / "ImageSets").mkdir(exist_ok=True)
    for part, those in parts.items():
        write_text(folder / "ImageSets" / f"{part}.txt", "".join(f"{name}\n" for name in those))


def by_split(splits: Mapping[str, str]) -> dict[str, list[str]]:
    """The names of each split; names without a split are left out."""
    parts = {split: [name for name in splits if splits[name] == split] for split in splits.values()}
    parts.pop("", None)
    return parts
