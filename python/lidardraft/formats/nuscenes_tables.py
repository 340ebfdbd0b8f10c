"""nuScenes: the relational tables of v1.0, LIDAR_TOP sweeps and lidarseg (Caesar et al., CVPR 2020; Fong et al., 2021).

Every scan is a key frame. Its sensor has x to the right and y ahead, on a vehicle with x ahead; boxes are in the world,
of size width, length, height, with quaternions w x y z. A scene is a drive, or the part of it that shows one world.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from scipy.spatial.transform import Rotation

from lidardraft.errors import FormatError
from lidardraft.files import expecting, named, new_folder
from lidardraft.formats.frame import NO_SCANS, Annotation, Drives, Frame, timed
from lidardraft.formats.nuscenes import CATEGORIES, read_table, table_folder, write_pcd_bin
from lidardraft.scene.box import Box
from lidardraft.scene.pose import inverse
from lidardraft.semantics import CLASSES

VERSION = "v1.0-trainval"
CATEGORY_OF_CLASS = {
    "none": "noise",
    "road": "flat.driveable_surface",
    "sidewalk": "flat.sidewalk",
    "terrain": "flat.terrain",
    **dict.fromkeys(("building", "wall", "fence", "pole", "traffic-light", "traffic-sign"), "static.manmade"),
    **dict.fromkeys(("vegetation", "trunk"), "static.vegetation"),
    "person": "human.pedestrian.adult",
    "rider": "vehicle.bicycle",
    "car": "vehicle.car",
    "truck": "vehicle.truck",
    "bus": "vehicle.bus.rigid",
    "train": "vehicle.bus.bendy",
    "motorcycle": "vehicle.motorcycle",
    "bicycle": "vehicle.bicycle",
    "other": "static.other",
}
_INDEX = np.array([list(CATEGORIES).index(CATEGORY_OF_CLASS[row.name]) for row in CLASSES], np.uint8)
_CYCLES = ("bicycle", "motorcycle")
_ATTRIBUTES = ("cycle.with_rider", "cycle.without_rider")
_VISIBLE = (("4", "v80-100", 0.8), ("3", "v60-80", 0.6), ("2", "v40-60", 0.4), ("1", "v0-40", 0.0))
_START = 1_600_000_000_000_000  # us, the first frame's time
_EGO_FROM_LIDAR = np.array([(0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)])

_SWEEP = ("filename", "sample_token", "ego_pose_token", "calibrated_sensor_token")

Tables = dict[str, list[dict[str, Any]]]


def write_nuscenes(output: str | os.PathLike[str], drives: Drives) -> None:
    """Write v1.0-trainval/*.json, samples/LIDAR_TOP/, lidarseg/ and maps/.

    Raises `FormatError` where `output` is there already or cannot be written.
    """
    with new_folder(output) as folder:
        for part in (VERSION, "samples/LIDAR_TOP", f"lidarseg/{VERSION}", "maps"):
            (folder / part).mkdir(parents=True)
        Image.new("L", (1, 1)).save(folder / "maps" / "none.png")
        tables, number = _fixed_tables(), 0
        scenes = (scene for drive in drives for _, scene in itertools.groupby(drive, lambda frame: frame.world))
        for number, scene in enumerate(scenes, start=1):
            _write_scene(folder, tables, f"scene-{number:04d}", scene)
        if not number:
            raise FormatError(NO_SCANS)
        for name, rows in tables.items():
            (folder / VERSION / f"{name}.json").write_text(json.dumps(rows, indent=0))


def read_annotations(sweep: str | os.PathLike[str]) -> list[Box]:
    """The boxes around what is annotated in a sweep samples/LIDAR_TOP/NAME.pcd.bin, in our sensor frame, by the tables
    of its data set; those of people are upright.

    Raises `FormatError` where the tables are missing or broken, or do not have the sweep."""
    path = Path(sweep).absolute()
    tables = table_folder(path.parents[2])
    name = "/".join(path.parts[-3:])
    data = next((row for row in read_table(tables / "sample_data.json", _SWEEP) if row["filename"] == name), None)
    if data is None:
        raise FormatError(f"{os.fspath(sweep)}: sample_data.json has no sweep {name}")
    ego = _pose(tables / "ego_pose.json", data["ego_pose_token"])
    sensor = _pose(tables / "calibrated_sensor.json", data["calibrated_sensor_token"])
    theirs_from_ours = np.eye(4)
    theirs_from_ours[:3, :3] = _EGO_FROM_LIDAR.T
    ours_from_world = inverse(ego @ sensor @ theirs_from_ours)
    labels = CATEGORIES | {"human.pedestrian.stroller": "other"}
    instances, categories, attributes = (
        {row["token"]: row for row in read_table(tables / f"{name}.json", ("token",))}
        for name in ("instance", "category", "attribute")
    )
    boxes = list[Box]()
    with named(tables / "sample_annotation.json"), expecting("annotations of nuScenes"):
        for row in read_table(tables / "sample_annotation.json", ("token", "sample_token", "instance_token")):
            if row["sample_token"] != data["sample_token"]:
                continue
            label = labels.get(categories[instances[row["instance_token"]]["category_token"]]["name"], "other")
            if any(attributes[token]["name"] == "cycle.with_rider" for token in row["attribute_tokens"]):
                label = "rider"
            pose = ours_from_world @ _pose_of(row)
            width, length, height = row["size"]
            yaw, number = math.atan2(pose[1, 0], pose[0, 0]), len(boxes) + 1
            boxes.append(Box(f"{label}_{number}", label, number, pose[:3, 3].tolist(), (length, width, height), yaw))
    return boxes


def _pose(path: Path, token: str) -> np.ndarray:
    with named(path), expecting("poses of nuScenes"):
        return _pose_of(next(row for row in read_table(path, ("token",)) if row["token"] == token))


def _pose_of(row: dict[str, Any]) -> np.ndarray:
    """world_from_it [4, 4] of a row's translation and rotation."""
    pose = np.eye(4)
    w, x, y, z = row["rotation"]
    pose[:3, :3] = Rotation.from_quat([x, y, z, w]).as_matrix()
    pose[:3, 3] = row["translation"]
    return pose


def _token(*parts: object) -> str:
    return hashlib.md5("/".join(map(str, parts)).encode(), usedforsecurity=False).hexdigest()


def _fixed_tables() -> Tables:
    log = {"token": _token("log"), "logfile": "", "vehicle": "lidardraft", "date_captured": "2020-09-13"}
    return {
        "category": [
            {"token": _token("category", name), "name": name, "description": "", "index": index}
            for index, name in enumerate(CATEGORIES)
        ],
        "attribute": [{"token": _token("attribute", name), "name": name, "description": ""} for name in _ATTRIBUTES],
        "visibility": [{"token": token, "level": level, "description": ""} for token, level, _ in _VISIBLE],
        "sensor": [{"token": _token("LIDAR_TOP"), "channel": "LIDAR_TOP", "modality": "lidar"}],
        "log": [log | {"location": "lidardraft"}],
        "map": [
            {"token": _token("map"), "log_tokens": [log["token"]], "category": "", "filename": "maps/none.png"},
        ],
        **{name: [] for name in ("instance", "calibrated_sensor", "ego_pose", "scene", "sample", "sample_data")},
        **{name: [] for name in ("sample_annotation", "lidarseg")},
    }


def _write_scene(folder: Path, tables: Tables, name: str, frames: Iterable[Frame]) -> None:
    samples, tracks = list[dict[str, Any]](), dict[str, list[dict[str, Any]]]()
    begun = _START + 60_000_000 * len(tables["scene"])
    for number, (after, frame) in enumerate(timed(frames)):
        time = begun + round(1e6 * after)
        sample = {"token": _token(name, number), "timestamp": time, "scene_token": _token(name)}
        samples.append(sample)
        _write_sweep(folder, tables, sample, frame)
        for annotation in frame.annotations:
            _annotate(tracks.setdefault(annotation.box.id, []), name, sample, frame, annotation)
    tables["sample"] += _linked(samples)
    tables["scene"].append(
        {
            "token": _token(name),
            "log_token": _token("log"),
            "nbr_samples": len(samples),
            "name": name,
            "description": "",
        }
        | {"first_sample_token": samples[0]["token"], "last_sample_token": samples[-1]["token"]}
    )
    sweeps = tables["sample_data"][-len(samples) :]
    tables["sample_data"][-len(samples) :] = _linked(sweeps)
    for track in tracks.values():
        tables["instance"].append(
            {"token": track[0]["instance_token"], "category_token": track[0]["category_token"]}
            | {"nbr_annotations": len(track), "first_annotation_token": track[0]["token"]}
            | {"last_annotation_token": track[-1]["token"]}
        )
        tables["sample_annotation"] += _linked(track)


def _write_sweep(folder: Path, tables: Tables, sample: dict[str, Any], frame: Frame) -> None:
    token, sensor = sample["token"], frame.sensor
    sweep, labels = f"samples/LIDAR_TOP/{token}.pcd.bin", f"lidarseg/{VERSION}/{token}_lidarseg.bin"
    write_pcd_bin(folder / sweep, frame.points, frame.intensity, len(sensor.elevations) - 1 - frame.ring.astype(int))
    (folder / labels).write_bytes(_INDEX[frame.label].tobytes())
    calibrated = _token(sensor.name, sensor.mount_height)
    if calibrated not in {row["token"] for row in tables["calibrated_sensor"]}:
        tables["calibrated_sensor"].append(
            {"token": calibrated, "sensor_token": _token("LIDAR_TOP"), "camera_intrinsic": []}
            | {"translation": [0.0, 0.0, sensor.mount_height], "rotation": _quaternion(_EGO_FROM_LIDAR)}
        )
    ego = frame.world_from_ego()
    tables["ego_pose"].append(
        {"token": token, "timestamp": sample["timestamp"], "rotation": _quaternion(ego[:3, :3])}
        | {"translation": ego[:3, 3].tolist()}
    )
    tables["sample_data"].append(
        {"token": token, "sample_token": token, "ego_pose_token": token, "calibrated_sensor_token": calibrated}
        | {"timestamp": sample["timestamp"], "fileformat": "pcd", "is_key_frame": True, "height": 0, "width": 0}
        | {"filename": sweep}
    )
    tables["lidarseg"].append({"token": token, "sample_data_token": token, "filename": labels})


def _annotate(
    track: list[dict[str, Any]], scene: str, sample: dict[str, Any], frame: Frame, annotation: Annotation
) -> None:
    box, label = annotation.box, annotation.ridden or annotation.box.label
    length, width, height = box.size
    turn = frame.pose[:3, :3] @ Rotation.from_euler("z", box.yaw).as_matrix()
    attributes = [("cycle.with_rider" if annotation.ridden else "cycle.without_rider")] if label in _CYCLES else []
    track.append(
        {"token": _token(sample["token"], box.id), "sample_token": sample["token"]}
        | {"instance_token": _token(scene, box.id), "category_token": _token("category", CATEGORY_OF_CLASS[label])}
        | {"attribute_tokens": [_token("attribute", name) for name in attributes]}
        | {"visibility_token": next(token for token, _, least in _VISIBLE if 1 - annotation.occlusion >= least)}
        | {"translation": (frame.pose[:3, :3] @ box.center + frame.pose[:3, 3]).tolist()}
        | {"size": [width, length, height], "rotation": _quaternion(turn)}
        | {"num_lidar_pts": annotation.num_points, "num_radar_pts": 0}
    )


def _quaternion(rotation: np.ndarray) -> list[float]:
    x, y, z, w = Rotation.from_matrix(rotation).as_quat().tolist()
    return [w, x, y, z]


def _linked(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The rows with the tokens of those before and after each."""
    tokens = ["", *(row["token"] for row in rows), ""]
    return [row | {"prev": tokens[i], "next": tokens[i + 2]} for i, row in enumerate(rows)]
