"""ROS 2 bags, one a drive: clouds on /lidar, boxes on /boxes, transforms on /tf and /tf_static, and /clock.

Frames are `map`, `base_link`, the vehicle on the road, and `lidar`. Transforms and boxes have the time of the middle of
the sweep. So has a cloud without the sensor's own motion; a raw one has the time of its first column, and its `time`
counts from there. A bag is a folder of metadata.yaml and an MCAP file of CDR messages. Its custom data hold the JSON of
the sensor.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from lidardraft.errors import extra
from lidardraft.formats.frame import Annotation, Drives, Frame, timed
from lidardraft.formats.point_cloud2 import cloud_fields
from lidardraft.scene.pose import upright

SENSOR_KEY = "lidardraft_sensor"  # of the custom data
_START = 1_600_000_000_000_000_000  # ns, the first frame's time
# The interfaces of vision_msgs 4 that are written, after its public definitions; rosbags does not include them.
_VISION = {
    "ObjectHypothesis": "string class_id\nfloat64 score",
    "ObjectHypothesisWithPose": "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose",
    "BoundingBox3D": "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size",
    "Detection3D": "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
    "vision_msgs/BoundingBox3D bbox\nstring id",
    "Detection3DArray": "std_msgs/Header header\nvision_msgs/Detection3D[] detections",
}
_TOPICS = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/lidar": "sensor_msgs/msg/PointCloud2",
    "/boxes": "vision_msgs/msg/Detection3DArray",
}


def message_types() -> Any:
    """The typestore of rosbags with vision_msgs and the messages of ROS 2 Humble, which later releases share."""
    with extra():
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in _VISION.items():
        store.register(get_types_from_msg(text, f"vision_msgs/msg/{name}"))
    return store


def write_ros2(folder: Path, drives: Drives, first: int) -> None:
    """Write the bags 000000 and so on, one for each drive. Raises `MissingExtraError` if rosbags is not installed."""
    with extra():
        from rosbags.rosbag2 import StoragePlugin, Writer
    store = message_types()
    for number, drive in enumerate(drives, first):
        with Writer(folder / f"{number:06d}", version=8, storage_plugin=StoragePlugin.MCAP) as bag:
            _write_drive(drive, bag, store)


def _write_drive(drive: Iterable[Frame], bag: Any, store: Any) -> None:
    named = _Messages(store)
    topics = {
        topic: bag.add_connection(topic, kind, typestore=store, offered_qos_profiles=[_quality(topic == "/tf_static")])
        for topic, kind in _TOPICS.items()
    }

    def log(topic: str, at: int, message: Any) -> None:
        bag.write(topics[topic], at, store.serialize_cdr(message, _TOPICS[topic]))

    for time, frame in timed(drive):
        begun = _START + round(1e9 * time)
        at = begun + round(1e9 * frame.sensor.sweep_time / 2)
        if not bag.custom_data:
            bag.set_custom_data(SENSOR_KEY, frame.sensor.to_json())
            log("/tf_static", at, named.transforms(at, "base_link", "lidar", frame.ego_from_sensor()))
        log("/clock", at, named.Clock(clock=named.stamp(at)))
        log("/tf", at, named.transforms(at, "map", "base_link", frame.world_from_ego()))
        log("/lidar", at, named.cloud(at if frame.time is None else begun, frame))
        log("/boxes", at, named.boxes(at, frame.annotations))


def _quality(latched: bool) -> Any:
    """The quality of service of publishers: reliable; static transforms reach late subscribers too."""
    from rosbags import interfaces as of

    durability = of.QosDurability.TRANSIENT_LOCAL if latched else of.QosDurability.VOLATILE
    zero, automatic = of.QosTime(0, 0), of.QosLiveliness.AUTOMATIC
    kept = of.QosHistory.KEEP_LAST, 10, of.QosReliability.RELIABLE, durability
    return of.Qos(*kept, zero, zero, automatic, zero, False)


class _Messages:
    """The messages of a typestore, whose types are attributes by their short names."""

    def __init__(self, store: Any) -> None:
        self._types = {name.rpartition("/")[2]: kind for name, kind in store.types.items()}

    def __getattr__(self, name: str) -> Any:
        return self._types[name]

    def stamp(self, at: int) -> Any:
        return self.Time(sec=at // 10**9, nanosec=at % 10**9)

    def header(self, at: int, frame: str) -> Any:
        return self.Header(stamp=self.stamp(at), frame_id=frame)

    def transforms(self, at: int, parent: str, child: str, pose: np.ndarray) -> Any:
        place, turn = self._placed(self.Vector3, pose)
        moved = self.Transform(translation=place, rotation=turn)
        header = self.header(at, parent)
        return self.TFMessage(transforms=[self.TransformStamped(header=header, child_frame_id=child, transform=moved)])

    def cloud(self, at: int, frame: Frame) -> Any:
        said = cloud_fields(frame)
        fields = [self.PointField(**field) for field in said.pop("fields")]
        data = np.frombuffer(said.pop("data"), np.uint8)
        return self.PointCloud2(header=self.header(at, "lidar"), fields=fields, data=data, **said)

    def boxes(self, at: int, annotations: Iterable[Annotation]) -> Any:
        header = self.header(at, "lidar")
        return self.Detection3DArray(header=header, detections=[self._box(header, each) for each in annotations])

    def _box(self, header: Any, annotation: Annotation) -> Any:
        box = annotation.box
        place, turn = self._placed(self.Point, upright(box.center, box.yaw))
        pose = self.Pose(position=place, orientation=turn)
        guess = self.ObjectHypothesisWithPose(
            hypothesis=self.ObjectHypothesis(class_id=box.label, score=1.0),
            pose=self.PoseWithCovariance(pose=pose, covariance=np.zeros(36)),
        )
        bounds = self.BoundingBox3D(center=pose, size=self.Vector3(*map(float, box.size)))
        return self.Detection3D(header=header, results=[guess], bbox=bounds, id=box.id)

    def _placed(self, point: Any, pose: np.ndarray) -> tuple[Any, Any]:
        from scipy.spatial.transform import Rotation  # slow to import, so not for --help

        turn = Rotation.from_matrix(pose[:3, :3]).as_quat().tolist()
        return point(*pose[:3, 3].tolist()), self.Quaternion(*turn)
