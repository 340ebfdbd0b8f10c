"""Recorded sweeps with boxes around their objects: KITTI's object frames and PandaSet's.

The boxes of PandaSet may be fitted to; those of KITTI judge.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lidardraft import Box
from lidardraft.formats.kitti import read_bin
from lidardraft.formats.kitti_object import read_label_2
from lidardraft.formats.pandaset import LABELS
from lidardraft.scene.layout import Layout
from lidardraft.scene.pose import in_upright_frame
from lidardraft.semantics import BY_NAME

ROAD, OTHER = BY_NAME["road"].id, BY_NAME["other"].id
_GROWTH = 0.1  # m around an annotated box, of which the points are the object's
_STANDS = 0.25  # m over the lowest return of a cell of 2 m; what is lower is ground
_CELL = 2.0


@dataclass(frozen=True)
class LabelledBoxes:
    """Points [N, 3] in the frame of the sensor, their labels [N], and the boxes around the cars."""

    points: np.ndarray
    labels: np.ndarray
    cars: list[Box]
    sensor_height: float


def kitti_frames(folder: Path) -> Iterator[LabelledBoxes]:
    """KITTI's object frames. They have no labels of points: those in a box get the box's class; of the rest, what is
    close over the lowest return around it is road, and what is higher other."""
    kitti = folder / "kitti"
    for path in sorted([*kitti.glob("object/training/velodyne/*.bin"), *kitti.glob("object_cropped/velodyne/*.bin")]):
        points, _ = read_bin(path)
        points = points.astype(np.float64)
        labels = np.where(_is_ground(points), ROAD, OTHER).astype(np.uint8)
        boxes = read_label_2(path.parents[1] / "label_2" / f"{path.stem}.txt")
        for box in boxes:
            labels[box.contains(points, _GROWTH) & (labels == OTHER)] = BY_NAME[box.label].id
        cars = [box for box in boxes if box.label == "car"]
        yield LabelledBoxes(points, labels, cars, 1.73)


def pandaset_frames(folder: Path, classes: tuple[str, ...] = ("Car",)) -> Iterator[LabelledBoxes]:
    """PandaSet's frames with their own labels of points, and the cuboids of some of its classes."""
    for path in sorted((folder / "permissive" / "pandaset").glob("*/*.npz")):
        with np.load(path) as file:
            mine = file["device"] == 0
            points, raw = file["xyz"][mine].astype(np.float64), file["label"][mine]
            chosen = np.isin(file["box_class"], classes)
            rows = zip(*(file[f"box_{name}"][chosen].tolist() for name in ("center", "size_lwh", "yaw")), strict=True)
            boxes = [
                Box(f"car_{k}", "car", k, tuple(center), tuple(size), yaw) for k, (center, size, yaw) in enumerate(rows)
            ]
        yield LabelledBoxes(points, LABELS[raw], boxes, 2.1)


def recovered(frame: LabelledBoxes, layout: Layout, least_points: int = 100, least_iou: float = 0.5) -> tuple[int, int]:
    """How many cars with `least_points` or more there are, and how many a box of the layout covers well enough."""
    boxes = [box for box in layout.boxes() if box.label in ("car", "truck")]
    counted = [car for car in frame.cars if np.count_nonzero(car.contains(frame.points, _GROWTH)) >= least_points]
    return len(counted), sum(max((iou(car, box) for box in boxes), default=0.0) >= least_iou for car in counted)


def iou(a: Box, b: Box) -> float:
    """Intersection over union of two boxes as seen from above, on a grid of 5 cm in the first."""
    if math.dist(a.center[:2], b.center[:2]) > 10.0:
        return 0.0
    steps = [np.arange(-size / 2 + 0.025, size / 2, 0.05) for size in a.size[:2]]
    x, y = (axis.ravel() for axis in np.meshgrid(*steps))
    cos, sin = math.cos(a.yaw), math.sin(a.yaw)
    places = np.column_stack([cos * x - sin * y, sin * x + cos * y, np.zeros(len(x))]) + a.center
    inside = np.abs(in_upright_frame(places, b.center, b.yaw)[:, :2]) < np.array(b.size[:2]) / 2
    both = float(inside.all(axis=1).mean()) * a.size[0] * a.size[1]
    return both / (a.size[0] * a.size[1] + b.size[0] * b.size[1] - both)


def behind_skin(box: Box, points: np.ndarray) -> np.ndarray:
    """How far behind the nearest side or the roof [m] those of points [N, 3] lie that are in the box."""
    local = in_upright_frame(points, box.center, box.yaw)
    room = np.array(box.size) / 2 - np.column_stack([np.abs(local[:, :2]), local[:, 2]])
    return room.min(axis=1)[(room > 0).all(axis=1) & (local[:, 2] > -box.size[2] / 2)]


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
