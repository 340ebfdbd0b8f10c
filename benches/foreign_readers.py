"""What other people's readers find in each exported data set: by their library, or by the steps of its loading code.

A reader takes the folder of a data set and gives, frame by frame, what it finds there, in the frame of the sensor.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

FIELDS = ("ring", "time", "label", "instance")  # time of points as the sensor saw them


class Box(NamedTuple):
    """A class by the format's name, the centre [3], length, width and height, and the yaw."""

    name: str
    center: np.ndarray
    size: np.ndarray
    yaw: float


class Found(NamedTuple):
    """Points [N, 4], x y z intensity; boxes, None where the format has none; further columns of the points."""

    points: np.ndarray
    boxes: list[Box] | None
    fields: dict[str, np.ndarray]


def bin_points(path: Path) -> np.ndarray:
    """Of the .bin files that most loaders take."""
    return np.fromfile(path, np.float32).reshape(-1, 4)


def kitti_calibration(folder: Path, name: str) -> tuple[np.ndarray, np.ndarray]:
    """camera_from_lidar [4, 4] and P2 [3, 4]: OpenPCDet and MMDetection3D take lines 2, 4 and 5 of a calibration."""
    lines = (folder / "training/calib" / f"{name}.txt").read_text().splitlines()
    assert [lines[k].split(":")[0] for k in (2, 4, 5)] == ["P2", "R0_rect", "Tr_velo_to_cam"]
    projection, rectified, to_camera = (np.array(lines[k].split()[1:], np.float32) for k in (2, 4, 5))
    camera = np.vstack([rectified.reshape(3, 3) @ to_camera.reshape(3, 4), [0, 0, 0, 1]])
    return camera, projection.reshape(3, 4)


def kitti(folder: Path) -> Iterator[Found]:
    """As both loaders lift boxes from the bottom, in the frame of the camera."""
    for path in sorted((folder / "training/velodyne").glob("*.bin")):
        lidar_from_camera, boxes = np.linalg.inv(kitti_calibration(folder, path.stem)[0]), []
        for line in (folder / "training/label_2" / f"{path.stem}.txt").read_text().splitlines():
            kind, *words = line.split()
            h, w, l, x, y, z, turn = map(float, words[7:])  # noqa: E741
            center = lidar_from_camera @ (x, y - h / 2, z, 1.0)
            boxes.append(Box(kind, center[:3], np.array([l, w, h]), -turn - math.pi / 2))
        yield Found(bin_points(path), boxes, {})


def semantickitti(folder: Path) -> Iterator[Found]:
    """As semantic-kitti-api splits a label's word; its classes are raw."""
    for path in sorted(folder.glob("sequences/*/velodyne/*.bin")):
        words = np.fromfile(path.parents[1] / "labels" / f"{path.stem}.label", np.uint32)
        yield Found(bin_points(path), None, {"raw": words & 0xFFFF, "instance": words >> 16})


def nuscenes(folder: Path) -> Iterator[Found]:
    """As the devkit's `get_sample_data` brings boxes from the world into the frame of the sensor, here x ahead."""
    tables = {
        path.stem: {row["token"]: row for row in json.loads(path.read_text())}
        for path in (folder / "v1.0-trainval").iterdir()
    }
    ours = np.array([(0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
    for sweep in tables["sample_data"].values():
        rows = np.fromfile(folder / sweep["filename"], np.float32).reshape(-1, 5)
        sensor = _pose(tables["calibrated_sensor"][sweep["calibrated_sensor_token"]])
        from_world = np.linalg.inv(_pose(tables["ego_pose"][sweep["ego_pose_token"]]) @ sensor)
        boxes = []
        for row in tables["sample_annotation"].values():
            if row["sample_token"] == sweep["sample_token"]:
                pose = from_world @ _pose(row)
                category = tables["instance"][row["instance_token"]]["category_token"]
                (width, length, height), ahead = row["size"], ours @ pose[:3, 0]
                size, yaw = np.array([length, width, height]), math.atan2(ahead[1], ahead[0])
                boxes.append(Box(tables["category"][category]["name"], ours @ pose[:3, 3], size, yaw))
        points = np.column_stack([rows[:, :3] @ ours.T, rows[:, 3] / 255])
        yield Found(points, boxes, {"from_lowest": rows[:, 4]})


def _pose(row: dict[str, Any]) -> np.ndarray:
    w, *xyz = row["rotation"]
    return _matrix(Rotation.from_quat([*xyz, w]), row["translation"])


def _matrix(turn: Rotation, place: Any) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn.as_matrix(), place
    return pose


def text_boxes(path: Path) -> list[Box]:
    """Lines of x y z length width height yaw and a class."""
    rows = [line.split() for line in path.read_text().splitlines()]
    return [Box(row[7], np.array(row[:3], float), np.array(row[3:6], float), float(row[6])) for row in rows]


def openpcdet(folder: Path) -> Iterator[Found]:
    """As `CustomDataset` of its tutorial: numpy points, and centres as they are."""
    for path in sorted((folder / "points").glob("*.npy")):
        yield Found(np.load(path), text_boxes(folder / "labels" / f"{path.stem}.txt"), {})


def mmdet3d(folder: Path) -> Iterator[Found]:
    """As `Det3DDataset` loads infos, and `LiDARInstance3DBoxes` lifts boxes from the middle of their bottom."""
    infos = [json.loads((folder / f"lidardraft_infos_{part}.json").read_text()) for part in ("train", "val")]
    for info in (row for part in infos for row in part["data_list"]):
        names, boxes = list(infos[0]["metainfo"]["categories"]), []
        for each in info["instances"]:
            x, y, z, *size, yaw = each["bbox_3d"]
            name, center = names[each["bbox_label_3d"]], np.array([x, y, z + size[2] / 2])
            boxes.append(Box(name, center, np.array(size), yaw))
        mask = np.fromfile(folder / "semantic_mask" / info["pts_semantic_mask_path"], np.int64)
        yield Found(bin_points(folder / "points" / info["lidar_points"]["lidar_path"]), boxes, {"label": mask})


def _columns(records: np.ndarray, boxes: list[Box] | None = None) -> Found:
    points = np.stack([records[name] for name in ("x", "y", "z", "intensity")], axis=1)
    names = records.dtype.names or ()
    return Found(points, boxes, {name: np.asarray(records[name]) for name in FIELDS if name in names})


def pcd(folder: Path) -> Iterator[Found]:
    """By pypcd4."""
    from pypcd4 import PointCloud

    for path in sorted(folder.glob("*.pcd")):
        yield _columns(PointCloud.from_path(path).pc_data)


def ply(folder: Path) -> Iterator[Found]:
    """By trimesh."""
    import trimesh

    for path in sorted(folder.glob("*.ply")):
        yield _columns(trimesh.load(path).metadata["_ply_raw"]["vertex"]["data"])


def las(folder: Path) -> Iterator[Found]:
    """By laspy."""
    import laspy

    for path in sorted(folder.glob("*.las")):
        cloud = laspy.read(path)
        points = np.column_stack([cloud.xyz, np.asarray(cloud.intensity) / 65535])
        fields = {name: np.asarray(cloud[name]) for name in ("ring", "label", "instance")}
        fields |= {"time": np.asarray(cloud.gps_time)} if np.any(cloud.gps_time) else {}  # LAS has the field always
        yield Found(points, None, fields | {"classification": np.asarray(cloud.classification)})


def pose_of(place: Any, turn: Any) -> np.ndarray:
    """The matrix [4, 4] of a position and a quaternion."""
    return _matrix(Rotation.from_quat([getattr(turn, axis) for axis in "xyzw"]), [place.x, place.y, place.z])


def ros2(folder: Path) -> Iterator[Found]:
    """By mcap and mcap-ros2-support."""
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    kinds = {2: "u1", 4: "<u2", 6: "<u4", 7: "<f4"}  # of PointField
    for path in sorted(folder.glob("*/*.mcap")):
        with path.open("rb") as file:
            said = list(make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages())
        clouds, found = ([each[3] for each in said if each[1].topic == topic] for topic in ("/lidar", "/boxes"))
        for cloud, detections in zip(clouds, found, strict=True):
            layout = {
                "names": [field.name for field in cloud.fields],
                "formats": [kinds[field.datatype] for field in cloud.fields],
                "offsets": [field.offset for field in cloud.fields],
                "itemsize": cloud.point_step,
            }
            records = np.frombuffer(bytes(cloud.data), np.dtype(layout))  # type: ignore[call-overload]
            boxes = []
            for one in detections.detections:
                pose = pose_of(one.bbox.center.position, one.bbox.center.orientation)
                size = np.array([one.bbox.size.x, one.bbox.size.y, one.bbox.size.z])
                label = one.results[0].hypothesis.class_id
                boxes.append(Box(label, pose[:3, 3], size, math.atan2(pose[1, 0], pose[0, 0])))
            yield _columns(records, boxes)


def webdataset(folder: Path) -> Iterator[Found]:
    """By webdataset."""
    import webdataset as library

    shards = [str(path) for path in sorted(folder.glob("*.tar"))]
    for sample in library.WebDataset(shards, shardshuffle=False, empty_check=False).decode():
        rows = sample["json"]["boxes"]
        boxes = [Box(row["label"], np.array(row["center"]), np.array(row["size"]), row["yaw"]) for row in rows]
        found = {name: sample[f"{name}.npy"] for name in FIELDS if f"{name}.npy" in sample}
        yield Found(sample["points.npy"], boxes, found)


READERS = {
    "kitti": kitti,
    "semantickitti": semantickitti,
    "nuscenes": nuscenes,
    "openpcdet": openpcdet,
    "mmdet3d": mmdet3d,
    "pcd": pcd,
    "ply": ply,
    "las": las,
    "ros2": ros2,
    "webdataset": webdataset,
}
