"""MCAP files with Foxglove's messages: clouds on /lidar, boxes on /boxes, transforms on /tf.

Frames are `map`, `base_link`, the vehicle on the road, and `lidar`. A file is a drive. Transforms and boxes have the
time of the middle of the sweep. So has a cloud without the sensor's own motion; a raw one has the time of its first
column, and its `time` counts from there.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from lidardraft.errors import FormatError, extra
from lidardraft.formats.frame import Annotation, Drives, Frame, point_records, timed
from lidardraft.scene.pose import upright
from lidardraft.semantics import BY_NAME

START = 1_600_000_000_000_000_000  # ns, the first frame's time
_TYPES = {"f4": "Float32", "u1": "Uint8", "u2": "Uint16", "u4": "Uint32"}


def write_mcap(folder: Path, drives: Drives, first: int) -> None:
    """Write 000000.mcap and so on, one for each drive. Raises `MissingExtraError` if foxglove-sdk is not installed."""
    with extra():
        import foxglove
    logging.getLogger("foxglove").addHandler(logging.NullHandler())  # the error below reports its warnings
    for number, drive in enumerate(drives, first):
        context = foxglove.Context()
        try:
            with foxglove.open_mcap(folder / f"{number:06d}.mcap", context=context):
                _log_drive(drive, context)
        except RuntimeError as error:
            raise FormatError(f"{folder} cannot be written, as on a full disk: {error}") from None


def _log_drive(drive: Iterable[Frame], context: Any) -> None:
    from foxglove import channels
    from foxglove.messages import FrameTransforms

    clouds = channels.PointCloudChannel("/lidar", context=context)
    boxes = channels.SceneUpdateChannel("/boxes", context=context)
    transforms = channels.FrameTransformsChannel("/tf", context=context)
    for time, frame in timed(drive):
        begun = START + round(1e9 * time)
        at = begun + round(1e9 * frame.sensor.sweep_time / 2)
        poses = (("map", "base_link", frame.world_from_ego()), ("base_link", "lidar", frame.ego_from_sensor()))
        transforms.log(FrameTransforms(transforms=[_transform(at, *pose) for pose in poses]), log_time=at)
        clouds.log(_cloud(at if frame.time is None else begun, frame), log_time=at)
        boxes.log(_scene(at, frame), log_time=at)


def _cloud(at: int, frame: Frame) -> Any:
    from foxglove.messages import PackedElementField, PackedElementFieldNumericType, PointCloud

    records = point_records(frame)
    fields = [
        PackedElementField(name=name, offset=offset, type=getattr(PackedElementFieldNumericType, _TYPES[kind.str[1:]]))
        for name, (kind, offset, *_) in (records.dtype.fields or {}).items()
    ]
    return PointCloud(
        timestamp=_stamp(at),
        frame_id="lidar",
        pose=_pose(np.eye(4)),
        point_stride=records.dtype.itemsize,
        fields=fields,
        data=records.tobytes(),
    )


def _scene(at: int, frame: Frame) -> Any:
    from foxglove.messages import SceneEntityDeletion, SceneEntityDeletionType, SceneUpdate

    gone = SceneEntityDeletion(timestamp=_stamp(at), type=SceneEntityDeletionType.All)
    return SceneUpdate(deletions=[gone], entities=[_entity(at, annotation) for annotation in frame.annotations])


def _entity(at: int, annotation: Annotation) -> Any:
    from foxglove.messages import Color, CubePrimitive, KeyValuePair, SceneEntity, Vector3

    box = annotation.box
    red, green, blue = (value / 255 for value in BY_NAME[box.label].colour)
    length, width, height = box.size
    pose, size = _pose(upright(box.center, box.yaw)), Vector3(x=length, y=width, z=height)
    words = {"label": box.label, "num_points": str(annotation.num_points)}
    if box.velocity is not None:
        words["velocity"] = " ".join(f"{speed:.3f}" for speed in box.velocity)
    return SceneEntity(
        timestamp=_stamp(at),
        frame_id="lidar",
        id=box.id,
        metadata=[KeyValuePair(key=key, value=value) for key, value in words.items()],
        cubes=[CubePrimitive(pose=pose, size=size, color=Color(r=red, g=green, b=blue, a=0.5))],
    )


def _transform(at: int, parent: str, child: str, pose: np.ndarray) -> Any:
    from foxglove.messages import FrameTransform

    place, turn = _place_and_turn(pose)
    frames = {"parent_frame_id": parent, "child_frame_id": child}
    return FrameTransform(timestamp=_stamp(at), **frames, translation=place, rotation=turn)


def _pose(pose: np.ndarray) -> Any:
    from foxglove.messages import Pose

    place, turn = _place_and_turn(pose)
    return Pose(position=place, orientation=turn)


def _place_and_turn(pose: np.ndarray) -> tuple[Any, Any]:
    from foxglove.messages import Quaternion, Vector3
    from scipy.spatial.transform import Rotation  # slow to import, so not for --help

    x, y, z, w = Rotation.from_matrix(pose[:3, :3]).as_quat().tolist()
    return Vector3(**dict(zip("xyz", pose[:3, 3].tolist(), strict=True))), Quaternion(x=x, y=y, z=z, w=w)


def _stamp(at: int) -> Any:
    from foxglove.messages import Timestamp

    return Timestamp(sec=at // 10**9, nsec=at % 10**9)
