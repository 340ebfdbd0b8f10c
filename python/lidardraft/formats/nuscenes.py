"""nuScenes: sweeps, .pcd.bin files of float32 x y z intensity ring (Caesar et al., CVPR 2020), labels of lidarseg
(Fong et al., RA-L 2022), and the tables that say which belong together.

Their frame has x to the right, y ahead and z up; intensities are 0 to 255, and ring 0 is the lowest laser.
"""

from __future__ import annotations

import os
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import MAX_BYTES, named, read_bytes, read_text, written_whole
from lidardraft.json_fields import parse_list
from lidardraft.semantics import BY_NAME

_POINT_BYTES = 20
_MOST_RINGS = 512
# The categories in the order of lidarseg's numbers, 0 to 31, and our class of each.
CATEGORIES = {
    "noise": "none",
    "animal": "other",
    "human.pedestrian.adult": "person",
    "human.pedestrian.child": "person",
    "human.pedestrian.construction_worker": "person",
    "human.pedestrian.personal_mobility": "person",
    "human.pedestrian.police_officer": "person",
    "human.pedestrian.stroller": "person",
    "human.pedestrian.wheelchair": "person",
    "movable_object.barrier": "fence",
    "movable_object.debris": "other",
    "movable_object.pushable_pullable": "other",
    "movable_object.trafficcone": "other",
    "static_object.bicycle_rack": "other",
    "vehicle.bicycle": "bicycle",
    "vehicle.bus.bendy": "bus",
    "vehicle.bus.rigid": "bus",
    "vehicle.car": "car",
    "vehicle.construction": "truck",
    "vehicle.emergency.ambulance": "car",
    "vehicle.emergency.police": "car",
    "vehicle.motorcycle": "motorcycle",
    "vehicle.trailer": "truck",
    "vehicle.truck": "truck",
    "flat.driveable_surface": "road",
    "flat.other": "terrain",
    "flat.sidewalk": "sidewalk",
    "flat.terrain": "terrain",
    "static.manmade": "building",
    "static.other": "other",
    "static.vegetation": "vegetation",
    "vehicle.ego": "none",
}
_LIDARSEG = np.array([BY_NAME[name].id for name in CATEGORIES.values()], np.uint8)


def read_pcd_bin(path: str | os.PathLike[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points f32 [N, 3] in metres in our sensor frame, intensity f32 [N] in [0, 1], and ring i64 [N] as it stands.

    Raises `FormatError` on a missing, empty or truncated file, a value that is not finite, and an intensity or a ring
    out of range.
    """
    name, data = os.fspath(path), read_bytes(path)
    if not data or len(data) % _POINT_BYTES:
        raise FormatError(
            f"{name} has {len(data)} bytes; a nuScenes sweep has {_POINT_BYTES} a point, and one at least"
        )
    sweep = np.frombuffer(data, dtype="<f4").reshape(-1, 5).astype(np.float32)
    _check(name, sweep)
    points = np.stack([sweep[:, 1], -sweep[:, 0], sweep[:, 2]], axis=1)
    return points, sweep[:, 3] / np.float32(255), sweep[:, 4].astype(np.int64)


def write_pcd_bin(path: str | os.PathLike[str], points: np.ndarray, intensity: np.ndarray, ring: np.ndarray) -> None:
    """Write points [N, 3] in our sensor frame, intensity [N] in [0, 1] and nuScenes' ring [N]; the inverse of
    `read_pcd_bin`, with the same limits."""
    right, ahead, up = -points[:, 1], points[:, 0], points[:, 2]
    sweep = np.stack([right, ahead, up, intensity * np.float32(255), ring], axis=1).astype("<f4")
    _check(os.fspath(path), sweep)
    with written_whole(path) as temporary:
        temporary.write_bytes(sweep.tobytes())


def read_lidarseg(path: str | os.PathLike[str], count: int) -> np.ndarray:
    """Class ids u8 [count] of `semantics.CLASSES`; raises `FormatError` where the file is not of `count` labels.

    Lost: what is man-made is building, wheelchairs and strollers are persons."""
    raw = np.frombuffer(read_bytes(path), dtype=np.uint8)
    if len(raw) != count:
        raise FormatError(f"{os.fspath(path)} has {len(raw)} labels; the sweep has {count} points")
    if raw.max(initial=0) >= len(_LIDARSEG):
        raise FormatError(f"{os.fspath(path)} has class {raw.max()}; lidarseg has 0 to {len(_LIDARSEG) - 1}")
    labels: np.ndarray = _LIDARSEG[raw]
    return labels


def labelled_sweeps(root: str | os.PathLike[str]) -> list[tuple[Path, Path]]:
    """The key frames of the top LiDAR with labels: sweep and lidarseg file of each, by name.

    `root` is the data set, with one folder of tables as v1.0-trainval. Raises `FormatError` where it is not.
    """
    tables = table_folder(root)
    labels = {row["sample_data_token"]: row["filename"] for row in read_table(tables / "lidarseg.json",
              ("sample_data_token", "filename"))}  # fmt: skip
    sweeps = read_table(tables / "sample_data.json", ("token", "filename"))
    files = {row["filename"]: labels[row["token"]] for row in sweeps if row["token"] in labels}
    return [(Path(root, sweep), Path(root, files[sweep])) for sweep in sorted(files)]


def lidarseg_of(sweep: str | os.PathLike[str]) -> Path | None:
    """The lidarseg file of a sweep in samples/LIDAR_TOP of a data set with its tables; None of any other."""
    path = Path(sweep).absolute()
    root = path.parents[2] if len(path.parents) > 2 else path.parent
    if not any(root.glob("v1.0-*/lidarseg.json")):
        return None
    return _lidarseg_files(root).get(path)


@lru_cache(maxsize=2)
def _lidarseg_files(root: Path) -> dict[Path, Path]:
    return dict(labelled_sweeps(root))


def table_folder(root: str | os.PathLike[str]) -> Path:
    """The folder of tables of a data set; raises `FormatError` where there is not one."""
    folders = [path for path in sorted(Path(root).glob("v1.0-*")) if path.is_dir()]
    if len(folders) != 1:
        raise FormatError(f"{os.fspath(root)} holds {len(folders)} folders of tables, v1.0-...; it must hold one")
    return folders[0]


def read_table(path: Path, fields: tuple[str, ...]) -> list[dict[str, Any]]:
    """The rows of a table, whose `fields` are texts; those of the whole data set have a gigabyte. Raises `FormatError`
    naming the row that is wrong, or that names a file outside the data set."""
    text = read_text(path, MAX_BYTES)
    with named(path):
        rows = parse_list(text)
        for number, row in enumerate(rows):
            if not isinstance(row, dict) or not all(isinstance(row.get(field), str) for field in fields):
                raise FormatError(f"row {number} has not all of {', '.join(fields)}")
            if "filename" not in fields:
                continue
            if ".." in Path(row["filename"]).parts or Path(row["filename"]).is_absolute():
                raise FormatError(f"row {number} names {row['filename']!r}, which lies outside the data set")
        return rows


def _check(name: str, sweep: np.ndarray) -> None:
    intensity, ring = sweep[:, 3], sweep[:, 4]
    whole = (ring == np.floor(ring)) & (ring >= 0) & (ring < _MOST_RINGS)
    for right, limit in (
        (np.isfinite(sweep).all(axis=1), "every value must be finite"),
        ((intensity >= 0) & (intensity <= 255), "the fourth value, intensity, must be 0 to 255"),
        (whole, f"the fifth value, the ring, must be a whole number from 0 to {_MOST_RINGS - 1}"),
    ):
        if not right.all():
            first = int(np.argmin(right))
            raise FormatError(f"{name}: point {first} is {sweep[first].tolist()}; {limit}")
