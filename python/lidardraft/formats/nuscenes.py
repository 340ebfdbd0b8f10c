"""nuScenes: sweeps, .pcd.bin files of float32 x y z intensity ring (Caesar et al., CVPR 2020), labels of lidarseg (Fong
et al., RA-L 2022), and the tables of v1.0 that relate them.

A sensor has x to the right, y ahead and z up, on a vehicle with x ahead; intensities are 0 to 255, and ring 0 is the
lowest laser. Boxes are in the world, with size width, length, height, and quaternions w x y z. Every written scan is a
key frame; a scene is a drive, or the part of it that shows one world.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import os
from collections.abc import Iterable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import MAX_BYTES, expecting, named, read_bytes, read_text, written_whole
from lidardraft.formats.frame import Annotation, Drives, Frame, by_split, timed
from lidardraft.formats.point_fields import SCALES
from lidardraft.json_fields import parse_list
from lidardraft.scene.box import Box
from lidardraft.scene.pose import inverse, upright
from lidardraft.semantics import BY_NAME, CLASSES

_POINT_BYTES, _SCALE = 20, SCALES[".pcd.bin"]
_MOST_RINGS = 512
VERSION = "v1.0-trainval"
# The categories in the order of lidarseg's numbers, and the class of each.
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
_CLASS = np.array([BY_NAME[name].id for name in CATEGORIES.values()], np.uint8)
_CYCLES = ("bicycle", "motorcycle")
_ATTRIBUTES = ("cycle.with_rider", "cycle.without_rider", "vehicle.moving", "vehicle.stopped", "vehicle.parked",
               "pedestrian.moving", "pedestrian.standing", "pedestrian.sitting_lying_down")  # fmt: skip
_CHILD = 1.4  # m, the limit of a child's height: those of sentences have 1.33 m at most, adults 1.5 m at least
_VISIBLE = (("4", "v80-100", 0.8), ("3", "v60-80", 0.6), ("2", "v40-60", 0.4), ("1", "v0-40", 0.0))
_START = 1_600_000_000_000_000  # us, the first frame's time
_APART = 60_000_000  # us; scenes begin a multiple of this apart
_EGO_FROM_LIDAR = np.array([(0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
_SWEEP = ("filename", "sample_token", "ego_pose_token", "calibrated_sensor_token")

Tables = dict[str, list[dict[str, Any]]]


def read_pcd_bin(path: str | os.PathLike[str], intensity_scale: float = _SCALE) -> tuple[np.ndarray, ...]:
    """Points f32 [N, 3] in metres in the package's sensor frame, intensity f32 [N] in [0, 1], that of the file over
    `intensity_scale`, and ring i64 [N] of the file.

    Raises `FormatError` on a missing, empty or truncated file, a value that is not finite, and an intensity or a ring
    out of range.
    """
    name, data = os.fspath(path), read_bytes(path)
    if not data:
        raise FormatError(f"{name} is empty: a scan without returns")
    if len(data) % _POINT_BYTES:
        raise FormatError(f"{name} has {len(data)} bytes; a nuScenes sweep has {_POINT_BYTES} a point")
    sweep = np.frombuffer(data, dtype="<f4").reshape(-1, 5).astype(np.float32)
    _check(name, sweep, intensity_scale)
    points = np.stack([sweep[:, 1], -sweep[:, 0], sweep[:, 2]], axis=1)
    return points, sweep[:, 3] / np.float32(intensity_scale), sweep[:, 4].astype(np.int64)


def write_pcd_bin(path: str | os.PathLike[str], points: np.ndarray, intensity: np.ndarray, ring: np.ndarray) -> None:
    """Write points [N, 3] in the package's sensor frame, intensity [N] in [0, 1] and nuScenes' ring [N]; the inverse of
    `read_pcd_bin`, with the same limits."""
    right, ahead, up = -points[:, 1], points[:, 0], points[:, 2]
    sweep = np.stack([right, ahead, up, intensity * np.float32(255), ring], axis=1).astype("<f4")
    _check(os.fspath(path), sweep)
    with written_whole(path) as temporary:
        temporary.write_bytes(sweep.tobytes())


def read_lidarseg(path: str | os.PathLike[str], count: int) -> np.ndarray:
    """Class ids u8 [count] of `semantics.CLASSES`; raises `FormatError` if the file does not hold `count` labels.

    Other man-made objects become building, wheelchairs and strollers become person."""
    raw = np.frombuffer(read_bytes(path), dtype=np.uint8)
    if len(raw) != count:
        raise FormatError(f"{os.fspath(path)} has {len(raw)} labels; the sweep has {count} points")
    if raw.max(initial=0) >= len(_CLASS):
        raise FormatError(f"{os.fspath(path)} has class {raw.max()}; lidarseg has 0 to {len(_CLASS) - 1}")
    return _CLASS[raw]


def labelled_sweeps(root: str | os.PathLike[str]) -> list[tuple[Path, Path]]:
    """The key frames of the top LiDAR with labels: sweep and lidarseg file of each, by name.

    `root` is the data set, with one folder of tables such as v1.0-trainval. Raises `FormatError` if it has not.
    """
    tables = table_folder(root)
    labels = {row["sample_data_token"]: row["filename"] for row in read_table(tables / "lidarseg.json",
              ("sample_data_token", "filename"))}  # fmt: skip
    sweeps = read_table(tables / "sample_data.json", ("token", "filename"))
    files = {row["filename"]: labels[row["token"]] for row in sweeps if row["token"] in labels}
    return [(Path(root, sweep), Path(root, files[sweep])) for sweep in sorted(files)]


def lidarseg_of(sweep: str | os.PathLike[str]) -> Path | None:
    """The lidarseg file of a sweep in samples/LIDAR_TOP of a data set with tables; None for any other sweep."""
    path = Path(sweep).absolute()
    root = path.parents[2] if len(path.parents) > 2 else path.parent
    if not any(root.glob("v1.0-*/lidarseg.json")):
        return None
    return _lidarseg_files(root).get(path)


@lru_cache(maxsize=2)
def _lidarseg_files(root: Path) -> dict[Path, Path]:
    return dict(labelled_sweeps(root))


def table_folder(root: str | os.PathLike[str]) -> Path:
    """The folder of tables of a data set; raises `FormatError` unless there is exactly one."""
    folders = [path for path in sorted(Path(root).glob("v1.0-*")) if path.is_dir()]
    if len(folders) != 1:
        raise FormatError(f"{os.fspath(root)} holds {len(folders)} folders of tables, v1.0-...; it must hold one")
    return folders[0]


def read_table(path: Path, fields: tuple[str, ...]) -> list[dict[str, Any]]:
    """The rows of a table, in which all `fields` are texts; tables of the whole data set have a gigabyte. Raises
    `FormatError` naming the invalid row, or one that names a file outside the data set."""
    text = read_text(path, MAX_BYTES)
    with named(path):
        rows = parse_list(text)
        for number, row in enumerate(rows):
            if not isinstance(row, dict) or not all(isinstance(row.get(field), str) for field in fields):
                raise FormatError(f"row {number} has not all of {', '.join(fields)}")
            if "filename" not in fields:
                continue
            if ".." in Path(row["filename"]).parts or Path(row["filename"]).is_absolute():
                raise FormatError(f"row {number} names {row['filename']!r}, which is outside the data set")
        return rows


def _check(name: str, sweep: np.ndarray, scale: float = _SCALE) -> None:
    intensity, ring = sweep[:, 3], sweep[:, 4]
    whole = (ring == np.floor(ring)) & (ring >= 0) & (ring < _MOST_RINGS)
    for right, limit in (
        (np.isfinite(sweep).all(axis=1), "every value must be finite"),
        ((intensity >= 0) & (intensity <= scale), f"the fourth value, intensity, must be 0 to {scale:g}"),
        (whole, f"the fifth value, the ring, must be a whole number from 0 to {_MOST_RINGS - 1}"),
    ):
        if not right.all():
            first = int(np.argmin(right))
            raise FormatError(f"{name}: point {first} is {sweep[first].tolist()}; {limit}")


def write_nuscenes(folder: Path, drives: Drives, first: int) -> None:
    """Write v1.0-trainval/*.json, samples/LIDAR_TOP/, lidarseg/ and maps/; or samples/CHANNEL/ for each channel. Frames
    of one moment are consecutive, in the same order of channels."""
    from PIL import Image  # slow to import, so not for --help

    for part in (VERSION, f"lidarseg/{VERSION}", "maps"):
        (folder / part).mkdir(parents=True)
    Image.new("L", (1, 1)).save(folder / "maps" / "none.png")
    tables, start = _fixed_tables(), _START + _APART * first
    scenes = (scene for drive in drives for _, scene in itertools.groupby(drive, lambda frame: frame.world))
    splits = dict[str, str]()
    for number, scene in enumerate(scenes, first + 1):
        name = f"scene-{number:04d}"
        start, splits[name] = _write_scene(folder, tables, name, scene, start)
    if parts := by_split(splits):
        own = {f"lidardraft_{split}": names for split, names in parts.items()}  # "train" is nuScenes' in its devkit
        (folder / VERSION / "splits.json").write_text(json.dumps(own))  # as nuscenes.utils.splits reads it
    for name, rows in tables.items():
        (folder / VERSION / f"{name}.json").write_text(json.dumps(rows, indent=0))


def read_annotations(sweep: str | os.PathLike[str]) -> list[Box]:
    """The annotated boxes of a sweep samples/LIDAR_TOP/NAME.pcd.bin, in the package's sensor frame, by the tables of
    its data set; those of people are upright.

    Raises `FormatError` if the tables are missing or broken, or lack the sweep."""
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
    """The pose [4, 4] in a row's translation and rotation: the row's frame in its parent."""
    from scipy.spatial.transform import Rotation

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
        "sensor": [],
        "log": [log | {"location": "lidardraft"}],
        "map": [{"token": _token("map"), "log_tokens": [log["token"]], "category": "", "filename": "maps/none.png"}],
        **{name: [] for name in ("instance", "calibrated_sensor", "ego_pose", "scene", "sample", "sample_data")},
        **{name: [] for name in ("sample_annotation", "lidarseg")},
    }


def _write_scene(folder: Path, tables: Tables, name: str, frames: Iterable[Frame], start: int) -> tuple[int, str]:
    """Write a scene that starts at `start`; returns the earliest time of the next one, and the scene's split."""
    samples, tracks = list[dict[str, Any]](), dict[str, list[dict[str, Any]]]()
    sweeps, time, world, split = dict[str, list[dict[str, Any]]](), start, "", ""
    leads, moments = itertools.tee(_moments(frames))
    for number, ((after, lead), moment) in enumerate(zip(timed(each[0] for each in leads), moments, strict=True)):
        time, world, split = start + round(1e6 * after), lead.world, lead.split
        sample = {"token": _token(name, number), "timestamp": time, "scene_token": _token(name)}
        samples.append(sample)
        for frame in moment:
            row = _write_sweep(
                folder, tables, sample, frame, time + round(1e6 * ((frame.start or 0) - (lead.start or 0)))
            )
            sweeps.setdefault(frame.channel, []).append(row)
            for annotation in frame.annotations:
                _annotate(tracks.setdefault(annotation.box.id, []), name, sample, frame, annotation)
    tables["sample"] += _linked(samples)
    said = {"token": _token(name), "log_token": _token("log"), "nbr_samples": len(samples), "name": name}
    ends = {"first_sample_token": samples[0]["token"], "last_sample_token": samples[-1]["token"]}
    tables["scene"].append(said | {"description": _description(world)} | ends)
    tables["sample_data"] += [row for rows in sweeps.values() for row in _linked(rows)]
    for track in tracks.values():
        _set_apart_parked(track)
        tables["instance"].append(
            {"token": track[0]["instance_token"], "category_token": track[0]["category_token"]}
            | {"nbr_annotations": len(track), "first_annotation_token": track[0]["token"]}
            | {"last_annotation_token": track[-1]["token"]}
        )
        tables["sample_annotation"] += _linked(track)
    return time - (time - start) % _APART + _APART, split


def _moments(frames: Iterable[Frame]) -> Iterator[list[Frame]]:
    """The frames of each moment: one for each channel."""
    moment = list[Frame]()
    for frame in frames:
        if moment and frame.channel == moment[0].channel:
            yield moment
            moment = []
        moment.append(frame)
    if moment:
        yield moment


def _description(world: str) -> str:
    """The sentence of a world, or its district, or its source; "" if it has none."""
    said = json.loads(world or "{}")
    told = said.get("provenance", {}) | said.get("intent", {})
    return str(next((told[key] for key in ("sentence", "district", "source") if told.get(key)), ""))


def _set_apart_parked(track: list[dict[str, Any]]) -> None:
    """Mark a vehicle that never moves in a scene as parked; one that drives before or after has stopped."""
    moving, stopped, parked = (_token("attribute", f"vehicle.{how}") for how in ("moving", "stopped", "parked"))
    if not any(moving in row["attribute_tokens"] for row in track):
        for row in track:
            row["attribute_tokens"] = [parked if token == stopped else token for token in row["attribute_tokens"]]


def _write_sweep(folder: Path, tables: Tables, sample: dict[str, Any], frame: Frame, time: int) -> dict[str, Any]:
    """Write a sweep and its labels; returns its row of sample_data."""
    sensor, channel, mount = frame.sensor, frame.channel or "LIDAR_TOP", frame.ego_from_sensor()
    token = _token(sample["token"], frame.channel) if frame.channel else sample["token"]
    sweep, labels = f"samples/{channel}/{token}.pcd.bin", f"lidarseg/{VERSION}/{token}_lidarseg.bin"
    if _token(channel) not in {row["token"] for row in tables["sensor"]}:
        tables["sensor"].append({"token": _token(channel), "channel": channel, "modality": "lidar"})
        (folder / "samples" / channel).mkdir(parents=True)
    write_pcd_bin(folder / sweep, frame.points, frame.intensity, len(sensor.elevations) - 1 - frame.ring.astype(int))
    index = _INDEX[frame.label]
    for annotation in frame.annotations:
        index[annotation.holds(frame.instance)] = list(CATEGORIES).index(_category(annotation))
    (folder / labels).write_bytes(index.tobytes())
    calibrated = _token(sensor.name, *(frame.mount or [sensor.mount_height]), *[frame.channel][: bool(frame.channel)])
    if calibrated not in {row["token"] for row in tables["calibrated_sensor"]}:
        tables["calibrated_sensor"].append(
            {"token": calibrated, "sensor_token": _token(channel), "camera_intrinsic": []}
            | {"translation": mount[:3, 3].tolist(), "rotation": _quaternion(mount[:3, :3] @ _EGO_FROM_LIDAR)}
        )
    ego = frame.world_from_ego()
    tables["ego_pose"].append(
        {"token": token, "timestamp": time, "rotation": _quaternion(ego[:3, :3])} | {"translation": ego[:3, 3].tolist()}
    )
    tables["lidarseg"].append({"token": token, "sample_data_token": token, "filename": labels})
    return (
        {
            "token": token,
            "sample_token": sample["token"],
            "ego_pose_token": token,
            "calibrated_sensor_token": calibrated,
        }
        | {"timestamp": time, "fileformat": "pcd", "is_key_frame": True, "height": 0, "width": 0}
        | {"filename": sweep}
    )


def _annotate(
    track: list[dict[str, Any]], scene: str, sample: dict[str, Any], frame: Frame, annotation: Annotation
) -> None:
    """Add an annotation to a track, or to its row of the same moment from another channel."""
    box = annotation.box
    length, width, height = box.size
    pose = frame.pose @ upright(box.center, box.yaw)
    visibility = next(token for token, _, least in _VISIBLE if 1 - annotation.occlusion >= least)
    if track and track[-1]["sample_token"] == sample["token"]:
        track[-1]["num_lidar_pts"] += annotation.num_points
        track[-1]["visibility_token"] = max(track[-1]["visibility_token"], visibility)
        return
    track.append(
        {"token": _token(sample["token"], box.id), "sample_token": sample["token"]}
        | {"instance_token": _token(scene, box.id), "category_token": _token("category", _category(annotation))}
        | {"attribute_tokens": [_token("attribute", name) for name in _attributes(annotation)]}
        | {"visibility_token": visibility}
        | {"translation": pose[:3, 3].tolist(), "rotation": _quaternion(pose[:3, :3]), "size": [width, length, height]}
        | {"num_lidar_pts": annotation.num_points, "num_radar_pts": 0}
    )


def _category(annotation: Annotation) -> str:
    """The name of its category; a person lying down counts as an adult."""
    length, _, height = annotation.box.size
    if annotation.box.label == "person" and length < height < _CHILD + 2 * annotation.margin:
        return "human.pedestrian.child"
    return CATEGORY_OF_CLASS[annotation.ridden or annotation.box.label]


def _attributes(annotation: Annotation) -> list[str]:
    """The name of its attribute; an empty list if its motion is unknown."""
    kind, moves = _category(annotation).split(".")[:2], annotation.moves()
    if kind[1] in _CYCLES:
        return ["cycle.with_rider" if annotation.box.label == "rider" else "cycle.without_rider"]
    if annotation.box.velocity is None:
        return []
    if kind[0] == "vehicle":
        return ["vehicle.moving" if moves else "vehicle.stopped"]
    lies = annotation.box.size[0] > annotation.box.size[2]
    return ["pedestrian.moving" if moves else "pedestrian.sitting_lying_down" if lies else "pedestrian.standing"]


def _quaternion(rotation: np.ndarray) -> list[float]:
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(rotation).as_quat().tolist()
    return [w, x, y, z]


def _linked(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The rows with the tokens of the previous and next ones."""
    tokens = ["", *(row["token"] for row in rows), ""]
    return [row | {"prev": tokens[i], "next": tokens[i + 2]} for i, row in enumerate(rows)]
