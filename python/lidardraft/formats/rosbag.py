"""ROS 2 bags as recordings: an .mcap or .db3 file, or a folder with its metadata.yaml, read by rosbags.

Only messages of the types named here are ever decoded.
"""

from __future__ import annotations

import io
import itertools
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lidardraft.errors import FormatError, extra, one_of
from lidardraft.files import expecting, named, regular_size
from lidardraft.formats.ouster import is_ouster_metadata, sensor_of_metadata
from lidardraft.formats.point_cloud2 import cloud_columns, sweep_middle
from lidardraft.formats.ros2 import SENSOR_KEY, message_types
from lidardraft.scene.pose import inverse
from lidardraft.scene.scenario import Scenario, Waypoints
from lidardraft.scene.sensor import Sensor

BAG_ENDINGS = (".mcap", ".db3")
_CLOUD, _TEXT = "sensor_msgs/msg/PointCloud2", "std_msgs/msg/String"
_MOVES, _ODOMETRY = "tf2_msgs/msg/TFMessage", "nav_msgs/msg/Odometry"
_MOST_SHOWN = 12  # topics in a message
_LARGEST = 2**44  # bytes of a bag; only a frame of it is read
_STEP = 0.1  # s between the points of a trajectory


def is_bag(path: str | os.PathLike[str]) -> bool:
    """Whether a path is a bag: a file by its ending, or a folder with metadata.yaml."""
    return Path(path).suffix in BAG_ENDINGS or Path(path, "metadata.yaml").is_file()


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """A message: its `columns` by name, the `rows` of an organised cloud, its frame, and the time [s] of its middle."""

    columns: dict[str, np.ndarray]
    rows: int
    frame: str
    time: float


class _Bag:
    """An open bag."""

    def __init__(self, reader: Any, path: str | os.PathLike[str]) -> None:
        self.reader, self.path, self.types = reader, path, message_types()

    def of_type(self, kind: str) -> list[Any]:
        return [each for each in self.reader.connections if each.msgtype == kind and each.msgcount]

    def messages(self, connections: list[Any]) -> Iterator[tuple[str, Any]]:
        for connection, _, data in self.reader.messages(connections=connections) if connections else ():
            yield connection.topic, self.types.deserialize_cdr(data, connection.msgtype)

    def clouds(self, topic: str | None) -> list[Any]:
        """The connections of the topic of points; of several, the requested one."""
        found = self.of_type(_CLOUD)
        names = sorted({each.topic for each in found})
        if not names:
            held = sorted({f"{each.topic} ({each.msgtype})" for each in self.reader.connections})
            more = f" and {len(held) - _MOST_SHOWN} more" * (len(held) > _MOST_SHOWN)
            listed = f"{', '.join(held[:_MOST_SHOWN])}{more}" if held else "none"
            raise FormatError(f"it holds no points, {_CLOUD}; its topics are {listed}")
        if topic is None and len(names) > 1:
            raise FormatError(f"it has points on {', '.join(names)}; choose one with --topic (topic)")
        if topic is not None and topic not in names:
            raise FormatError(f"topic is {topic!r}; it must be {one_of(names, topic)}")
        return [each for each in found if each.topic == (topic or names[0])]

    def cloud(self, frame: int, topic: str | None) -> Cloud:
        connections = self.clouds(topic)
        message = next(itertools.islice(self.messages(connections), frame, None), None)
        if message is None:
            count = sum(each.msgcount for each in connections)
            raise FormatError(f"there is no frame {frame}; {connections[0].topic} has {count}, from 0 on")
        _, cloud = message
        columns = cloud_columns(cloud)
        stamp, middle = _seconds(cloud.header.stamp), sweep_middle(columns)
        time = stamp if middle is None else middle[0] + stamp * middle[1]
        return Cloud(columns, cloud.height, cloud.header.frame_id.strip("/"), time)


class _File(io.BufferedReader):
    """A file that is never asked for more bytes than it has: a broken length would be allocated first."""

    def read(self, size: int | None = -1, /) -> bytes:
        left = os.fstat(self.fileno()).st_size - self.tell()
        return super().read(left if size is None else min(size, left))


class _Path(type(Path())):  # type: ignore[misc]
    """A path whose bytes, and those of files below it, are read so by rosbags."""

    def open(self, mode: str = "r", *how: Any, **named: Any) -> Any:
        return _File(io.FileIO(self)) if mode == "rb" else super().open(mode, *how, **named)


@contextmanager
def _opened(path: str | os.PathLike[str]) -> Iterator[_Bag]:
    with extra():
        from rosbags.rosbag2 import Reader
    if not Path(path).is_dir():
        regular_size(path, _LARGEST)
    with named(path), expecting("a whole ROS 2 bag"), Reader(_Path(path)) as reader:
        yield _Bag(reader, path)


def read_cloud(path: str | os.PathLike[str], frame: int = 0, topic: str | None = None) -> Cloud:
    """The cloud with a number, from 0, on the only topic of points or the named one. Raises `FormatError` if there is
    none, listing the topics, or if the bag or the message is broken."""
    with _opened(path) as bag:
        return bag.cloud(frame, topic)


def count_clouds(path: str | os.PathLike[str], topic: str | None = None) -> int:
    """The number of clouds on that topic."""
    with _opened(path) as bag:
        return sum(each.msgcount for each in bag.clouds(topic))


def sensor_of_bag(path: str | os.PathLike[str]) -> Sensor | None:
    """The sensor that a bag names, by lidardraft's own key or by the metadata of Ouster's driver; None if it names
    none. An .mcap or .db3 file has that of the metadata.yaml beside it."""
    folder = Path(path) if Path(path).is_dir() else Path(path).parent
    if (folder / "metadata.yaml").is_file():
        with _opened(folder) as bag:
            said = bag.reader.storage.metadata.custom or {}
            if isinstance(said, dict) and SENSOR_KEY in said:
                return Sensor.from_json(said[SENSOR_KEY])
    with _opened(path) as bag:
        texts = (message.data for _, message in bag.messages(bag.of_type(_TEXT)))
        text = next(filter(is_ouster_metadata, itertools.islice(texts, 100)), None)
        return None if text is None else sensor_of_metadata(text)


@dataclass(slots=True, eq=False)
class _Edge:
    """The motion of a frame in its parent: poses x y z and quaternion x y z w, at times [s]; one pose if it is
    static."""

    parent: str
    times: list[float]
    poses: list[list[float]]

    def moves(self) -> bool:
        return len(self.times) > 1 and bool((np.ptp(np.array(self.poses), axis=0) > 1e-6).any())

    def at(self, times: np.ndarray) -> np.ndarray:
        """Poses [N, 4, 4], interpolated between the known ones, and constant beyond the first and the last."""
        from scipy.spatial.transform import Rotation, Slerp  # slow to import, so not for --help

        known, first = np.unique(np.array(self.times), return_index=True)
        rows = np.array(self.poses, np.float64)[first]
        inside = np.clip(times, known[0], known[-1])
        found = np.tile(np.eye(4), (len(times), 1, 1))
        turns = Rotation.from_quat(rows[:, 3:])
        found[:, :3, :3] = (Slerp(known, turns)(inside) if len(known) > 1 else turns).as_matrix()
        found[:, :3, 3] = np.stack([np.interp(inside, known, column) for column in rows[:, :3].T], axis=-1)
        return found


def ego_scenario(path: str | os.PathLike[str], frame: int = 0, topic: str | None = None) -> Scenario | None:
    """The sensor's motion from the middle of a cloud on, as waypoints of the ego vehicle in the frame of that cloud: by
    the transforms of the bag (tf), else by its odometry. None if it has neither, or if the sensor does not move.

    If the sensor's place on the vehicle of the odometry is unknown, the two count as one, with a `UserWarning`."""
    with _opened(path) as bag:
        cloud = bag.cloud(frame, topic)
        edges = _edges(bag)
        chain = _chain(edges, cloud.frame)
        if not any(edge.moves() for edge in chain):
            vehicle = next((child for child, edge in edges.items() if edge.moves()), None)
            odometry = bag.of_type(_ODOMETRY)
            if vehicle is None or not odometry:
                return None
            said = f"nothing says where {cloud.frame or 'the sensor'} is on {vehicle}; they are taken for one"
            warnings.warn(f"{os.fspath(path)}: {said}", stacklevel=2)
            chain = _chain(edges, vehicle)
        known = np.unique(np.concatenate([edge.times for edge in chain if edge.moves()]))
        later = known[known > cloud.time + _STEP / 2]
        kept = later[np.unique(np.round((later - cloud.time) / _STEP), return_index=True)[1]]
        times = np.concatenate([[cloud.time], kept])
        poses = np.tile(np.eye(4), (len(times), 1, 1))
        for edge in chain:
            poses = edge.at(times) @ poses
        seen = inverse(poses[0]) @ poses
        yaw = np.unwrap(np.arctan2(seen[:, 1, 0], seen[:, 0, 0]))
        rows = np.column_stack([times - cloud.time, seen[:, 0, 3], seen[:, 1, 3], yaw])
        return None if len(rows) < 2 else Scenario(Waypoints(tuple(map(tuple, rows.tolist()))))


def _edges(bag: _Bag) -> dict[str, _Edge]:
    """The motion of each frame in its parent; by odometry if no transform gives it."""
    edges = dict[str, _Edge]()
    for _, message in bag.messages(bag.of_type(_MOVES)):
        for each in message.transforms:
            _add(edges, each.header, each.child_frame_id, each.transform.translation, each.transform.rotation)
    by_odometry = dict[str, _Edge]()
    for _, message in bag.messages(bag.of_type(_ODOMETRY)):
        pose = message.pose.pose
        _add(by_odometry, message.header, message.child_frame_id, pose.position, pose.orientation)
    return by_odometry | edges


def _add(edges: dict[str, _Edge], header: Any, child: str, place: Any, turn: Any) -> None:
    edge = edges.setdefault(child.strip("/"), _Edge(header.frame_id.strip("/"), [], []))
    if edge.parent == header.frame_id.strip("/"):
        edge.times.append(_seconds(header.stamp))
        edge.poses.append([place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w])


def _chain(edges: dict[str, _Edge], frame: str) -> list[_Edge]:
    """The edges from a frame up to the root; stops at a cycle."""
    chain, seen = list[_Edge](), set[str]()
    while frame in edges and frame not in seen:
        seen.add(frame)
        chain.append(edges[frame])
        frame = edges[frame].parent
    return chain


def _seconds(stamp: Any) -> float:
    return float(stamp.sec + 1e-9 * stamp.nanosec)
