"""Boxes around the objects of one scan, out of the files that data sets have for them."""

from __future__ import annotations

import os
from pathlib import Path

from lidardraft.errors import FormatError
from lidardraft.files import named, read_text
from lidardraft.formats.boxes import read_boxes
from lidardraft.formats.kitti import numbers_of
from lidardraft.formats.kitti_object import CLASS_OF_TYPE, boxes_of_lines, read_label_2
from lidardraft.formats.nuscenes import read_annotations
from lidardraft.formats.pandaset import read_cuboids
from lidardraft.scene.box import Box
from lidardraft.semantics import CLASSES

_CLASS_OF_NAME = {
    **{name.lower(): label for name, label in CLASS_OF_TYPE.items()},
    "vehicle": "car",
    **{row.name: row.name for row in CLASSES if row.id},
}


def read_box_file(path: str | os.PathLike[str]) -> list[Box]:
    """The sensor-frame boxes of a file: .boxes.json or the .json of WebDataset, KITTI's label_2, lines of OpenPCDet or
    MMDetection3D (.txt), PandaSet's cuboids (.pkl.gz), or those of nuScenes' tables for a sweep (.pcd.bin).

    Raises `FormatError` naming the file, and `LayoutError` for a box that cannot be."""
    if Path(path).name.endswith(".pcd.bin"):
        return read_annotations(path)
    if Path(path).name.endswith(".pkl.gz"):
        return read_cuboids(path)
    if Path(path).suffix != ".txt":
        return read_boxes(path)[0]
    first = read_text(path).split(maxsplit=1)
    return read_custom_labels(path) if first and first[0][0] in "-+.0123456789" else read_label_2(path)


def read_custom_labels(path: str | os.PathLike[str]) -> list[Box]:
    """Boxes of lines `x y z length width height yaw class`: of their centres, as OpenPCDet has them, or, in labels/
    beside a folder semantic_mask/, of their bottoms, as MMDetection3D has them. Raises as `read_box_file`."""
    text, is_bottom = read_text(path), (Path(path).absolute().parent.parent / "semantic_mask").is_dir()

    def box(number: int, words: list[str]) -> Box:
        label = _CLASS_OF_NAME.get(words[7].lower()) if len(words) == 8 else None
        if label is None:
            raise FormatError(f"{' '.join(words)!r:.80} is not a box: x y z length width height yaw and a class")
        x, y, z, length, width, height, yaw = numbers_of(words[:7], 7)
        center = (x, y, z + height / 2 if is_bottom else z)
        return Box(f"{label}_{number}", label, number, center, (length, width, height), yaw)

    with named(path):
        return boxes_of_lines(text, box)
