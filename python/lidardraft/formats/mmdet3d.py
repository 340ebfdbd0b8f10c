"""MMDetection3D's custom data sets: points/*.bin, labels/*.txt, semantic_mask/*.bin, ImageSets/ and infos.

A point is float32 x y z intensity. Boxes are x y z dx dy dz yaw with the middle of the bottom, as
`LiDARInstance3DBoxes` takes them; the yaw is counter-clockwise from x. `lidardraft_infos_train.json` and `_val.json`
are infos of version 2, which `Det3DDataset` and `Seg3DDataset` load unchanged. Masks are int64 class ids.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from lidardraft.files import write_text
from lidardraft.formats.frame import Annotation, Drives, Frame, numbered, write_image_sets
from lidardraft.formats.kitti import write_bin
from lidardraft.semantics import CLASSES

CATEGORIES = tuple(row.name for row in CLASSES if row.is_thing)


def write_mmdet3d(folder: Path, drives: Drives, first: int) -> None:
    """Write a data set; objects without points are left out."""
    for part in ("points", "labels", "semantic_mask"):
        (folder / part).mkdir()
    infos, splits = dict[str, dict[str, Any]](), dict[str, str]()
    for name, frame in numbered(drives, first):
        infos[name], splits[name] = _write_frame(folder, name, frame), frame.split
    write_image_sets(folder, splits)
    for split in sorted({"train", "val", *splits.values()} - {""}):
        names = (folder / "ImageSets" / f"{split}.txt").read_text().split()
        metainfo = {"categories": {name: i for i, name in enumerate(CATEGORIES)}, "dataset": "lidardraft"}
        document = {"metainfo": metainfo, "data_list": [infos[name] for name in names]}
        (folder / f"lidardraft_infos_{split}.json").write_text(json.dumps(document))


def _write_frame(folder: Path, name: str, frame: Frame) -> dict[str, Any]:
    write_bin(folder / "points" / f"{name}.bin", frame.points, frame.intensity)
    (folder / "semantic_mask" / f"{name}.bin").write_bytes(frame.label.astype("<i8").tobytes())
    instances = [(_bottom_box(annotation), annotation) for annotation in frame.seen()]
    lines = [f"{' '.join(f'{number:.4f}' for number in box)} {each.box.label}\n" for box, each in instances]
    write_text(folder / "labels" / f"{name}.txt", "".join(lines))
    return {
        "sample_idx": int(name),
        "lidar_points": {"lidar_path": f"{name}.bin", "num_pts_feats": 4},
        "pts_semantic_mask_path": f"{name}.bin",
        "instances": [
            {
                "bbox_3d": box,
                "bbox_label_3d": CATEGORIES.index(each.box.label),
                "num_lidar_pts": each.num_points,
                "group_id": number,
            }
            for number, (box, each) in enumerate(instances)
        ],
    }


def _bottom_box(annotation: Annotation) -> list[float]:
    x, y, z = annotation.box.center
    return [x, y, z - annotation.box.size[2] / 2, *annotation.box.size, annotation.box.yaw]
