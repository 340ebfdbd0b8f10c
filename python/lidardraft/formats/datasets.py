"""Recorded data sets in their folders: their scans, with the files of labels and boxes.

SemanticKITTI: sequences/NN/velodyne and labels. KITTI's 3D object benchmark: training/velodyne, label_2 and calib.
nuScenes: the tables v1.0-..., samples/LIDAR_TOP and lidarseg. KITTI-360: data_3d_raw, data_3d_bboxes, data_poses and
calibration. PandaSet: NNN/lidar and annotations.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from lidardraft.errors import FormatError, one_of
from lidardraft.formats import kitti360, pandaset
from lidardraft.formats.kitti_object import read_label_2
from lidardraft.formats.nuscenes import labelled_sweeps
from lidardraft.scene.box import Box
from lidardraft.semantics import BY_NAME

SENSORS = {  # presets
    "semantickitti": "hdl64e",
    "kitti": "hdl64e",
    "kitti360": "hdl64e",
    "nuscenes": "hdl32e",
    "pandaset": "pandar64",
}
_SEMANTICKITTI = {"train": ("00", "01", "02", "03", "04", "05", "06", "07", "09", "10"), "val": ("08",)}
_SEMANTICKITTI["all"] = tuple(sorted((*_SEMANTICKITTI["train"], *_SEMANTICKITTI["val"])))
_GROUND = 0.1  # m over the bottom of a box: lower points are road
_SPLITS = {"semantickitti": _SEMANTICKITTI, "kitti360": kitti360.SPLITS}  # of the others: all


@dataclass(frozen=True)
class RecordedFile:
    """A scan, whose labels `read_points` finds, and a function that reads its boxes, if it has any."""

    scan: Path
    boxes: Callable[[], list[Box]] | None = None

    def mark_boxes(self, points: np.ndarray, label: np.ndarray, instance: np.ndarray) -> None:
        """Give the points [N, 3] in boxes, except those on the ground, the class and the instance of the box."""
        for box in self.boxes() if self.boxes else ():
            inside = box.contains(points) & (points[:, 2] > box.center[2] - box.size[2] / 2 + _GROUND)
            label[inside], instance[inside] = BY_NAME[box.label].id, box.instance


def dataset_files(name: str, root: str | os.PathLike[str], split: str = "all") -> list[RecordedFile]:
    """The scans of a split of a data set, in its order.

    Raises `FormatError` for an unknown split, and if the folder holds none of its scans."""
    splits = tuple(_SPLITS.get(name, ("all",)))
    if split not in splits:
        raise FormatError(f"split is {split!r}; of {name} it must be {one_of(splits, split)}")
    place = Path(root)
    if name == "nuscenes":
        pattern = "lidarseg of samples/LIDAR_TOP"
        files = [RecordedFile(scan) for scan, _ in labelled_sweeps(root)]
    elif name == "pandaset":
        pattern = "NNN/lidar/*.pkl.gz"
        files = [RecordedFile(scan, boxes=partial(pandaset.boxes_of, scan)) for scan in pandaset.sweeps_of(root)]
    elif name == "kitti":
        pattern = "training/velodyne/*.bin"
        files = [
            RecordedFile(scan, boxes=partial(read_label_2, _beside(scan, "label_2"), _beside(scan, "calib")))
            for scan in sorted(place.glob(pattern))
        ]
    elif name == "kitti360":
        pattern = "data_3d_raw/DRIVE/velodyne_points/data/*.bin"
        scans = kitti360.scans_of(root, split)
        files = [RecordedFile(scan, boxes=partial(kitti360.boxes_of, root, scan)) for scan in scans]
    else:
        pattern = "sequences/NN/velodyne/*.bin"
        folders = [pattern.replace("NN", number) for number in _SEMANTICKITTI[split]]
        files = [RecordedFile(scan) for folder in folders for scan in sorted(place.glob(folder))]
    if not files:
        raise FormatError(f"{place}: there is no {pattern} of {name}, split {split}")
    return files


def _beside(scan: Path, folder: str) -> Path:
    return scan.parents[1] / folder / f"{scan.stem}.txt"
