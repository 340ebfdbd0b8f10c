"""Drives go out as ROS 2 bags, and bags come in as recordings with the way of the ego vehicle."""

import math
import runpy
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader, StoragePlugin, Writer

import lidardraft
from lidardraft import Layout, Primitive, Scan, Sensor, SequenceSimulator
from lidardraft.cli.inputs import sensor_of_file
from lidardraft.cli.main import main
from lidardraft.errors import FormatError
from lidardraft.formats.point_cloud2 import cloud_columns, sweep_middle
from lidardraft.formats.recording import frames_in, read_points, read_recording
from lidardraft.formats.ros2 import message_types
from lidardraft.formats.rosbag import ego_scenario
from lidardraft.ros import point_cloud2
from lidardraft.scene.scenario import Scenario, Straight, Waypoints

SENSOR = Sensor(name="few", elevations=tuple(np.deg2rad(np.linspace(2, -24, 8)).tolist()), columns=128)
LAYOUT = Layout((
    Primitive(shape="plane", center=(0, 0, 0), size=(300, 300, 0), label="road", id="road"),
    Primitive(shape="box", center=(9, 6, 0.8), size=(4.4, 1.9, 1.5), yaw=0.5, label="car", id="car_1", instance=1),
))  # fmt: skip
BEND = Waypoints(tuple((t, 8 * t, 1.5 * t * t, 0.375 * t) for t in (0.0, 0.25, 0.5, 0.75, 1.0)))
STORE = message_types()
CLOUD = "sensor_msgs/msg/PointCloud2"


@pytest.fixture(scope="module")
def drive() -> list[Scan]:
    return list(SequenceSimulator(LAYOUT, SENSOR, Scenario(BEND, {"*": Straight(0.0)}), frames=4, hz=5, detail=False))


@pytest.fixture(scope="module")
def bag(drive: list[Scan], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bags") / "out"
    lidardraft.export(drive, "ros2", folder)
    return folder / "000000"


def rewritten(bag: Path, output: Path, change: Callable[[str, Any], list[tuple[str, Any]]], **how: Any) -> Path:
    """The bag with other messages: each becomes those that `change` makes of its topic and itself."""
    with Reader(bag) as reader, Writer(output, version=8, **how) as writer:
        topics: dict[str, Any] = {}
        for connection, time, data in reader.messages(connections=reader.connections):
            for topic, message in change(connection.topic, STORE.deserialize_cdr(data, connection.msgtype)):
                kind = message.__msgtype__
                if topic not in topics:
                    topics[topic] = writer.add_connection(topic, kind, typestore=STORE)
                writer.write(topics[topic], time, STORE.serialize_cdr(message, kind))
    return output


def test_a_bag_is_read_by_rosbags_and_by_mcap_ros2_support(bag: Path, drive: list[Scan]) -> None:
    with AnyReader([bag]) as reader:  # which also compares the hashes of the definitions with those of ROS
        said = [(each.topic, reader.deserialize(data, each.msgtype)) for each, _, data in reader.messages()]
    with (bag / "000000.mcap").open("rb") as file:
        other = list(make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages())
    assert {channel.topic: schema.name for schema, channel, *_ in other} == {
        "/clock": "rosgraph_msgs/msg/Clock", "/tf": "tf2_msgs/msg/TFMessage", "/tf_static": "tf2_msgs/msg/TFMessage",
        "/lidar": CLOUD, "/boxes": "vision_msgs/msg/Detection3DArray",
    }  # fmt: skip
    clouds = [message for topic, message in said if topic == "/lidar"]
    for scan, cloud in zip(drive, clouds, strict=True):
        columns, frame = cloud_columns(cloud), scan.frame(as_seen=True)
        np.testing.assert_array_equal(np.stack([columns[axis] for axis in "xyz"], axis=1), frame.points)
        for name, values in frame.fields().items():
            np.testing.assert_array_equal(columns[name], values)
    boxes = [each[3] for each in other if each[1].topic == "/boxes"]
    for scan, found in zip(drive, boxes, strict=True):
        ((box,), (seen,)) = scan.boxes(), found.detections
        assert (seen.id, seen.results[0].hypothesis.class_id) == ("car_1", "car")
        place, turn = seen.bbox.center.position, seen.bbox.center.orientation
        assert (place.x, place.y, place.z) == pytest.approx(box.center)
        assert 2 * math.atan2(turn.z, turn.w) == pytest.approx(box.yaw)
        assert (seen.bbox.size.x, seen.bbox.size.y, seen.bbox.size.z) == pytest.approx(box.size)


@pytest.mark.parametrize("plugin", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_a_bag_is_a_recording_frame_by_frame(
    bag: Path, drive: list[Scan], plugin: StoragePlugin, tmp_path: Path
) -> None:
    copy = rewritten(bag, tmp_path / "copy", lambda topic, message: [(topic, message)], storage_plugin=plugin)
    (file,) = (each for each in copy.iterdir() if each.suffix != ".yaml")
    for path in (bag, copy, file):
        assert frames_in(path) == 4
        found = read_recording(path, frame=2)
        np.testing.assert_array_equal(found.points, drive[2].image.points())
        np.testing.assert_array_equal(found.label, drive[2].labels())
        np.testing.assert_array_equal(found.intensity, drive[2].intensities())
    with pytest.raises(FormatError, match=r"copy: there is no frame 4; /lidar has 4, from 0 on"):
        read_points(copy, frame=4)
    assert sensor_of_file(bag) == sensor_of_file(bag / "000000.mcap") == SENSOR
    assert sensor_of_file(copy) is None


def test_the_way_of_the_ego_vehicle_is_replayed(bag: Path, drive: list[Scan]) -> None:
    scenario = ego_scenario(bag, frame=1)
    assert scenario is not None
    assert isinstance(scenario.ego, Waypoints)
    rows = np.array(scenario.ego.points)
    seen = [np.linalg.inv(drive[1].pose) @ scan.pose for scan in drive[1:]]
    np.testing.assert_allclose(rows[:, 0], [0.0, 0.2, 0.4], atol=1e-3)
    np.testing.assert_allclose(rows[:, 1:3], [pose[:2, 3] for pose in seen], atol=1e-2)
    np.testing.assert_allclose(rows[:, 3], [math.atan2(pose[1, 0], pose[0, 0]) for pose in seen], atol=1e-3)


def test_odometry_says_the_way_where_no_transform_does(bag: Path, tmp_path: Path) -> None:
    types = {name.rpartition("/")[2]: kind for name, kind in STORE.types.items()}

    def odometry(topic: str, message: Any) -> list[tuple[str, Any]]:
        if topic != "/tf":
            return [] if topic == "/tf_static" else [(topic, message)]
        (moved,) = message.transforms
        place = types["Point"](*(getattr(moved.transform.translation, axis) for axis in "xyz"))
        pose = types["PoseWithCovariance"](types["Pose"](place, moved.transform.rotation), np.zeros(36))
        still = types["Vector3"](0.0, 0.0, 0.0)
        twist = types["TwistWithCovariance"](types["Twist"](still, still), np.zeros(36))
        return [("/odom", types["Odometry"](moved.header, "base_link", pose, twist))]

    changed = rewritten(bag, tmp_path / "odom", odometry, storage_plugin=StoragePlugin.MCAP)
    with pytest.warns(UserWarning, match="nothing says where lidar is on base_link; they are taken for one"):
        found = ego_scenario(changed)
    usual = ego_scenario(bag)
    assert found is not None
    assert usual is not None
    np.testing.assert_allclose(found.ego.points, usual.ego.points, atol=1e-6)  # type: ignore[union-attr]


def test_bags_that_do_not_say_their_points(bag: Path, tmp_path: Path) -> None:
    none = rewritten(
        bag, tmp_path / "none", lambda topic, m: [(topic, m)] * (topic != "/lidar"), storage_plugin=StoragePlugin.MCAP
    )
    with pytest.raises(FormatError, match=rf"none: it holds no points, {CLOUD}; its topics are /boxes \(vision_msgs"):
        read_points(none)
    two = rewritten(
        bag, tmp_path / "two", lambda topic, m: [(topic, m), (f"{topic}2", m)], storage_plugin=StoragePlugin.MCAP
    )
    with pytest.raises(FormatError, match=r"two: it has points on /lidar, /lidar2; choose one with --topic"):
        read_points(two)
    assert len(read_points(two, topic="/lidar2")[0]) == len(read_points(bag)[0])
    with pytest.raises(FormatError, match=r"topic is '/lidr'; it must be one of /lidar, /lidar2; did you mean"):
        read_points(two, topic="/lidr")
    whole = (bag / "000000.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(FormatError, match=r"cut\.mcap: not a whole ROS 2 bag: "):
        read_points(tmp_path / "cut.mcap")
    summary = int.from_bytes(whole[-28:-20], "little")  # where a record begins: a byte of its kind, eight of its length
    (tmp_path / "long.mcap").write_bytes(whole[: summary + 1] + (2**40).to_bytes(8, "little") + whole[summary + 9 :])
    with pytest.raises(FormatError, match=rf"long\.mcap: not a whole ROS 2 bag: .* expected {2**40} bytes, got \d+"):
        read_points(tmp_path / "long.mcap")


def message(columns: dict[str, np.ndarray], big: bool = False, height: int = 1, **changed: Any) -> Any:
    """A PointCloud2 of columns, with four bytes of padding before and behind each point."""
    codes = {"i1": 1, "u1": 2, "i2": 3, "u2": 4, "i4": 5, "u4": 6, "f4": 7, "f8": 8}
    offsets = np.cumsum([4, *(column.itemsize for column in columns.values())]).tolist()
    kinds = [column.dtype.newbyteorder(">" if big else "<") for column in columns.values()]
    layout = {"names": list(columns), "formats": kinds, "offsets": offsets[:-1], "itemsize": offsets[-1] + 4}
    records = np.zeros(len(next(iter(columns.values()))), layout)  # type: ignore[call-overload]
    for name, column in columns.items():
        records[name] = column
    fields = [
        SimpleNamespace(name=name, offset=at, datatype=codes[column.dtype.str[1:]], count=1)
        for (name, column), at in zip(columns.items(), offsets, strict=False)
    ]
    width, step = len(records) // height, offsets[-1] + 4
    size = {"height": height, "width": width, "point_step": step, "row_step": width * step}
    data = np.frombuffer(records.tobytes(), np.uint8)
    return SimpleNamespace(**{**size, "fields": fields, "is_bigendian": big, "data": data} | changed)


@pytest.mark.parametrize("big", [False, True])
def test_clouds_of_any_types_padding_and_order_of_bytes(big: bool) -> None:
    columns = {
        "x": np.array([1.5, np.nan, 3.0]), "y": np.zeros(3, "f4"), "z": np.ones(3, "f4"),
        "intensity": np.array([1, 2, 255], np.uint16), "reflectivity": np.array([1, 2, 255], np.uint8),
        "t": np.array([0, 5, 10], np.uint32),
    }  # fmt: skip
    found = cloud_columns(message(columns, big, height=3))
    assert found.keys() == columns.keys()
    for name, column in columns.items():
        np.testing.assert_array_equal(found[name], column)
        assert found[name].dtype == column.dtype


def test_clouds_that_contradict_themselves() -> None:
    cloud = {axis: np.ones(4, np.float32) for axis in "xyz"}
    good = message(cloud)
    for changed, said in (
        ({"width": 5}, "1 rows of 5 points of 20 bytes, 100 a row, has 80 bytes"),
        ({"width": 0}, "the cloud has no points"),
        ({"point_step": 8}, "the field y goes over the 8 bytes of a point"),
        ({"fields": [good.fields[0]] * 2}, "the field x occurs twice"),
        ({"fields": [SimpleNamespace(name="x", offset=0, datatype=9, count=1)]}, "datatype 9; it must be 1 to 8"),
    ):
        with pytest.raises(FormatError, match=said):
            cloud_columns(message(cloud, **changed))


@pytest.mark.parametrize(
    ("name", "times", "middle"),
    [
        ("time", np.array([0.0, 0.1], "f4"), (0.05, True)),  # s, of Velodyne's driver
        ("t", np.array([0, 100_000_000], "u4"), (0.05, True)),  # ns, of Ouster's
        ("timestamp", np.array([1.6e9, 1.6e9 + 0.1]), (1.6e9 + 0.05, False)),  # s, of Hesai's and RoboSense's
        ("timestamp", np.array([1.6e18, 1.6e18 + 1e8]), (1.6e9 + 0.05, False)),  # ns, of Livox's
        ("time", np.array([0.0, 50.0]), None),  # ms or us: nothing says which
    ],
)
def test_times_of_points_of_the_usual_drivers(name: str, times: np.ndarray, middle: tuple | None) -> None:
    found = sweep_middle({name: times})
    assert (found is None) == (middle is None)
    if found is not None and middle is not None:
        assert found[0] == pytest.approx(middle[0], abs=1e-6)
        assert found[1] == middle[1]


def test_a_live_node_gets_all_fields_without_ros(drive: list[Scan]) -> None:
    node = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "ros_node.py"))
    header = STORE.types["std_msgs/msg/Header"](STORE.types["builtin_interfaces/msg/Time"](1, 0), "lidar")
    types = STORE.types[CLOUD], STORE.types["sensor_msgs/msg/PointField"]
    made = node["message"](drive[1], header, *types)
    made.data = np.frombuffer(made.data, np.uint8)  # rosbags wants numpy's
    found = cloud_columns(STORE.deserialize_cdr(STORE.serialize_cdr(made, CLOUD), CLOUD))
    assert list(found) == ["x", "y", "z", "intensity", "ring", "time", "label", "instance"]
    np.testing.assert_array_equal(found["time"], drive[1].image.times())
    assert "time" not in {field["name"] for field in point_cloud2(drive[1], as_seen=False)["fields"]}
    code = "import sys, lidardraft, lidardraft.ros; assert 'rosbags' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_from_the_command_line_the_points_come_back(
    bag: Path, drive: list[Scan], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["draft", "--points", str(bag), "--frame", "1", "-o", "a.json", "--no-preview"]) == 0
    assert Scenario.load("a.scenario.json").ego == ego_scenario(bag, 1).ego  # type: ignore[union-attr]
    assert main(["view", str(bag), "--frame", "3", "-o", "a.png"]) == 0
    assert main(["edit", str(bag / "000000.mcap"), "--frame", "2", "--insert", "car at -12,3", "-o", "b"]) == 0
    kept, _ = read_points("b.bin")
    recorded = {tuple(row) for row in drive[2].image.points().round(3).tolist()}
    assert sum(tuple(row) in recorded for row in kept.round(3).tolist()) > 0.8 * len(recorded)
    capsys.readouterr()
    assert main(["view", "b.bin", "--frame", "1"]) == 2
    assert "b.bin is one scan; --frame (frame) is for logs, .mcap, .db3, .pcap, .osf" in capsys.readouterr().err
