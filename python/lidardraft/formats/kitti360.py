"""KITTI-360 (Liao, Xie, Geiger, TPAMI 2022): scans of data_3d_raw, and the boxes of data_3d_bboxes around each.

Boxes are in a world frame, one file a drive; data_poses and calibration hold the pose of the scanner. Moving objects
have a box for each frame. A box is a transform of vertices, which turns and scales them.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import named, read_text
from lidardraft.scene.box import Box
from lidardraft.semantics import BY_NAME

# Drive 0000 has 11,518 of the 81,097 scans of the annotated drives. The paper's 69,580 and 11,517 are these sets except
# for one scan, which it does not name. The other splits are those of LiDM's and LiDARGen's code.
_ALL = ("0000", "0002", "0003", "0004", "0005", "0006", "0007", "0009", "0010")
SPLITS = {
    "train": _ALL[1:],
    "val": ("0000",),
    "lidm-train": ("0000", "0002", "0004", "0005", "0006", "0007", "0008", "0009", "0010"),
    "lidm-val": ("0003",),
    "lidargen-train": ("0003", "0004", "0005", "0006", "0007", "0009", "0010"),
    "lidargen-test": ("0000", "0002"),
    "all": _ALL,
}
_CLASSES = {name: name for name in ("car", "truck", "bus", "train", "motorcycle", "bicycle", "person", "rider", "pole")}
_CLASSES |= {"smallpole": "pole", "bigpole": "pole", "trafficsign": "traffic-sign", "trafficlight": "traffic-light"}
_FAR = 130.0  # m from the scanner


class _Object(NamedTuple):
    name: str
    label: str
    frame: int  # -1 for static objects
    pose: np.ndarray  # world_from_object [4, 4], with axes of length 1
    size: np.ndarray  # along these axes [m]


def scans_of(root: str | os.PathLike[str], split: str) -> list[Path]:
    """The scans of the drives of a split, in their order."""
    folders = [Path(root) / "data_3d_raw" / _drive(number) / "velodyne_points" / "data" for number in SPLITS[split]]
    return [scan for folder in folders for scan in sorted(folder.glob("*.bin"))]


def boxes_of(root: str | os.PathLike[str], scan: Path) -> list[Box]:
    """Boxes of vehicles, people, poles, signs and lights in the frame of a scan. The list is empty if the data set has
    no pose of the scan, or no boxes of its drive. Raises `FormatError`."""
    drive, frame = scan.parents[2].name, int(scan.stem) if scan.stem.isdecimal() else -1
    files = sorted(Path(root).glob(f"data_3d_bboxes/*/{drive}.xml"))
    pose = _poses(Path(root), drive).get(frame) if files else None
    if pose is None:
        return []
    found = []
    for number, one in enumerate(_objects(files[-1]), start=1):  # train_full, if it exists
        if one.frame not in (-1, frame):
            continue
        seen = np.linalg.inv(pose) @ one.pose
        if np.linalg.norm(seen[:3, 3]) > _FAR:
            continue
        up = int(np.argmax(np.abs(seen[2, :3])))
        ahead, aside = sorted({0, 1, 2} - {up}, key=lambda axis: -one.size[axis])
        found.append(
            Box(
                id=one.name,
                label=one.label,
                instance=number * BY_NAME[one.label].is_thing,
                center=tuple(seen[:3, 3].tolist()),
                size=(float(one.size[ahead]), float(one.size[aside]), float(one.size[up])),
                yaw=math.atan2(seen[1, ahead], seen[0, ahead]),
            )
        )
    return found


def _drive(number: str) -> str:
    return f"2013_05_28_drive_{number}_sync"


@lru_cache(maxsize=2)
def _poses(root: Path, drive: str) -> dict[int, np.ndarray]:
    """world_from_velodyne [4, 4] of the frames of a drive with a pose."""
    (velodyne,) = _rows(root / "calibration" / "calib_cam_to_velo.txt", 12)[:1]
    camera_from_velodyne = np.linalg.inv(np.vstack([velodyne.reshape(3, 4), (0, 0, 0, 1)]))
    rows = _rows(root / "data_poses" / drive / "cam0_to_world.txt", 17)
    return {int(row[0]): row[1:].reshape(4, 4) @ camera_from_velodyne for row in rows}


def _rows(path: Path, count: int) -> list[np.ndarray]:
    try:
        rows = [np.array(line.split(), dtype=np.float64) for line in read_text(path).splitlines() if line.strip()]
    except ValueError as error:
        raise FormatError(f"{path}: {error}") from None
    wrong = [number for number, row in enumerate(rows, start=1) if len(row) != count or not np.isfinite(row).all()]
    if wrong or not rows:
        raise FormatError(f"{path}: line {wrong[0] if wrong else 1} must be {count} finite numbers")
    return rows


@lru_cache(maxsize=2)
def _objects(path: Path) -> list[_Object]:
    from defusedxml import DefusedXmlException
    from defusedxml.ElementTree import ParseError, fromstring

    try:
        root = fromstring(read_text(path))
    except (ParseError, DefusedXmlException, ValueError) as error:
        raise FormatError(f"{path}: {str(error) or 'entities are not read'}") from None
    with named(path):
        return list(_objects_in(root))


def _objects_in(root: Element) -> Iterator[_Object]:
    for number, element in enumerate(root, start=1):
        label = _CLASSES.get((element.findtext("label") or "").replace(" ", "").lower())
        if label is None:
            continue
        try:
            transform = np.array((element.findtext("transform/data") or "").split(), float).reshape(4, 4)
            vertices = np.array((element.findtext("vertices/data") or "").split(), float).reshape(-1, 3)
            moves = (element.findtext("dynamic") or "0").strip() not in ("0", "")
            frame = int(element.findtext("timestamp") or -1) if moves else -1
        except ValueError:
            raise FormatError(
                f"object {number} ({label}) has no transform of 16 numbers, or vertices of 3 each"
            ) from None
        lengths = np.linalg.norm(transform[:3, :3], axis=0)
        numbers = np.concatenate([transform, vertices], axis=None)
        if not (np.isfinite(numbers).all() and len(vertices) and lengths.all()):
            raise FormatError(f"object {number} ({label}) has no extent, or numbers that are not finite")
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        pose = np.eye(4)
        pose[:3, :3] = transform[:3, :3] / lengths
        pose[:3, 3] = transform[:3, :3] @ ((low + high) / 2) + transform[:3, 3]
        yield _Object(f"{label}_{number}", label, frame, pose, (high - low) * lengths)
