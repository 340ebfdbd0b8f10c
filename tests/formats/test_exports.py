"""Exports, read back by the readers that other people use, or by the same steps where these do not install."""

import gc
import itertools
import json
import math
import os
import resource
import subprocess
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

from lidardraft import Layout, Primitive, Sensor, Simulator
from lidardraft.errors import FormatError
from lidardraft.formats.frame import Frame
from lidardraft.formats.kitti_object import read_label_2, write_kitti_object
from lidardraft.formats.las import write_las
from lidardraft.formats.mcap import write_mcap
from lidardraft.formats.mmdet3d import CATEGORIES, write_mmdet3d
from lidardraft.formats.nuscenes import read_pcd_bin
from lidardraft.formats.nuscenes_tables import CATEGORY_OF_CLASS, write_nuscenes
from lidardraft.formats.openpcdet import write_openpcdet
from lidardraft.formats.pcd import write_pcd_folder
from lidardraft.formats.ply import read_ply, write_ply_folder
from lidardraft.formats.semantickitti import RAW_FROM_CLASS, write_sequences
from lidardraft.formats.webdataset import write_webdataset
from lidardraft.scene import edit
from lidardraft.semantics import CLASSES

SENSOR = Sensor(name="few", elevations=tuple(np.deg2rad(np.linspace(2, -24, 32)).tolist()), columns=512)
WRITERS = [
    write_kitti_object,
    write_sequences,
    write_nuscenes,
    write_openpcdet,
    write_mmdet3d,
    write_pcd_folder,
    write_ply_folder,
    write_las,
    write_mcap,
    write_webdataset,
]
Boxes = list[tuple[str, np.ndarray, np.ndarray, float]]  # class, centre, length width height, yaw


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


def points_within(points: np.ndarray, center: np.ndarray, size: np.ndarray, yaw: float) -> np.ndarray:
    x, y, z = (points - center).T
    along, across = math.cos(yaw) * x + math.sin(yaw) * y, math.cos(yaw) * y - math.sin(yaw) * x
    return (np.abs(np.stack([along, across, z], axis=1)) <= np.array(size) / 2 + 0.12).all(axis=1)


def agrees(frame: Frame, points: np.ndarray, boxes: Boxes, names: dict[str, str] | None = None) -> None:
    """The boxes that a reader found hold the points of the objects, as the frame's own do."""
    seen = frame.seen()
    assert [name for name, *_ in boxes] == [(names or {}).get(each.box.label, each.box.label) for each in seen]
    assert len(seen) == 4
    for each, (_, center, size, yaw) in zip(seen, boxes, strict=True):
        np.testing.assert_allclose(size, each.box.size, atol=1e-3)
        assert abs(math.remainder(yaw - each.box.yaw, math.tau)) < 1e-3
        inside = points_within(points, center, size, yaw)
        instances = (4, 5) if each.ridden else (each.box.instance,)
        mine = np.isin(frame.instance, instances)
        assert mine.sum() == each.num_points > 5
        assert inside[mine].mean() > 0.97
        assert mine[inside & ~np.isin(frame.label, (0, 1))].all()


def same_points(frame: Frame, table: np.ndarray) -> None:
    np.testing.assert_array_equal(table[:, :3], frame.points)
    np.testing.assert_allclose(table[:, 3], frame.intensity, atol=1e-6)


def test_what_a_frame_says_of_its_objects(frames: list[Frame]) -> None:
    of = {each.box.id: each for each in frames[0].annotations}
    assert list(of) == ["car_1", "car_2", "truck_3", "person_6", "bicycle_4"]
    assert of["car_1"].occlusion < 0.05
    assert of["person_6"].occlusion > 0.9
    assert of["bicycle_4"].ridden == "bicycle"
    np.testing.assert_allclose(of["bicycle_4"].box.size, (1.8, 0.6, 1.9))
    for frame in frames:
        order = np.lexsort([frame.time, frame.ring])
        np.testing.assert_array_equal(order, np.arange(len(order)))  # beam by beam, each in time
        elevation = np.arcsin(frame.points[:, 2] / np.linalg.norm(frame.points, axis=1))
        assert np.abs(elevation - np.array(SENSOR.elevations)[frame.ring]).max() < 0.05  # less the sensor's motion


def test_kitti_object_hides_nothing(frames: list[Frame], tmp_path: Path) -> None:
    """As OpenPCDet's and MMDetection3D's loaders do: lines 2, 4 and 5 of the calibration, and points by the picture."""
    write_kitti_object(tmp_path / "out", [frames])
    assert (tmp_path / "out/ImageSets/train.txt").read_text() == "000000\n000001\n"
    assert (tmp_path / "out/ImageSets/val.txt").read_text() == "000002\n"
    for name, frame in zip(("000000", "000001", "000002"), frames, strict=True):
        folder = tmp_path / "out" / "training"
        points = np.fromfile(folder / "velodyne" / f"{name}.bin", np.float32).reshape(-1, 4)
        same_points(frame, points)
        lines = (folder / "calib" / f"{name}.txt").read_text().splitlines()
        assert [lines[k].split(":")[0] for k in (2, 4, 5)] == ["P2", "R0_rect", "Tr_velo_to_cam"]
        projection, rectified, velo_to_cam = (np.array(lines[k].split()[1:], np.float32) for k in (2, 4, 5))
        camera = np.vstack([rectified.reshape(3, 3) @ velo_to_cam.reshape(3, 4), [0, 0, 0, 1]])
        in_camera = np.column_stack([points[:, :3], np.ones(len(points))]) @ camera.T
        pixels = in_camera @ projection.reshape(3, 4).T
        with Image.open(folder / "image_2" / f"{name}.png") as picture:
            width, height = picture.size
        u, v = pixels[:, :2].T / in_camera[:, 2]
        assert ((u >= 0) & (u < width) & (v >= 0) & (v < height) & (pixels[:, 2] > 0)).all()
        boxes: Boxes = []
        lines = (folder / "label_2" / f"{name}.txt").read_text().splitlines()
        for line, each in zip(lines, frame.seen(), strict=True):
            kind, truncated, occluded, alpha, *numbers = line.split()
            left, top, right, bottom, h, w, l, x, y, z, turn = map(float, numbers)  # noqa: E741
            center = np.linalg.inv(camera) @ (x, y - h / 2, z, 1.0)
            boxes.append((kind, center[:3], np.array([l, w, h]), -turn - math.pi / 2))
            assert (float(truncated), int(occluded)) == (0.0, (each.occlusion >= 0.1) + (each.occlusion >= 0.5))
            assert abs(math.remainder(float(alpha) - turn + math.atan2(x, z), math.tau)) < 1e-3
            assert bottom - top > 25  # pixels: what the benchmark counts
            mine = points_within(points[:, :3], center[:3], np.array([l, w, h]), -turn - math.pi / 2)
            assert ((u > left - 3) & (u < right + 3) & (v > top - 3) & (v < bottom + 3))[mine].all()
        agrees(frame, points[:, :3], boxes, {"car": "Car", "truck": "Truck", "rider": "Cyclist"})
        ours = read_label_2(folder / "label_2" / f"{name}.txt", folder / "calib" / f"{name}.txt")
        for box, each in zip(ours, frame.seen(), strict=True):
            np.testing.assert_allclose(box.corners(), each.box.corners(), atol=2e-3)


def test_semantickitti_sequences(frames: list[Frame], tmp_path: Path) -> None:
    """As semantic-kitti-api's `parse_poses`: Tr takes the LiDAR's points to the camera whose poses the file has."""
    write_sequences(tmp_path / "out", [frames, frames[:1]])
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
        same_points(frame, np.fromfile(folder / f"velodyne/{k:06d}.bin", np.float32).reshape(-1, 4))
        words = np.fromfile(folder / f"labels/{k:06d}.label", np.uint32)
        np.testing.assert_array_equal(words & 0xFFFF, [RAW_FROM_CLASS[CLASSES[i].name] for i in frame.label])
        np.testing.assert_array_equal(words >> 16, frame.instance)


def text_boxes(path: Path) -> Boxes:
    rows = [line.split() for line in path.read_text().splitlines()]
    return [(row[7], np.array(row[:3], float), np.array(row[3:6], float), float(row[6])) for row in rows]


def test_openpcdet(frames: list[Frame], tmp_path: Path) -> None:
    """As `CustomDataset` of its tutorial: numpy points, and centres as they are."""
    write_openpcdet(tmp_path / "out", [frames])
    names = (tmp_path / "out/ImageSets/trainval.txt").read_text().split()
    for name, frame in zip(names, frames, strict=True):
        points = np.load(tmp_path / f"out/points/{name}.npy")
        assert points.dtype == np.float32
        same_points(frame, points)
        agrees(frame, points[:, :3], text_boxes(tmp_path / f"out/labels/{name}.txt"))


def test_mmdet3d(frames: list[Frame], tmp_path: Path) -> None:
    """As `Det3DDataset` loads infos, and `LiDARInstance3DBoxes` lifts boxes from the middle of their bottom."""
    write_mmdet3d(tmp_path / "out", [frames])
    infos = [json.loads((tmp_path / f"out/lidardraft_infos_{part}.json").read_text()) for part in ("train", "val")]
    assert infos[0]["metainfo"]["categories"] == {name: k for k, name in enumerate(CATEGORIES)}
    for info, frame in zip([row for part in infos for row in part["data_list"]], frames, strict=True):
        path = tmp_path / "out/points" / info["lidar_points"]["lidar_path"]
        points = np.fromfile(path, np.float32).reshape(-1, info["lidar_points"]["num_pts_feats"])
        same_points(frame, points)
        lift = np.array([(0, 0, each["bbox_3d"][5] / 2) for each in info["instances"]])
        boxes = np.array([each["bbox_3d"] for each in info["instances"]])
        of_text = np.array([(*c, *s, yaw) for _, c, s, yaw in text_boxes(tmp_path / f"out/labels/{path.stem}.txt")])
        np.testing.assert_allclose(of_text, boxes, atol=1e-4)
        labels = [CATEGORIES[each["bbox_label_3d"]] for each in info["instances"]]
        agrees(frame, points[:, :3], list(zip(labels, boxes[:, :3] + lift, boxes[:, 3:6], boxes[:, 6], strict=True)))
        mask = np.fromfile(tmp_path / "out/semantic_mask" / info["pts_semantic_mask_path"], np.int64)
        np.testing.assert_array_equal(mask, frame.label)


def test_nuscenes_tables(frames: list[Frame], tmp_path: Path) -> None:
    """Every token that a row names exists, and boxes come back into the sensor's frame by the poses of the tables."""
    write_nuscenes(tmp_path / "out", [frames])
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
    for token, frame in zip(found, frames, strict=True):
        points, intensity, ring = read_pcd_bin(tmp_path / "out" / tables["sample_data"][token]["filename"])
        same_points(frame, np.column_stack([points, intensity]))
        np.testing.assert_array_equal(ring, 31 - frame.ring.astype(int))  # from the lowest beam


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
    write_nuscenes(tmp_path / "out", [frames])
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


def same_fields(frame: Frame, column: Callable[[str], np.ndarray]) -> None:
    same_points(frame, np.stack([column(name) for name in ("x", "y", "z", "intensity")], axis=1))
    for name in ("ring", "time", "label", "instance"):
        np.testing.assert_array_equal(column(name), getattr(frame, name))


def test_pcd_by_pypcd4(frames: list[Frame], tmp_path: Path) -> None:
    pypcd4 = pytest.importorskip("pypcd4")
    write_pcd_folder(tmp_path / "out", [frames])
    for k, frame in enumerate(frames):
        cloud = pypcd4.PointCloud.from_path(tmp_path / f"out/{k:06d}.pcd")
        assert cloud.fields == ("x", "y", "z", "intensity", "ring", "time", "label", "instance")
        same_fields(frame, cloud.pc_data.__getitem__)


def test_ply_by_trimesh(frames: list[Frame], tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    write_ply_folder(tmp_path / "out", [frames])
    for k, frame in enumerate(frames):
        vertices = trimesh.load(tmp_path / f"out/{k:06d}.ply").metadata["_ply_raw"]["vertex"]["data"]
        same_fields(frame, vertices.__getitem__)
        same_fields(frame, read_ply(tmp_path / f"out/{k:06d}.ply").__getitem__)


def test_laz_by_laspy(frames: list[Frame], tmp_path: Path) -> None:
    laspy = pytest.importorskip("laspy")
    write_las(tmp_path / "out", [frames])
    for k, frame in enumerate(frames):
        cloud = laspy.read(tmp_path / f"out/{k:06d}.las")
        np.testing.assert_allclose(cloud.xyz, frame.points, atol=0.0006)
        np.testing.assert_allclose(cloud.intensity / 65535, frame.intensity, atol=1e-5)
        for name, values in (("ring", frame.ring), ("label", frame.label), ("instance", frame.instance)):
            np.testing.assert_array_equal(cloud[name], values)
        np.testing.assert_array_equal(cloud.gps_time, frame.time)
        asprs = {1: 11, 4: 68, 13: 77}  # roads; walls and cars, which it does not have
        for label, code in asprs.items():
            assert set(np.array(cloud.classification)[frame.label == label]) == {code}


def matrix(place: object, turn: object) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat([getattr(turn, axis) for axis in "xyzw"]).as_matrix()
    pose[:3, 3] = [getattr(place, axis) for axis in "xyz"]
    return pose


def test_mcap_by_its_reader(frames: list[Frame], tmp_path: Path) -> None:
    reader = pytest.importorskip("mcap.reader")
    decoder = pytest.importorskip("mcap_protobuf.decoder")
    write_mcap(tmp_path / "out", [frames])
    with (tmp_path / "out/000000.mcap").open("rb") as file:
        found = list(reader.make_reader(file, decoder_factories=[decoder.DecoderFactory()]).iter_decoded_messages())
    schemas = {channel.topic: schema.name for schema, channel, *_ in found}
    named = {"/lidar": "PointCloud", "/boxes": "SceneUpdate", "/tf": "FrameTransforms"}
    assert schemas == {topic: f"foxglove.{name}" for topic, name in named.items()}
    for k, frame in enumerate(frames):
        said = {channel.topic: (message.log_time, decoded) for _, channel, message, decoded in found[3 * k : 3 * k + 3]}
        assert {time for time, _ in said.values()} == {1_600_000_000_000_000_000 + k * 100_000_000}
        cloud, (to_base, to_lidar) = said["/lidar"][1], said["/tf"][1].transforms
        kinds = {1: "u1", 3: "<u2", 5: "<u4", 7: "<f4"}  # PackedElementField.NumericType
        names, formats = [field.name for field in cloud.fields], [kinds[field.type] for field in cloud.fields]
        offsets = [field.offset for field in cloud.fields]
        layout = {"names": names, "formats": formats, "offsets": offsets, "itemsize": cloud.point_stride}
        same_fields(frame, np.frombuffer(cloud.data, np.dtype(layout)).__getitem__)
        chain = [(each.parent_frame_id, each.child_frame_id) for each in (to_base, to_lidar)]
        assert chain == [("map", "base_link"), ("base_link", cloud.frame_id)]
        pose = matrix(to_base.translation, to_base.rotation) @ matrix(to_lidar.translation, to_lidar.rotation)
        np.testing.assert_allclose(pose, frame.pose, atol=1e-9)
        for entity, each in zip(said["/boxes"][1].entities, frame.annotations, strict=True):
            assert (entity.id, entity.frame_id) == (each.box.id, "lidar")
            (cube,) = entity.cubes
            corners = each.box.corners() - each.box.center
            turned = matrix(cube.pose.position, cube.pose.orientation)
            unit = np.sign(replace(each.box, yaw=0.0).corners() - each.box.center) / 2
            size = np.array([cube.size.x, cube.size.y, cube.size.z])
            np.testing.assert_allclose((unit * size) @ turned[:3, :3].T, corners, atol=1e-9)
            np.testing.assert_allclose(turned[:3, 3], each.box.center)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # it leaves its files open
def test_webdataset_by_its_library(frames: list[Frame], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    webdataset = pytest.importorskip("webdataset")
    monkeypatch.setattr("lidardraft.formats.webdataset.SHARD", 2)
    write_webdataset(tmp_path / "out", [frames])
    assert json.loads((tmp_path / "out/index.json").read_text()) == {"000000.tar": 2, "000001.tar": 1}
    urls = [str(tmp_path / f"out/{k:06d}.tar") for k in range(2)]
    samples = list(webdataset.WebDataset(urls, shardshuffle=False, empty_check=False).decode())
    gc.collect()
    for k, (sample, frame) in enumerate(zip(samples, frames, strict=True)):
        assert sample["__key__"] == f"{k:06d}"
        same_points(frame, sample["points.npy"])
        for name in ("ring", "time", "label", "instance"):
            np.testing.assert_array_equal(sample[f"{name}.npy"], getattr(frame, name))
        np.testing.assert_allclose(sample["json"]["pose"], frame.pose)
        assert [box["id"] for box in sample["json"]["boxes"]] == [each.box.id for each in frame.annotations]


@pytest.mark.parametrize("write", WRITERS)
def test_a_data_set_is_there_whole_or_not_at_all(write: Callable, frames: list[Frame], tmp_path: Path) -> None:
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
    with pytest.raises(FormatError, match="out is there already; write to a new or empty folder"):
        write(tmp_path / "out", [frames])
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
    with pytest.raises(FormatError, match="there are no scans to write"):
        write(tmp_path / "none", [])
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_worlds_are_scenes_of_nuscenes(frames: list[Frame], tmp_path: Path) -> None:
    other = [replace(frame, world="another") for frame in frames]
    write_nuscenes(tmp_path / "out", [[*frames, *other[:1]], other])
    scenes = json.loads((tmp_path / "out/v1.0-trainval/scene.json").read_text())
    assert [scene["nbr_samples"] for scene in scenes] == [3, 1, 3]
    annotations = json.loads((tmp_path / "out/v1.0-trainval/instance.json").read_text())
    assert len(annotations) == 3 * len(frames[0].annotations)
    assert len({row["token"] for row in annotations}) == len(annotations)
    times = [row["timestamp"] for row in json.loads((tmp_path / "out/v1.0-trainval/sample.json").read_text())]
    assert all(before < after for before, after in itertools.pairwise(times))
