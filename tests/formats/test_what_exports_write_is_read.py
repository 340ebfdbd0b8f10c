"""Our readers take what `export` writes, and what people bring: points, classes and boxes in the same places."""

import json
import math
import os
import tarfile
from pathlib import Path

import laspy
import numpy as np
import pytest

from lidardraft import Layout, Primitive, Sensor, simulate
from lidardraft.cli.arguments import read_sensor
from lidardraft.errors import FormatError
from lidardraft.formats.box_files import read_box_file
from lidardraft.formats.frame import Frame, writer_of
from lidardraft.formats.ouster import read_ouster_metadata
from lidardraft.formats.recording import read_labels, read_points
from lidardraft.scene.sensor import PRESETS
from lidardraft.semantics import BY_NAME

SENSOR = Sensor(name="few", elevations=tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist()), columns=256)
LAYOUT = Layout((
    Primitive(shape="plane", center=(0, 0, 0), size=(90, 90, 0), label="road", id="road"),
    Primitive(shape="box", center=(9, 4, 0.8), size=(4.4, 1.9, 1.5), yaw=0.5, label="car", id="car_1", instance=1),
    Primitive(shape="box", center=(-7, 2, 1.6), size=(8, 2.5, 3.2), yaw=-2, label="truck", id="truck_1", instance=2),
    Primitive(shape="box", center=(5, -3, 0.9), size=(0.6, 0.6, 1.7), label="person", id="person_1", instance=3),
))  # fmt: skip


@pytest.fixture(scope="module")
def frame() -> Frame:
    return simulate(LAYOUT, SENSOR, pose=SENSOR.pose(x=1.0, yaw=0.3), seed=1).frame()


def _untarred(folder: Path) -> Path:
    with tarfile.open(folder / "000000.tar") as tar:
        tar.extractall(folder, filter="data")
    return folder


# The file of points, and that of boxes, with whether it has the classes too.
WRITTEN = {
    "kitti": ("training/velodyne/000000.bin", "training/label_2/000000.txt", False),
    "semantickitti": ("sequences/00/velodyne/000000.bin", None, True),
    "nuscenes": ("samples/LIDAR_TOP/*.pcd.bin", "samples/LIDAR_TOP/*.pcd.bin", True),
    "openpcdet": ("points/000000.npy", "labels/000000.txt", False),
    "mmdet3d": ("points/000000.bin", "labels/000000.txt", True),
    "pcd": ("000000.pcd", None, True),
    "ply": ("000000.ply", None, True),
    "las": ("000000.las", None, True),
    "webdataset": ("000000.points.npy", "000000.json", True),
}


@pytest.mark.parametrize("name", WRITTEN)
def test_what_is_written_is_read(name: str, frame: Frame, tmp_path: Path) -> None:
    scan, boxes, has_classes = WRITTEN[name]
    writer_of(name)(tmp_path / "set", [[frame]])
    if name == "webdataset":
        _untarred(tmp_path / "set")
    (path,) = (tmp_path / "set").glob(scan)
    points, fields = read_points(path)
    assert np.allclose(points, frame.points, atol=1e-3)
    assert np.allclose(fields["intensity"], frame.intensity, atol=1 / 255)
    assert ("label" in fields) == has_classes
    if has_classes:
        same = fields["label"] == frame.label
        assert same.all() or name == "semantickitti"
    if boxes is not None:
        (file,) = (tmp_path / "set").glob(boxes)
        found = read_box_file(file)
        assert len(found) == 3
        for box, annotation in zip(found, frame.annotations, strict=True):
            assert box.label == annotation.box.label
            assert np.allclose(box.center, annotation.box.center, atol=1e-3)
            assert np.allclose(box.size, annotation.box.size, atol=1e-3)
            assert math.remainder(box.yaw - annotation.box.yaw, math.tau) == pytest.approx(0, abs=1e-3)


def test_labels_are_told_apart_by_their_size(frame: Frame, tmp_path: Path) -> None:
    count = len(frame.label)
    (tmp_path / "masks.bin").write_bytes(frame.label.astype("<i8").tobytes())
    (tmp_path / "lidarseg.bin").write_bytes(np.full(count, 17, np.uint8).tobytes())
    assert np.array_equal(read_labels(tmp_path / "masks.bin", count, of="a")["label"], frame.label)
    assert set(read_labels(tmp_path / "lidarseg.bin", count, of="a")["label"]) == {BY_NAME["car"].id}
    (tmp_path / "masks.bin").write_bytes(np.full(count, 99, "<i8").tobytes())
    with pytest.raises(FormatError, match=r"masks\.bin has class 99; it must be 0 to 20"):
        read_labels(tmp_path / "masks.bin", count, of="a")


def test_las_files_of_others(tmp_path: Path) -> None:
    points = laspy.LasData(laspy.LasHeader(point_format=3, version="1.2"))
    points.xyz = [(1.0, 2.0, 3.0), (4.0, 5.0, 6.0), (7.0, 8.0, 9.0)]
    points.classification = [2, 6, 9]
    points.intensity = [0, 128, 255]
    points.write(tmp_path / "city.las")
    with pytest.warns(UserWarning, match=r"by 65535, but the largest is 255: give --intensity-scale 255 if that"):
        assert read_points(tmp_path / "city.las")[1]["intensity"].tolist() == pytest.approx(
            [0, 128 / 65535, 255 / 65535]
        )
    found, fields = read_points(tmp_path / "city.las", intensity_scale=255)
    assert np.allclose(found, points.xyz)
    assert fields["label"].tolist() == [BY_NAME["terrain"].id, BY_NAME["building"].id, 0]
    assert fields["intensity"].tolist() == pytest.approx([0, 128 / 255, 1])
    assert "ring" not in fields


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("1 2 3 4 5 6 car", "line 1: '1 2 3 4 5 6 car' is not a box: x y z length width height yaw and a class"),
        ("1 2 3 4 5 6 7 Boat", "line 1: '1 2 3 4 5 6 7 Boat' is not a box"),
        ("1 2 3 4 5 x 7 car", "line 1: '1 2 3 4 5 x 7' is not 7 finite numbers"),
        ("1 2 3 4 5 6 nan car", "line 1: '1 2 3 4 5 6 nan' is not 7 finite numbers"),
        ("1 2 3 4 -5 6 0.7 car", "line 1: car_1: size is [4.0, -5.0, 6.0]; no extent may be negative"),
    ],
)
def test_lines_that_are_no_boxes(tmp_path: Path, line: str, message: str) -> None:
    (tmp_path / "labels.txt").write_text(line)
    with pytest.raises(Exception, match=r"labels\.txt: ") as error:
        read_box_file(tmp_path / "labels.txt")
    assert message in str(error.value)


METADATA = {
    "beam_altitude_angles": [1.0, 0.0, -1.0],
    "beam_azimuth_angles": [3.0, 1.0, -3.0],
    "lidar_origin_to_beam_origin_mm": 15.8,
    "lidar_mode": "1024x20",
    "prod_line": "OS-1-64-U02",
}
FORMAT = {"columns_per_frame": 1024, "column_window": [256, 767]}


@pytest.mark.parametrize("nested", [False, True])
def test_metadata_of_ouster_is_a_sensor(tmp_path: Path, nested: bool) -> None:
    document = {**METADATA, "data_format": FORMAT}
    if nested:  # as firmware 3 has it
        groups = {"beam_intrinsics": ("beam_altitude_angles", "beam_azimuth_angles", "lidar_origin_to_beam_origin_mm")}
        groups |= {"sensor_info": ("prod_line",), "config_params": ("lidar_mode",)}
        document = {group: {name: METADATA[name] for name in names} for group, names in groups.items()}
        document["lidar_data_format"] = FORMAT
    (tmp_path / "os1.json").write_text(json.dumps(document))
    sensor = read_sensor(str(tmp_path / "os1.json"))
    assert (sensor.name, sensor.shape) == ("os-1-64-u02", (3, 512))
    assert np.rad2deg(sensor.elevations) == pytest.approx([1, 0, -1])
    assert np.rad2deg(sensor.azimuth_offsets) == pytest.approx([-3, -1, 3])
    assert sensor.origin_forwards == (0.0158,) * 3
    assert (sensor.azimuth_start, sensor.azimuth_span) == pytest.approx((math.pi / 2 + math.pi / 1024, math.pi))
    assert sensor.sweep_time == pytest.approx(0.025)
    assert sensor.max_range == PRESETS["os1-128"].max_range


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"beam_azimuth_angles": [1.0]}, "must be lists of degrees, one for each beam"),
        ({"lidar_mode": "fast"}, "name no mode such as 1024x10"),
        ({"column_window": [9, 5000]}, "column_window is [9, 5000]; it must be two of 1024 columns"),
        ({"beam_altitude_angles": [1.0, 1.0, 0.0]}, "elevation"),
    ],
)
def test_metadata_that_is_no_sensor(tmp_path: Path, change: dict[str, object], message: str) -> None:
    (tmp_path / "os1.json").write_text(json.dumps(METADATA | FORMAT | change))
    with pytest.raises(Exception, match=r"os1\.json: ") as error:
        read_sensor(str(tmp_path / "os1.json"))
    assert message in str(error.value)


def test_metadata_of_real_units() -> None:
    folder = Path(os.environ.get("LIDARDRAFT_DATA", ""))
    found = [path for path in folder.rglob("OS-*.json") if "digest" not in path.name]
    if not found:
        pytest.skip("no recordings: LIDARDRAFT_DATA is not set")
    for path in found:
        sensor = read_ouster_metadata(path)
        assert len(sensor.elevations) == int(path.name.split("-")[2])
        assert (sensor.columns, sensor.wraps, sensor.sweep_time) == (1024, True, pytest.approx(0.1))


@pytest.mark.parametrize("name", ["os0-64", "os1-64"])
def test_presets_of_64_beams_lie_between_those_of_128(name: str) -> None:
    few, many = PRESETS[name], PRESETS[{"os1-64": "os1-128-d"}.get(name, name.replace("64", "128"))]
    assert len(few.elevations) == 64
    assert few.elevations[0] == pytest.approx(many.elevations[0])
    assert few.elevations[-1] == pytest.approx(many.elevations[-1], abs=0.02)
    assert few.max_range == many.max_range
