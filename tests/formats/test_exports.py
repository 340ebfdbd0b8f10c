"""Exports, read back by the readers that other people use, or by the same steps where these do not install."""

import gc
import itertools
import json
import math
import os
import resource
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import webdataset
from PIL import Image

from foreign_readers import (
    FIELDS,
    READERS,
    Box,
    kitti_calibration,
    las,
    mmdet3d,
    nuscenes,
    semantickitti,
    text_boxes,
)
from lidardraft import Layout, Primitive, Sensor, Simulator
from lidardraft.errors import FormatError
from lidardraft.formats.frame import FORMATS, Annotation, Frame, writer_of
from lidardraft.formats.kitti_object import read_label_2
from lidardraft.formats.nuscenes import CATEGORY_OF_CLASS
from lidardraft.formats.semantickitti import RAW_FROM_CLASS
from lidardraft.scene import edit
from lidardraft.semantics import CLASSES

SENSOR = Sensor(name="few", elevations=tuple(np.deg2rad(np.linspace(2, -24, 32)).tolist()), columns=512)


def primitive(label: str, id: str, instance: int, center: tuple, size: tuple, yaw: float = 0.0) -> Primitive:
    return Primitive(shape="box", center=center, size=size, yaw=yaw, label=label, id=id, instance=instance)


LAYOUT = Layout((
    Primitive(shape="plane", center=(0, 0, 0), size=(200, 200, 0), label="road", id="road"),
    primitive("car", "car_1", 1, (9, 4, 0.8), (4.4, 1.9, 1.5), 0.5),
    primitive("car", "car_2", 2, (-12, -3, 0.8), (4.2, 1.8, 1.5), -2.5),
    primitive("truck", "truck_3", 3, (4, -9, 1.6), (8, 2.5, 3.2), 1.4),
    primitive("bicycle", "bicycle_4.bicycle", 4, (7, -3, 0.55), (1.8, 0.6, 1.1), 2.0),
    primitive("rider", "bicycle_4.rider", 5, (7, -3, 1.2), (0.6, 0.6, 1.4), 2.0),
    primitive("person", "person_6", 6, (4.6, -14.5, 0.9), (0.6, 0.6, 1.7)),  # behind the truck
    primitive("wall", "wall", 0, (0, 20, 1.5), (30, 0.3, 3.0)),
))  # fmt: skip


@pytest.fixture(scope="module")
def frames() -> list[Frame]:
    """Three frames of a turning drive, in which one car moves."""
    found = []
    for k in range(3):
        layout = edit.move(LAYOUT, "car_1", by=(0.5 * k, 0.0, 0.0))
        scan = Simulator(layout, SENSOR, seed=0).scan(SENSOR.pose(x=0.8 * k, yaw=0.3 + 0.1 * k), speed=8.0, seed=k)
        found.append(scan.frame())
    return found


_MARGIN = 0.12  # m around boxes: noise
KITTI = {"car": "Car", "truck": "Truck", "rider": "Cyclist"}
UNBOXED = ("semantickitti", "pcd", "ply", "las")
WITH_UNSEEN = ("nuscenes", "ros2", "webdataset")  # formats that keep objects without a point


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # webdataset leaves its files open
@pytest.mark.parametrize("name", FORMATS)
def test_others_find_the_same_points_in_the_same_boxes(name: str, frames: list[Frame], tmp_path: Path) -> None:
    writer_of(name)(tmp_path / "out", [frames])
    exact = 1e-6 if name != "las" else 6e-4  # whole millimetres
    for frame, found in zip(frames, READERS[name](tmp_path / "out"), strict=True):
        np.testing.assert_allclose(found.points[:, :3], frame.points, atol=exact, rtol=0)
        np.testing.assert_allclose(found.points[:, 3], frame.intensity, atol=1e-5)
        for field in FIELDS:
            if field in found.fields:
                assert field != "time"  # of points whose motion is taken out
                np.testing.assert_array_equal(found.fields[field], getattr(frame, field))
        assert (found.boxes is None) == (name in UNBOXED)
        if found.boxes is not None:
            expected = frame.annotations if name in WITH_UNSEEN else frame.seen()
            agrees(name, frame, found.points[:, :3], found.boxes, list(expected))
    gc.collect()


def agrees(name: str, frame: Frame, points: np.ndarray, boxes: list[Box], expected: list[Annotation]) -> None:
    """The boxes that a reader found hold the points of the objects, as the frame's own do."""
    assert len(expected) == len(boxes) == (5 if name in WITH_UNSEEN else 4)
    for each, box in zip(expected, boxes, strict=True):
        named = KITTI if name == "kitti" else CATEGORY_OF_CLASS if name == "nuscenes" else {}
        label = each.ridden if name == "nuscenes" and each.ridden else each.box.label
        assert box.name == named.get(label, label)
        np.testing.assert_allclose(box.center, each.box.center, atol=2e-3)
        np.testing.assert_allclose(box.size, each.box.size, atol=1e-3)
        assert abs(math.remainder(box.yaw - each.box.yaw, math.tau)) < 1e-3
        placed = replace(each.box, center=tuple(box.center), size=tuple(box.size), yaw=float(box.yaw))
        inside = placed.contains(points, _MARGIN)
        mine = np.isin(frame.instance, (4, 5) if each.ridden else (each.box.instance,))
        assert mine.sum() == each.num_points
        assert inside[mine].mean() > 0.97 if each.num_points else each.box.label == "person"
        assert mine[inside & ~np.isin(frame.label, (0, 1))].all()


def test_what_a_frame_says_of_its_objects(frames: list[Frame]) -> None:
    of = {each.box.id: each for each in frames[0].annotations}
    assert list(of) == ["car_1", "car_2", "truck_3", "person_6", "bicycle_4"]
    assert of["car_1"].occlusion < 0.05
    assert of["person_6"].occlusion > 0.9
    assert of["bicycle_4"].ridden == "bicycle"
    np.testing.assert_allclose(of["bicycle_4"].box.size, (1.8, 0.6, 1.9))
    for frame in frames:
        assert (np.diff(frame.ring.astype(int)) >= 0).all()  # beam by beam
        elevation = np.arcsin(frame.points[:, 2] / np.linalg.norm(frame.points, axis=1))
        assert np.abs(elevation - np.array(SENSOR.elevations)[frame.ring]).max() < 0.05  # less the sensor's motion


def test_kitti_object_hides_nothing(frames: list[Frame], tmp_path: Path) -> None:
    """Every point is in the picture, as loaders leave out what is not, and in the rectangle of its object."""
    writer_of("kitti")(tmp_path / "out", [frames])
    assert (tmp_path / "out/ImageSets/train.txt").read_text() == "000000\n000001\n"
    assert (tmp_path / "out/ImageSets/val.txt").read_text() == "000002\n"
    folder = tmp_path / "out" / "training"
    for name, frame in zip(("000000", "000001", "000002"), frames, strict=True):
        camera, projection = kitti_calibration(tmp_path / "out", name)
        in_camera = np.column_stack([frame.points, np.ones(len(frame.points))]) @ camera.T
        pixels = in_camera @ projection.T
        with Image.open(folder / "image_2" / f"{name}.png") as picture:
            width, height = picture.size
        u, v = pixels[:, :2].T / in_camera[:, 2]
        assert ((u >= 0) & (u < width) & (v >= 0) & (v < height) & (pixels[:, 2] > 0)).all()
        lines = (folder / "label_2" / f"{name}.txt").read_text().splitlines()
        for line, each in zip(lines, frame.seen(), strict=True):
            truncated, occluded, alpha, left, top, right, bottom, *_, x, _, z, turn = map(float, line.split()[1:])
            assert (truncated, occluded) == (0.0, (each.occlusion >= 0.1) + (each.occlusion >= 0.5))
            assert abs(math.remainder(alpha - turn + math.atan2(x, z), math.tau)) < 1e-3
            assert bottom - top > 25  # pixels: what the benchmark counts
            mine = each.box.contains(frame.points, _MARGIN)
            assert ((u > left - 3) & (u < right + 3) & (v > top - 3) & (v < bottom + 3))[mine].all()
        ours = read_label_2(folder / "label_2" / f"{name}.txt", folder / "calib" / f"{name}.txt")
        for box, each in zip(ours, frame.seen(), strict=True):
            np.testing.assert_allclose(box.corners(), each.box.corners(), atol=2e-3)


def test_semantickitti_sequences(frames: list[Frame], tmp_path: Path) -> None:
    """As semantic-kitti-api's `parse_poses`: Tr takes the LiDAR's points to the camera whose poses the file has."""
    writer_of("semantickitti")(tmp_path / "out", [frames, frames[:1]])
    assert sorted(os.listdir(tmp_path / "out/sequences")) == ["00", "01"]
    folder = tmp_path / "out/sequences/00"
    rows = dict(line.split(": ") for line in (folder / "calib.txt").read_text().splitlines())
    assert list(rows) == ["P0", "P1", "P2", "P3", "Tr"]
    tr = np.vstack([np.array(rows["Tr"].split(), float).reshape(3, 4), [0, 0, 0, 1]])
    poses = [np.vstack([row.reshape(3, 4), [0, 0, 0, 1]]) for row in np.loadtxt(folder / "poses.txt")]
    np.testing.assert_allclose(np.loadtxt(folder / "times.txt"), [0.0, 0.1, 0.2])
    np.testing.assert_allclose(poses[0], np.eye(4), atol=1e-9)
    for k, frame in enumerate(frames):
        relative = np.linalg.inv(tr) @ poses[k] @ tr
        np.testing.assert_allclose(frames[0].pose @ relative, frame.pose, atol=1e-9)
    for found, frame in zip(semantickitti(tmp_path / "out"), [*frames, frames[0]], strict=True):
        raw = [RAW_FROM_CLASS[CLASSES[number].name] for number in frame.label]
        np.testing.assert_array_equal(found.fields["raw"], raw)


def test_the_boxes_of_mmdet3d_are_a_text_too(frames: list[Frame], tmp_path: Path) -> None:
    writer_of("mmdet3d")(tmp_path / "out", [frames])
    for name, found in zip(("000000", "000001", "000002"), mmdet3d(tmp_path / "out"), strict=True):
        for text, box in zip(text_boxes(tmp_path / f"out/labels/{name}.txt"), found.boxes or [], strict=True):
            assert text.name == box.name
            np.testing.assert_allclose(text.center, box.center - (0, 0, box.size[2] / 2), atol=1e-4)


def test_nuscenes_tables(frames: list[Frame], tmp_path: Path) -> None:
    """Every token that a row names exists, and boxes come back into the sensor's frame by the poses of the tables."""
    writer_of("nuscenes")(tmp_path / "out", [frames])
    tables = {
        path.stem: {row["token"]: row for row in json.loads(path.read_text())}
        for path in (tmp_path / "out/v1.0-trainval").iterdir()
    }
    assert len(tables) == 14
    rows = [row for table in tables.values() for row in table.values()]
    for field, token in [item for row in rows for item in row.items()]:
        table = field.removesuffix("_token").removeprefix("first_").removeprefix("last_")
        table = "sample_annotation" if table == "annotation" else table
        if field.endswith("_token") and not (token == "" and field in ("prev", "next")):
            assert token in tables[table], field
    (scene,) = tables["scene"].values()
    token, found = scene["first_sample_token"], []
    while token:
        found.append(token)
        token = tables["sample"][token]["next"]
    assert found[-1] == scene["last_sample_token"]
    assert len(found) == scene["nbr_samples"] == 3
    assert {row["nbr_annotations"] for row in tables["instance"].values()} == {3}
    assert np.diff([row["timestamp"] for row in tables["sample"].values()]).tolist() == [100_000] * 2
    for sweep, frame in zip(nuscenes(tmp_path / "out"), frames, strict=True):
        np.testing.assert_array_equal(sweep.fields["from_lowest"], 31 - frame.ring.astype(int))


_DEVKIT = """
import json, sys
import numpy as np
from nuscenes.nuscenes import NuScenes
from nuscenes.utils.data_classes import LidarPointCloud
from nuscenes.utils.geometry_utils import points_in_box
nuscenes = NuScenes("v1.0-trainval", sys.argv[1], verbose=False)
for sample in nuscenes.sample:
    path, boxes, _ = nuscenes.get_sample_data(sample["data"]["LIDAR_TOP"])
    cloud = LidarPointCloud.from_file(path).points
    labels = nuscenes.get("lidarseg", sample["data"]["LIDAR_TOP"])
    classes = np.fromfile(f"{sys.argv[1]}/{labels['filename']}", np.uint8)
    names = [nuscenes.lidarseg_idx2name_mapping[int(each)] for each in classes]
    things, rows = np.array([name.startswith(("vehicle", "human")) for name in names]), []
    for box in boxes:
        annotation = nuscenes.get("sample_annotation", box.token)
        inside = int(points_in_box(box, cloud[:3, things], wlh_factor=1.05).sum())
        speed = nuscenes.box_velocity(box.token).tolist()
        rows.append([box.name, inside, annotation["num_lidar_pts"], speed, annotation["visibility_token"]])
    print(json.dumps([names, rows]))
"""


@pytest.mark.skipif("NUSCENES_PYTHON" not in os.environ, reason="NUSCENES_PYTHON is no Python that has nuscenes-devkit")
def test_nuscenes_by_its_devkit(frames: list[Frame], tmp_path: Path) -> None:
    writer_of("nuscenes")(tmp_path / "out", [frames])
    command = [os.environ["NUSCENES_PYTHON"], "-c", _DEVKIT, str(tmp_path / "out")]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    said = subprocess.run(command, check=True, capture_output=True, text=True, env=environment).stdout
    for line, frame in zip(said.splitlines(), frames, strict=True):
        names, rows = json.loads(line)
        assert names == [CATEGORY_OF_CLASS[CLASSES[label].name] for label in frame.label]
        for (name, inside, count, speed, visibility), each in zip(rows, frame.annotations, strict=True):
            assert name == CATEGORY_OF_CLASS[each.ridden or each.box.label]
            assert count == each.num_points
            assert 0.97 * count <= inside <= count
            np.testing.assert_allclose(speed, (5.0 if each.box.id == "car_1" else 0.0, 0.0, 0.0), atol=1e-4)  # whole us
            assert visibility == ("1" if each.box.id == "person_6" else "4")


def test_classes_of_las(frames: list[Frame], tmp_path: Path) -> None:
    writer_of("las")(tmp_path / "out", [frames])
    for frame, found in zip(frames, las(tmp_path / "out"), strict=True):
        for label, code in {1: 11, 4: 68, 13: 77}.items():  # roads; walls and cars, which ASPRS does not have
            assert set(found.fields["classification"][frame.label == label]) == {code}


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # it leaves its files open
def test_shards_of_webdataset_by_its_library(
    frames: list[Frame], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("lidardraft.formats.webdataset.SHARD", 2)
    writer_of("webdataset")(tmp_path / "out", [frames])
    assert json.loads((tmp_path / "out/index.json").read_text()) == {"000000.tar": 2, "000001.tar": 1}
    urls = [str(tmp_path / f"out/{k:06d}.tar") for k in range(2)]
    samples = list(webdataset.WebDataset(urls, shardshuffle=False, empty_check=False).decode())
    gc.collect()
    for k, (sample, frame) in enumerate(zip(samples, frames, strict=True)):
        assert sample["__key__"] == f"{k:06d}"
        np.testing.assert_allclose(sample["json"]["pose"], frame.pose)
        assert [box["id"] for box in sample["json"]["boxes"]] == [each.box.id for each in frame.annotations]


@pytest.mark.parametrize("name", FORMATS)
def test_a_data_set_is_there_whole_or_not_at_all(name: str, frames: list[Frame], tmp_path: Path) -> None:
    write = writer_of(name)

    def interrupted() -> Iterator[Frame]:
        yield frames[0]
        assert len(list(tmp_path.iterdir())) == 1
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write(tmp_path / "out", [interrupted()])
    assert not list(tmp_path.iterdir())

    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, before[1]))  # as on a full disk
    try:
        with pytest.raises(FormatError, match=r"/out(/[^.].*)? cannot be written"):
            write(tmp_path / "out", [frames])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert not list(tmp_path.iterdir())

    def overtaken() -> Iterator[Frame]:
        yield frames[0]
        write(tmp_path / "out", [frames[1:]])  # by another process

    with pytest.raises(FormatError, match="out cannot be written: Directory not empty"):
        write(tmp_path / "out", [overtaken()])
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(FormatError, match="out exists already; write to a new or empty folder"):
        write(tmp_path / "out", [frames])
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
    with pytest.raises(FormatError, match="there are no scans to write"):
        write(tmp_path / "none", [])
    with pytest.raises(FormatError, match="there are no scans to write"):
        write(tmp_path / "none", [frames[:1], []])
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_worlds_are_scenes_of_nuscenes(frames: list[Frame], tmp_path: Path) -> None:
    other = [replace(frame, world='{"intent": {"sentence": "another"}}') for frame in frames]
    writer_of("nuscenes")(tmp_path / "out", [[*frames, *other[:1]], other])
    scenes = json.loads((tmp_path / "out/v1.0-trainval/scene.json").read_text())
    assert [scene["nbr_samples"] for scene in scenes] == [3, 1, 3]
    assert [scene["description"] for scene in scenes] == ["", "another", "another"]
    annotations = json.loads((tmp_path / "out/v1.0-trainval/instance.json").read_text())
    assert len(annotations) == 3 * len(frames[0].annotations)
    assert len({row["token"] for row in annotations}) == len(annotations)
    times = [row["timestamp"] for row in json.loads((tmp_path / "out/v1.0-trainval/sample.json").read_text())]
    assert all(before < after for before, after in itertools.pairwise(times))
