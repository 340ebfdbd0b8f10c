"""OpenPCDet's custom data sets: points/*.npy, labels/*.txt and ImageSets/, as in its CUSTOM_DATASET_TUTORIAL.

A point is float32 x y z intensity. A line of labels is x y z dx dy dz heading class, with the geometric centre and the
heading counter-clockwise from x. Classes have the package's names, and a rider includes its vehicle.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lidardraft.files import write_text
from lidardraft.formats.frame import Annotation, Drives, npy, numbered, write_image_sets


def write_openpcdet(folder: Path, drives: Drives, first: int) -> None:
    """Write a data set for `CustomDataset`; objects without points are left out."""
    for part in ("points", "labels"):
        (folder / part).mkdir()
    splits = dict[str, str]()
    for name, frame in numbered(drives, first):
        splits[name] = frame.split
        (folder / "points" / f"{name}.npy").write_bytes(npy(np.column_stack([frame.points, frame.intensity])))
        write_text(folder / "labels" / f"{name}.txt", "".join(map(_line, frame.seen())))
    write_image_sets(folder, splits)


def _line(annotation: Annotation) -> str:
    box = annotation.box
    return " ".join(f"{number:.4f}" for number in (*box.center, *box.size, box.yaw)) + f" {box.label}\n"
