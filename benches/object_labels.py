"""Recorded sweeps with boxes around their objects: KITTI's object frames and PandaSet's.

The boxes of PandaSet may be fitted to; those of KITTI judge.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lidardraft.formats.kitti import read_bin
from lidardraft.formats.pandaset import LABELS
from lidardraft.scene.layout import Layout
from lidardraft.semantics import BY_NAME

ROAD, OTHER = BY_NAME["road"].id, BY_NAME["other"].id
_KITTI = {"Car": "car", "Van": "car", "Truck": "truck", "Tram": "train", "Pedestrian": "person", "Cyclist": "rider"}
_GROWTH = 0.1  # m around an annotated box, of which the points are the object's
_STANDS = 0.25  # m over the lowest return of a cell of 2 m; what is lower is ground
_CELL = 2.0


@dataclass(frozen=True, kw_only=True, slots=True)
class FittedBox:
    """An upright box: center [3], size [3] = (along yaw, across, up) in metres, yaw in (-pi/2, pi/2]."""

    center: np.ndarray
    size: np.ndarray
    yaw: float

    def to_local(self, points: np.ndarray) -> np.ndarray:
        """Points [N, 3] in the frame of the box, its center at the origin."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return (points - self.center) @ np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])

    def depths(self, points: np.ndarray) -> np.ndarray:
        """How far behind the nearest side or the roof [m] those of points [N, 3] lie that are in the box."""
        local = self.to_local(points)
        room = self.size / 2 - np.column_stack([np.abs(local[:, :2]), local[:, 2]])
        return room.min(axis=1)[(room > 0).all(axis=1) & (local[:, 2] > -self.size[2] / 2)]

    def contains(self, points: np.ndarray, margin: float = 0.0) -> np.ndarray:
        """bool [N]: above or below the box's footprint and further than `margin` from its edge; heights are ignored."""
        return (np.abs(self.to_local(points)[:, :2]) < self.size[:2] / 2 - margin).all(axis=1)


@dataclass(frozen=True)
class LabelledBoxes:
    """Points [N, 3] in the frame of the sensor, their labels [N], and the boxes around the cars."""

    points: np.ndarray
    labels: np.ndarray
    cars: list[FittedBox]
    sensor_height: float


def kitti_frames(folder: Path) -> Iterator[LabelledBoxes]:
    """KITTI's object frames. They have no labels of points: those in a box get the box's class; of the rest, what is
    close over the lowest return around it is road, and what is higher other."""
    kitti = folder / "kitti"
    for path in sorted([*kitti.glob("object/training/velodyne/*.bin"), *kitti.glob("object_cropped/velodyne/*.bin")]):
        points, _ = read_bin(path)
        points = points.astype(np.float64)
        calibration = _calibration(path.parents[1] / "calib" / f"{path.stem}.txt")
        labels = np.where(_is_ground(points), ROAD, OTHER).astype(np.uint8)
        cars = []
        for line in (path.parents[1] / "label_2" / f"{path.stem}.txt").read_text().splitlines():
            name, *numbers = line.split()
            if name == "DontCare":
                continue
            box = _from_camera(np.array(numbers[7:14], dtype=float), calibration)
            if name in _KITTI:
                mine = _within(box, points) & (labels == OTHER)
                labels[mine] = BY_NAME[_KITTI[name]].id
            if name in ("Car", "Van"):
                cars.append(box)
        yield LabelledBoxes(points, labels, cars, 1.73)


def pandaset_frames(folder: Path, classes: tuple[str, ...] = ("Car",)) -> Iterator[LabelledBoxes]:
    """PandaSet's frames with their own labels of points, and the cuboids of some of its classes."""
    for path in sorted((folder / "permissive" / "pandaset").glob("*/*.npz")):
        with np.load(path) as file:
            mine = file["device"] == 0
            points, raw = file["xyz"][mine].astype(np.float64), file["label"][mine]
            chosen = np.isin(file["box_class"], classes)
            boxes = [
                FittedBox(center=center.astype(np.float64), size=size.astype(np.float64), yaw=float(yaw))
                for center, size, yaw in zip(
                    file["box_center"][chosen], file["box_size_lwh"][chosen], file["box_yaw"][chosen], strict=True
                )
            ]
        yield LabelledBoxes(points, LABELS[raw], boxes, 2.1)


def recovered(frame: LabelledBoxes, layout: Layout, least_points: int = 100, least_iou: float = 0.5) -> tuple[int, int]:
    """How many cars with `least_points` or more there are, and how many a box of the layout covers well enough."""
    boxes = [
        FittedBox(center=np.array(one.center), size=np.array(one.size), yaw=one.yaw)
        for one in layout
        if one.label in ("car", "truck")
    ]
    counted = [car for car in frame.cars if np.count_nonzero(_within(car, frame.points)) >= least_points]
    return len(counted), sum(max((iou(car, box) for box in boxes), default=0.0) >= least_iou for car in counted)


def iou(a: FittedBox, b: FittedBox) -> float:
    """Intersection over union of two boxes as seen from above, on a grid of 5 cm in the first."""
    if np.linalg.norm(a.center[:2] - b.center[:2]) > 10.0:
        return 0.0
    steps = [np.arange(-size / 2 + 0.025, size / 2, 0.05) for size in a.size[:2]]
    x, y = (axis.ravel() for axis in np.meshgrid(*steps))
    cos, sin = math.cos(a.yaw), math.sin(a.yaw)
    places = np.column_stack([cos * x - sin * y, sin * x + cos * y, np.zeros(len(x))]) + a.center
    both = float(b.contains(places).mean()) * a.size[0] * a.size[1]
    return float(both / (a.size[0] * a.size[1] + b.size[0] * b.size[1] - both))


def _within(box: FittedBox, points: np.ndarray) -> np.ndarray:
    inside: np.ndarray = (np.abs(box.to_local(points)) <= box.size / 2 + _GROWTH).all(axis=1)
    return inside


def _is_ground(points: np.ndarray) -> np.ndarray:
    """Which points [N] lie close over the lowest around them, that below any stray."""
    cells = np.floor(points[:, :2] / _CELL).astype(int)
    _, cell = np.unique(cells, axis=0, return_inverse=True)
    order = np.lexsort((points[:, 2], cell.reshape(-1)))
    count = np.bincount(cell.reshape(-1))
    first = np.concatenate([[0], np.cumsum(count)[:-1]])
    low = points[order[first + count // 50], 2]
    floor = np.minimum(low, np.median(low) + 1.0)[cell.reshape(-1)]
    close: np.ndarray = points[:, 2] < floor + _STANDS
    return close


def _calibration(path: Path) -> np.ndarray:
    """Rigid transform [4, 4] from the rectified camera to the sensor."""
    lines = dict(line.split(":", 1) for line in path.read_text().splitlines() if ":" in line)
    rectified, from_sensor = np.eye(4), np.eye(4)
    rectified[:3, :3] = np.array(lines["R0_rect"].split(), dtype=float).reshape(3, 3)
    from_sensor[:3] = np.array(lines["Tr_velo_to_cam"].split(), dtype=float).reshape(3, 4)
    inverse: np.ndarray = np.linalg.inv(rectified @ from_sensor)
    return inverse


def _from_camera(numbers: np.ndarray, sensor_from_camera: np.ndarray) -> FittedBox:
    """The box of KITTI's height, width, length, bottom centre in the camera's frame, and turn about its y axis."""
    height, width, length = numbers[:3]
    bottom = sensor_from_camera @ np.append(numbers[3:6], 1.0)
    center = bottom[:3] + np.array([0.0, 0.0, height / 2])
    return FittedBox(center=center, size=np.array([length, width, height]), yaw=-float(numbers[6]) - math.pi / 2)
