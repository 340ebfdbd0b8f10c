"""A small good file of every kind that is read, with its reader."""

from __future__ import annotations

import gzip
import io
import json
import os
import struct
import tempfile
import warnings
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import laspy
import numpy as np
from PIL import Image
from rosbags import rosbag2
from safetensors.numpy import save

import lidardraft
from lidardraft.array_files import read_npy
from lidardraft.dataset.recipe import Recipe
from lidardraft.files import named, read_bytes, read_sentences
from lidardraft.formats.blender_script import write_blender_script
from lidardraft.formats.box_files import read_box_file, read_custom_labels
from lidardraft.formats.boxes import read_boxes, write_boxes
from lidardraft.formats.carla import read_carla
from lidardraft.formats.cast import read_cast
from lidardraft.formats.cityscapes import read_semantics
from lidardraft.formats.glb import write_glb
from lidardraft.formats.intrinsics import read_intrinsics
from lidardraft.formats.kitti import read_bin, write_bin
from lidardraft.formats.kitti_object import read_label_2
from lidardraft.formats.las import read_las
from lidardraft.formats.masks import read_masks
from lidardraft.formats.nuscenes import read_annotations, read_lidarseg, read_pcd_bin, read_table
from lidardraft.formats.obj import write_obj
from lidardraft.formats.ouster import read_ouster_capture, read_ouster_metadata
from lidardraft.formats.pairs import Pair, read_shard, write_pairs
from lidardraft.formats.pandaset import read_cuboids, read_sweep
from lidardraft.formats.pcd import read_pcd
from lidardraft.formats.pickled_table import read_pickled_table
from lidardraft.formats.picture import read_picture
from lidardraft.formats.ply import read_ply, write_ply
from lidardraft.formats.recording import read_labels, read_points, read_recording, read_returns, read_semantic_map
from lidardraft.formats.ros2 import message_types
from lidardraft.formats.rosbag import ego_scenario, read_cloud
from lidardraft.formats.semantickitti import read_label, write_label
from lidardraft.networks.weight_header import read_metadata
from lidardraft.scan import read_motion
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.scenario import Scenario, Straight, Waypoints
from lidardraft.scene.sensor import Sensor
from lidardraft.world.rig import Mount, Rig
from lidardraft.world.state import WorldState
from lidardraft.world.world import World
from small_recordings import BEAMS, COLUMNS, pandas_pickle, pandaset, write_capture
from small_recordings import METADATA as OUSTER

CAR = Primitive(shape="box", center=(9, 0, 1), size=(4, 2, 1.5), label="car", id="car_1", instance=1)
LAYOUT = Layout((CAR,), {"seed": 1})
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(90, 90, 0), label="road", id="road")
STREET = Layout((CAR, ROAD))
SENSOR = Sensor(name="few", elevations=(0.1, 0.0, -0.1), columns=16)
SCENARIO = Scenario(Waypoints(((0, 0, 0, 0), (1, 5, 0, 0.1))), {"car_*": Straight(3.0)})
RECIPE = b"""
scans = 4
seed = 1
[[scene]]
share = 2
text = ["{count} cars ahead"]
words.count = { from = 2, to = 4 }
speed = [0, { from = 3.0, to = 14.0 }]
[[scene.edit]]
remove = "car_1"
chance = 0.5
[[scene]]
street = ["urban", "country"]
traffic = { from = 0.5, to = 2.0 }
[[weather]]
rain = { from = 0.0, to = 5.0 }
"""
SVG = b"""<svg width="90" height="60"><rect id="car" x="4" y="9" width="2" height="4"/>
<line id="scale 10 m" x2="10"/></svg>"""
BOX_LINES = b"9.0 4.0 -0.9 4.4 1.9 1.5 0.5 Car\n-3 2 -1 0.6 0.6 1.7 0 pedestrian\n"
ANNOTATIONS = b"""[{"token": "a", "sample_token": "a", "instance_token": "a", "attribute_tokens": [],
"size": [2, 4, 1.5], "translation": [9, 0, 1], "rotation": [1, 0, 0, 0]}]"""
PLY = b"""ply
format ascii 1.0
element vertex 2
property float32 x
property float32 y
property float32 z
property float32 CosAngle
property uint32 ObjIdx
property uint32 ObjTag
end_header
9.0000 1.0000 -1.5000 0.5000 7 14
4.0 -2.0 -1.7 0.3 0 24
"""
LABEL_2 = b"Car 0.00 0 1.55 614 181 727 284 1.57 1.73 4.15 1.00 1.75 13.22 1.62\n"
CALIB = b"R0_rect: 1 0 0 0 1 0 0 0 1\nTr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0\n"
CLOUD = b"""FIELDS x y z scalar_Intensity ring _
SIZE 4 4 4 1 2 4
TYPE F F F U U F
COUNT 1 1 1 1 1 0
VIEWPOINT 1 4 0 0.6 0 0 0.8
POINTS 2
DATA ascii
1 2 4 14 1
4.0 2 1 1 4.0
"""
PCD = b"FIELDS x y\nSIZE 4 4\nTYPE F F\nCOUNT 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1 2\n3 4\n"


@dataclass(frozen=True, slots=True)
class Reader:
    """What reads a file of a kind, the ending it goes by, and a good one."""

    read: Callable[[Path], object]
    ending: str
    good: bytes


def _label_2(path: Path) -> object:
    with tempfile.TemporaryDirectory() as folder:
        calib = Path(folder, "calib.txt")
        calib.write_bytes(CALIB)
        return read_label_2(path, calib)


def _points(path: Path) -> object:
    """The points, without warnings on applied fields."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return read_points(path)


def _calib(path: Path) -> object:
    with tempfile.TemporaryDirectory() as folder:
        label = Path(folder, "label.txt")
        label.write_bytes(LABEL_2)
        return read_label_2(label, path)


def _binary_ply(points: np.ndarray) -> bytes:
    records = points.view([(axis, "<f4") for axis in "xyz"])[:, 0]
    return written(lambda path: write_ply(path, records), ".ply")


def _pairs(folder: str) -> Path:
    """The first file of a folder of pairs."""
    image = lidardraft.raycast(LAYOUT, SENSOR)
    list(write_pairs(folder, [(Pair(image, image), {})]))
    return Path(folder, "00000.npz")


def _shard(path: Path) -> object:
    with tempfile.TemporaryDirectory() as folder, named(path):
        first = _pairs(folder)
        first.unlink()
        first.symlink_to(path.absolute())
        return read_shard(first)


def write_las(path: Path) -> None:
    points = laspy.LasData(laspy.LasHeader(point_format=6, version="1.4"))
    points.xyz = np.linspace(-1, 1, 300).reshape(100, 3)
    points.write(os.fspath(path))


def _bag(path: Path) -> None:
    """The file of a bag of one scan."""
    folder = path.with_suffix("")
    road = Primitive(shape="plane", center=(0, 0, 0), size=(90, 90, 0), label="road", id="road")
    points = lidardraft.raycast(Layout((road, CAR)), SENSOR).points()
    scan = lidardraft.Scan.from_points(points, SENSOR, layout=LAYOUT, intensity=np.ones(len(points), np.float32))
    lidardraft.export(scan, "ros2", folder)
    (folder / "000000/000000.mcap").rename(path)


def _bag_of_sqlite(path: Path) -> None:
    """The same in a database."""
    _bag(path.with_suffix(".mcap"))
    folder, types = path.with_suffix(""), message_types()
    with (
        rosbag2.Reader(path.with_suffix(".mcap")) as bag,
        rosbag2.Writer(folder / "db3", version=8, storage_plugin=rosbag2.StoragePlugin.SQLITE3) as writer,
    ):
        for each, time_, data in bag.messages():
            if each.msgtype.endswith("PointCloud2"):
                writer.write(writer.add_connection(each.topic, each.msgtype, typestore=types), time_, data)
    (folder / "db3" / "db3.db3").rename(path)


def _annotations(path: Path) -> object:
    """A sweep whose annotations are the file."""
    token, upright = {"token": "a"}, {"translation": [0, 0, 0], "rotation": [1, 0, 0, 0]}
    tokens = {f"{name}_token": "a" for name in ("sample", "ego_pose", "calibrated_sensor", "category")}
    tables = {
        "sample_data": token | tokens | {"filename": "samples/LIDAR_TOP/a.pcd.bin"},
        **dict.fromkeys(("ego_pose", "calibrated_sensor"), token | upright),
        "instance": token | tokens,
        **dict.fromkeys(("category", "attribute"), token | {"name": "vehicle.car"}),
    }
    with tempfile.TemporaryDirectory() as folder, named(path):
        (Path(folder) / "v1.0-mini").mkdir()
        for name, row in tables.items():
            Path(folder, "v1.0-mini", f"{name}.json").write_text(json.dumps([row]))
        Path(folder, "v1.0-mini", "sample_annotation.json").symlink_to(path.absolute())
        return read_annotations(Path(folder, "samples", "LIDAR_TOP", "a.pcd.bin"))


def _capture(path: Path) -> object:
    path.with_suffix(".json").write_text(json.dumps(OUSTER))
    return read_ouster_capture(path)


def _drive_with(part: str) -> Callable[[Path], object]:
    """Reads a drive of PandaSet in which the file stands in for one of its own."""

    def read(path: Path) -> object:
        with tempfile.TemporaryDirectory() as folder, named(path):
            sweep = pandaset(Path(folder))
            file = sweep.parents[1] / part
            file.unlink()
            file.symlink_to(path.absolute())
            return read_sweep(sweep), read_cuboids(sweep.parents[1] / "annotations" / "cuboids" / sweep.name)

    return read


def _program(path: Path) -> object:
    """What a table is of which the file is the program."""
    with tempfile.TemporaryDirectory() as folder, named(path):
        packed = Path(folder, "a.pkl.gz")
        packed.write_bytes(gzip.compress(read_bytes(path), 1))
        return read_pickled_table(packed)


def written(write: Callable[[Path], object], ending: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{ending}"
        write(path)
        return path.read_bytes()


def npy(array: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, array, allow_pickle=True)
    return buffer.getvalue()


def archive(*members: str | bytes, kind: int = zipfile.ZIP_DEFLATED) -> bytes:
    """An archive of arrays: a name and the bytes of each."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", kind) as made:
        for name, data in zip(members[::2], members[1::2], strict=True):
            made.writestr(f"{name}.npy", data)
    return buffer.getvalue()


def picture_bytes(kind: str, pixels: np.ndarray | None = None, **options: int) -> bytes:
    buffer, blue = io.BytesIO(), np.full((40, 60, 3), (0, 0, 142), np.uint8)
    Image.fromarray(blue if pixels is None else pixels).save(buffer, kind, **options)
    return buffer.getvalue()


def readers() -> dict[str, Reader]:
    """All ways by which others' files come in."""
    points = np.linspace(-1, 1, 300, dtype=np.float32).reshape(100, 3)
    kinds = {"<f4": ("x", "y", "z", "CosAngle"), "<u4": ("ObjIdx", "ObjTag")}
    records = np.zeros(4, [(name, kind) for kind, names in kinds.items() for name in names])
    image = lidardraft.raycast(LAYOUT, SENSOR)

    def sketch(path: Path) -> Layout:
        return lidardraft.layout_from_sketch(path, metres_per_pixel=0.1)

    with tempfile.TemporaryDirectory() as folder:
        sweep = pandaset(Path(folder))
        parts = ("lidar/00.pkl.gz", "lidar/poses.json", "lidar/timestamps.json", "annotations/cuboids/00.pkl.gz")
        drives = {
            f"pandaset {part}": Reader(
                _drive_with(part), "".join(Path(part).suffixes), (sweep.parents[1] / part).read_bytes()
            )
            for part in parts
        }
    capture = written(lambda p: write_capture(p, [np.full((BEAMS, COLUMNS), 5000, np.uint32)]), ".pcap")
    packed = PCD[: PCD.index(b"ascii")] + b"binary_compressed\n" + struct.pack("<2I", 17, 16) + bytes([15, *range(16)])
    return {
        "bin": Reader(read_bin, ".bin", written(lambda p: write_bin(p, points, np.ones(100)), ".bin")),
        "nuscenes": Reader(read_pcd_bin, ".pcd.bin", np.ones((4, 5), "<f4").tobytes()),
        "lidarseg": Reader(lambda path: read_lidarseg(path, 4), ".bin", bytes([24, 17, 30, 0])),
        "label": Reader(
            lambda path: read_label(path, 4),
            ".label",
            written(lambda p: write_label(p, np.ones(4, np.uint8), np.ones(4, np.uint32)), ".label"),
        ),
        "labels": Reader(lambda path: read_labels(path, 4, of="a scan"), ".bin", np.ones(4, "<i8").tobytes()),
        "semantic map": Reader(lambda path: read_semantic_map(path, SENSOR), ".npy", npy(np.ones((3, 16), np.uint8))),
        "las": Reader(read_las, ".las", written(write_las, ".las")),
        "boxes of lines": Reader(read_custom_labels, ".txt", BOX_LINES),
        "box file": Reader(read_box_file, ".txt", BOX_LINES),
        "table": Reader(lambda path: read_table(path, ("token",)), ".json", b'[{"token": "a"}]'),
        "annotations": Reader(_annotations, ".json", ANNOTATIONS),
        "metadata": Reader(read_ouster_metadata, ".json", json.dumps(OUSTER).encode()),
        "pcd": Reader(read_pcd, ".pcd", PCD),
        "packed pcd": Reader(read_pcd, ".pcd", packed),
        "npy": Reader(read_carla, ".npy", npy(records)),
        "ply": Reader(read_carla, ".ply", PLY),
        "ply vertices": Reader(read_ply, ".ply", PLY),
        "ply points": Reader(_points, ".ply", _binary_ply(points)),
        "pcd points": Reader(_points, ".pcd", CLOUD),
        "las points": Reader(_points, ".las", written(write_las, ".las")),
        "npy points": Reader(_points, ".npy", npy(points)),
        "npy records": Reader(_points, ".npy", npy(records)),
        "bin points": Reader(_points, ".bin", written(lambda p: write_bin(p, points, np.ones(100)), ".bin")),
        "sweep points": Reader(_points, ".pcd.bin", np.ones((4, 5), "<f4").tobytes()),
        "carla points": Reader(_points, ".ply", PLY),
        "label_2": Reader(_label_2, ".txt", LABEL_2),
        "calib": Reader(_calib, ".txt", CALIB),
        "depth": Reader(read_npy, ".npy", npy(points)),
        "points": Reader(read_returns, ".npz", archive("xyz", npy(points))),
        "recording": Reader(read_recording, ".npz", archive("xyz", npy(points), "ring", npy(np.arange(100) // 10))),
        "pairs": Reader(_shard, ".npz", written(lambda p: _pairs(str(p.parent)).rename(p), ".npz")),
        "cast": Reader(read_cast, ".npz", written(image.save, ".npz")),
        "range image": Reader(RangeImage.load, ".npz", written(image.save, ".npz")),
        "layout": Reader(Layout.load, ".json", LAYOUT.to_json().encode()),
        "boxes": Reader(read_boxes, ".json", written(lambda p: write_boxes(p, LAYOUT.boxes(), [3]), ".json")),
        "sensor": Reader(Sensor.load, ".json", SENSOR.to_json().encode()),
        "intrinsics": Reader(read_intrinsics, ".json", b'{"K": [[9, 0, 4], [0, 9, 3], [0, 0, 1]]}'),
        "calibration": Reader(read_intrinsics, ".txt", b"P2: 9 0 4 0 0 9 3 0 0 0 1 0\n"),
        "obj": Reader(lidardraft.layout_from_obj, ".obj", written(lambda p: write_obj(p, LAYOUT), ".obj")),
        "glb": Reader(lidardraft.layout_from_glb, ".glb", written(lambda p: write_glb(p, LAYOUT), ".glb")),
        "world": Reader(WorldState.load, ".json", written(World(STREET, SENSOR).state().save, ".json")),
        "rig": Reader(Rig.load, ".json", written(Rig({"top": Mount(SENSOR, (0.0, 0.0, 1.8, 0.0))}).save, ".json")),
        "scenario": Reader(Scenario.load, ".json", SCENARIO.to_json().encode()),
        "recipe": Reader(Recipe.load, ".toml", RECIPE),
        "sentences": Reader(read_sentences, ".txt", b"a car ahead\n\na bus on the left\n"),
        "motion": Reader(read_motion, ".npz", written(lambda p: _pairs(str(p.parent)).rename(p), ".npz")),
        "weights": Reader(read_metadata, ".safetensors", save({"a": np.ones(3, np.float32)}, {"kind": "car"})),
        "blender": Reader(
            lidardraft.layout_from_blender, ".py", written(lambda p: write_blender_script(p, LAYOUT), ".py")
        ),
        "pickled table": Reader(_program, ".pkl", pandas_pickle(a=np.arange(3), b=np.array(["c", None, 1.5], object))),
        **drives,
        "capture": Reader(_capture, ".pcap", capture),
        "bag": Reader(_points, ".mcap", written(_bag, ".mcap")),
        "cloud": Reader(read_cloud, ".mcap", written(_bag, ".mcap")),
        "bag of sqlite": Reader(read_cloud, ".db3", written(_bag_of_sqlite, ".db3")),
        "way": Reader(ego_scenario, ".mcap", written(_bag, ".mcap")),
        "picture": Reader(read_picture, ".jpg", picture_bytes("jpeg")),
        "train ids": Reader(read_semantics, ".png", picture_bytes("png")),
        "masks": Reader(read_masks, ".npz", archive("masks", npy(np.ones((2, 3, 4), bool)))),
        "numbered masks": Reader(read_masks, ".png", written(Image.new("L", (9, 7), 3).save, ".png")),
        "painted sketch": Reader(sketch, ".png", picture_bytes("png")),
        "sketch of shapes": Reader(sketch, ".svg", SVG),
    }
