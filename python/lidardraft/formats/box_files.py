"""Boxes around the objects of one scan, read from the files of data sets."""

from __future__ import annotations

import math
import os
from pathlib import Path

from lidardraft.errors import FormatError
from lidardraft.files import named, read_text
from lidardraft.formats.boxes import read_boxes
from lidardraft.formats.kitti import numbers_of
from lidardraft.formats.kitti_object import CLASS_OF_NAME, boxes_of_lines, read_label_2
from lidardraft.formats.nuscenes import read_annotations
from lidardraft.formats.pandaset import read_cuboids
from lidardraft.scene.box import Box


def read_box_file(path: str | os.PathLike[str], *, frame: int | None = None) -> list[Box]:
    """The sensor-frame boxes of a file: .boxes.json or the .json of WebDataset, KITTI's label_2 or a `frame` (0) of its
    tracking labels, lines of OpenPCDet or MMDetection3D (.txt), PandaSet's cuboids (.pkl.gz), or, for a sweep
    (.pcd.bin), those of nuScenes' tables.

    Raises `FormatError` naming the file, and `LayoutError` for an invalid box."""
    words = read_text(path).split(maxsplit=3) if Path(path).suffix == ".txt" else []
    is_tracking = len(words) > 2 and words[0][0].isdigit() and words[2][0].isalpha()
    if frame is not None and not is_tracking:
        raise FormatError(f"{os.fspath(path)} has no frames; --frame goes with KITTI's tracking labels (label_02)")
    if Path(path).name.endswith(".pcd.bin"):
        return read_annotations(path)
    if Path(path).name.endswith(".pkl.gz"):
        return read_cuboids(path)
    if Path(path).suffix != ".txt":
        return read_boxes(path)[0]
    if words and words[0][0] in "-+.0123456789" and not is_tracking:
        return read_custom_labels(path)
    return read_label_2(path, frame=frame)


def read_custom_labels(path: str | os.PathLike[str]) -> list[Box]:
    """Boxes of lines `x y z length width height yaw class`. The place is the centre, as in OpenPCDet, or, in labels/
    beside a folder semantic_mask/, the middle of the bottom, as in MMDetection3D. Raises as `read_box_file`."""
    text, is_bottom = read_text(path), (Path(path).absolute().parent.parent / "semantic_mask").is_dir()

    def box(number: int, words: list[str]) -> Box:
        label = CLASS_OF_NAME.get(words[7].lower()) if len(words) == 8 else None
        if label is None:
            raise FormatError(f"{' '.join(words)!r:.80} is not a box: x y z length width height yaw and a class")
        x, y, z, length, width, height, yaw = numbers_of(words[:7], 7)
        if abs(yaw) > math.tau:
            raise FormatError(f"yaw is {yaw:g}; it must be radians, within -2 pi to 2 pi; are these degrees?")
        center = (x, y, z + height / 2 if is_bottom else z)
        return Box(f"{label}_{number}", label, number, center, (length, width, height), yaw)

    with named(path):
        return boxes_of_lines(text, box)
