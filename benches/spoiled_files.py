"""Files that are spoiled in many ways: what each reader says of them, in what time and memory."""

from __future__ import annotations

import gzip
import io
import itertools
import json
import os
import resource
import struct
import sys
import tempfile
import time
import warnings
import zipfile
import zlib
from collections.abc import Callable, Iterator
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
from lidardraft.errors import LidarDraftError
from lidardraft.files import named, read_bytes, read_sentences
from lidardraft.formats.blender_script import write_blender_script
from lidardraft.formats.box_files import read_box_file, read_custom_labels
from lidardraft.formats.boxes import read_boxes, write_boxes
from lidardraft.formats.carla import read_carla
from lidardraft.formats.cast import read_cast
from lidardraft.formats.cityscapes import read_semantics
from lidardraft.formats.glb import glb_bytes, write_glb
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

SECONDS, BYTES = 2.0, 2**30  # that a reader may take of a processor and of memory
_MIB = 2**20
CAR = Primitive(shape="box", center=(9, 0, 1), size=(4, 2, 1.5), label="car", id="car_1", instance=1)
LAYOUT = Layout((CAR,), {"seed": 1})
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
    """Without the lines on what was applied."""
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
    return _written(lambda path: write_ply(path, records), ".ply")


def _pairs(folder: str) -> Path:
    """The first file of a folder of pairs."""
    image = lidardraft.raycast(LAYOUT, SENSOR)
    list(write_pairs(folder, [(Pair(image, image, image), {})]))
    return Path(folder, "00000.npz")


def _shard(path: Path) -> object:
    with tempfile.TemporaryDirectory() as folder, named(path):
        first = _pairs(folder)
        first.unlink()
        first.symlink_to(path.absolute())
        return read_shard(first)


def _las(path: Path) -> None:
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


def _written(write: Callable[[Path], object], ending: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{ending}"
        write(path)
        return path.read_bytes()


def _picture(kind: str, pixels: np.ndarray | None = None, **options: int) -> bytes:
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
    capture = _written(lambda p: write_capture(p, [np.full((BEAMS, COLUMNS), 5000, np.uint32)]), ".pcap")
    packed = PCD[: PCD.index(b"ascii")] + b"binary_compressed\n" + struct.pack("<2I", 17, 16) + bytes([15, *range(16)])
    return {
        "bin": Reader(read_bin, ".bin", _written(lambda p: write_bin(p, points, np.ones(100)), ".bin")),
        "nuscenes": Reader(read_pcd_bin, ".pcd.bin", np.ones((4, 5), "<f4").tobytes()),
        "lidarseg": Reader(lambda path: read_lidarseg(path, 4), ".bin", bytes([24, 17, 30, 0])),
        "label": Reader(
            lambda path: read_label(path, 4),
            ".label",
            _written(lambda p: write_label(p, np.ones(4, np.uint8), np.ones(4, np.uint32)), ".label"),
        ),
        "labels": Reader(lambda path: read_labels(path, 4, of="a scan"), ".bin", np.ones(4, "<i8").tobytes()),
        "semantic map": Reader(lambda path: read_semantic_map(path, SENSOR), ".npy", _npy(np.ones((3, 16), np.uint8))),
        "las": Reader(read_las, ".las", _written(_las, ".las")),
        "boxes of lines": Reader(read_custom_labels, ".txt", BOX_LINES),
        "box file": Reader(read_box_file, ".txt", BOX_LINES),
        "table": Reader(lambda path: read_table(path, ("token",)), ".json", b'[{"token": "a"}]'),
        "annotations": Reader(_annotations, ".json", ANNOTATIONS),
        "metadata": Reader(read_ouster_metadata, ".json", json.dumps(OUSTER).encode()),
        "pcd": Reader(read_pcd, ".pcd", PCD),
        "packed pcd": Reader(read_pcd, ".pcd", packed),
        "npy": Reader(read_carla, ".npy", _npy(records)),
        "ply": Reader(read_carla, ".ply", PLY),
        "ply vertices": Reader(read_ply, ".ply", PLY),
        "ply points": Reader(_points, ".ply", _binary_ply(points)),
        "pcd points": Reader(_points, ".pcd", CLOUD),
        "las points": Reader(_points, ".las", _written(_las, ".las")),
        "npy points": Reader(_points, ".npy", _npy(points)),
        "npy records": Reader(_points, ".npy", _npy(records)),
        "bin points": Reader(_points, ".bin", _written(lambda p: write_bin(p, points, np.ones(100)), ".bin")),
        "sweep points": Reader(_points, ".pcd.bin", np.ones((4, 5), "<f4").tobytes()),
        "carla points": Reader(_points, ".ply", PLY),
        "label_2": Reader(_label_2, ".txt", LABEL_2),
        "calib": Reader(_calib, ".txt", CALIB),
        "depth": Reader(read_npy, ".npy", _npy(points)),
        "points": Reader(read_returns, ".npz", _zip("xyz", _npy(points))),
        "recording": Reader(read_recording, ".npz", _zip("xyz", _npy(points), "ring", _npy(np.arange(100) // 10))),
        "pairs": Reader(_shard, ".npz", _written(lambda p: _pairs(str(p.parent)).rename(p), ".npz")),
        "cast": Reader(read_cast, ".npz", _written(image.save, ".npz")),
        "range image": Reader(RangeImage.load, ".npz", _written(image.save, ".npz")),
        "layout": Reader(Layout.load, ".json", LAYOUT.to_json().encode()),
        "boxes": Reader(read_boxes, ".json", _written(lambda p: write_boxes(p, LAYOUT.boxes(), [3]), ".json")),
        "sensor": Reader(Sensor.load, ".json", SENSOR.to_json().encode()),
        "intrinsics": Reader(read_intrinsics, ".json", b'{"K": [[9, 0, 4], [0, 9, 3], [0, 0, 1]]}'),
        "calibration": Reader(read_intrinsics, ".txt", b"P2: 9 0 4 0 0 9 3 0 0 0 1 0\n"),
        "obj": Reader(lidardraft.layout_from_obj, ".obj", _written(lambda p: write_obj(p, LAYOUT), ".obj")),
        "glb": Reader(lidardraft.layout_from_glb, ".glb", _written(lambda p: write_glb(p, LAYOUT), ".glb")),
        "world": Reader(WorldState.load, ".json", _written(World(LAYOUT, SENSOR).state().save, ".json")),
        "rig": Reader(Rig.load, ".json", _written(Rig({"top": Mount(SENSOR, (0.0, 0.0, 1.8, 0.0))}).save, ".json")),
        "scenario": Reader(Scenario.load, ".json", SCENARIO.to_json().encode()),
        "recipe": Reader(Recipe.load, ".toml", RECIPE),
        "sentences": Reader(read_sentences, ".txt", b"a car ahead\n\na bus on the left\n"),
        "motion": Reader(read_motion, ".npz", _written(lambda p: _pairs(str(p.parent)).rename(p), ".npz")),
        "weights": Reader(read_metadata, ".safetensors", save({"a": np.ones(3, np.float32)}, {"kind": "car"})),
        "blender": Reader(
            lidardraft.layout_from_blender, ".py", _written(lambda p: write_blender_script(p, LAYOUT), ".py")
        ),
        "pickled table": Reader(_program, ".pkl", pandas_pickle(a=np.arange(3), b=np.array(["c", None, 1.5], object))),
        **drives,
        "capture": Reader(_capture, ".pcap", capture),
        "bag": Reader(_points, ".mcap", _written(_bag, ".mcap")),
        "cloud": Reader(read_cloud, ".mcap", _written(_bag, ".mcap")),
        "bag of sqlite": Reader(read_cloud, ".db3", _written(_bag_of_sqlite, ".db3")),
        "way": Reader(ego_scenario, ".mcap", _written(_bag, ".mcap")),
        "picture": Reader(read_picture, ".jpg", _picture("jpeg")),
        "train ids": Reader(read_semantics, ".png", _picture("png")),
        "masks": Reader(read_masks, ".npz", _zip("masks", _npy(np.ones((2, 3, 4), bool)))),
        "numbered masks": Reader(read_masks, ".png", _written(Image.new("L", (9, 7), 3).save, ".png")),
        "painted sketch": Reader(sketch, ".png", _picture("png")),
        "sketch of shapes": Reader(sketch, ".svg", SVG),
    }


def spoilings(reader: Reader) -> Iterator[tuple[str, bytes]]:
    """Ways to spoil any file, by name, of less than two megabytes."""
    good, noise = reader.good, np.random.default_rng(0).bytes(4096)
    yield "empty", b""
    for share in (0.1, 0.5, 0.9):
        yield f"cut at {share:.0%}", good[: int(share * len(good))]
    yield "without its last byte", good[:-1]
    yield "random bytes", noise
    yield "another beginning", b"\x00\x01\x02\x03" + good[4:]
    yield "random bytes in its middle", good[: len(good) // 2] + noise[:64] + good[len(good) // 2 :]
    yield "ones in its middle", good[: len(good) // 2] + b"\xff" * 32 + good[len(good) // 2 + 32 :]
    yield "nan for numbers", good.replace(b"1", b"nan").replace(b"4", b"NaN")
    yield "infinite numbers", good.replace(b"1", b"1e999").replace(b"4", b"inf")
    yield "numbers of 5,000 digits", good.replace(b"4", b"4" * 5000)
    yield "not UTF-8", b"\xff\xfe\xfa" + good
    yield "UTF-16", good.decode("latin-1").encode("utf-16")
    yield "a byte order mark", b"\xef\xbb\xbf" + good
    yield "lines of Windows", good.replace(b"\n", b"\r\n")
    yield "zeros", bytes(4096)
    yield "twice", good + good
    yield "brackets", b"[" * _MIB
    yield "braces", b'{"a":' * 200_000


def large_spoilings() -> Iterator[tuple[str, bytes]]:
    """Files for any reader that take a while to make, by name."""
    yield "spaces", b" " * (100 * _MIB)
    yield "one long line", b"a" * (100 * _MIB)
    yield "many lines", b"v 1 2 3\n" * (12 * _MIB)
    yield "large and zero", bytes(120 * _MIB)


def _png(width: int, height: int, data: bytes = b"", kind: int = 2) -> bytes:
    def chunk(name: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))

    head = struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def _claim(shape: tuple[int, ...], zeros: int = 0) -> bytes:
    """An .npy file whose header claims much, and so many megabytes of zeros."""
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f4", "fortran_order": False, "shape": shape})
    return header.getvalue() + bytes(zeros * _MIB)


def _npy(array: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, array, allow_pickle=True)
    return buffer.getvalue()


def _zip(*members: str | bytes, kind: int = zipfile.ZIP_DEFLATED) -> bytes:
    """An archive of arrays: a name and the bytes of each."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", kind) as archive:
        for name, data in zip(members[::2], members[1::2], strict=True):
            archive.writestr(f"{name}.npy", data)
    return buffer.getvalue()


def special_files() -> Iterator[tuple[str, str, bytes]]:
    """Reader, name and bytes of files that are made against one format."""
    entities = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 10}">' for k in range(1, 7))
    bomb = f'<!DOCTYPE svg [<!ENTITY e0 "eeeeeeeeee">{entities}]><svg><text>&e6;</text></svg>'
    svg = {
        "a million entities": bomb.encode(),
        "an outside entity": b'<!DOCTYPE svg [<!ENTITY x SYSTEM "file:///etc/passwd">]><svg>&x;</svg>',
        "deep groups": b"<svg>" + b"<g>" * 200_000,
        "a million shapes": b"<svg>" + b"<rect/>" * 1_000_000 + b"</svg>",
        "a million commands": b'<svg><path d="M0 0' + b"c1 1 2 2 3 3" * 1_000_000 + b'"/></svg>',
        "a million points": b'<svg><polygon points="' + b"1,2 " * 1_000_000 + b'"/></svg>',
        "large shapes": b'<svg width="90" height="60">%s</svg>' % (b'<rect id="road" width="9000" height="2"/>' * 4000),
        "strokes without end": b'<svg><path id="wall" d="M0 0%s" stroke="red"/></svg>' % (b"l9 9l-9 0" * 14_000),
        "attributes": b"<svg><rect " + b" ".join(b'a%d=""' % k for k in range(200_000)) + b"/></svg>",
        "an endless number": b'<svg width="' + b"9" * 1_000_000 + b'"/>',
        "transforms": b'<svg><rect id="car" transform="' + b"scale(2)" * 200_000 + b'" width="1" height="1"/></svg>',
    }
    yield from (("sketch of shapes", name, data) for name, data in svg.items())
    rows = zlib.compress(bytes(10_001) * 1000)
    noise = np.random.default_rng(1).integers(0, 256, (1400, 1400, 3)).astype(np.uint8)
    stripes = np.full((1000, 1000, 3), 255, np.uint8)
    stripes[::6] = stripes[1::6] = stripes[2::6] = (102, 102, 156)
    checks = np.full((1400, 1400, 3), 255, np.uint8)
    checks[np.add.outer(np.arange(1400) // 4, np.arange(1400) // 4) % 2 > 0] = (0, 0, 142)
    pictures = {
        "100 megapixels": _png(10_000, 10_000, zlib.compress(bytes(10_001) * 10_000, 1), kind=0),
        "two billion pixels to a side": _png(2**31 - 1, 2**31 - 1, rows),
        "pixels that are not there": _png(5000, 5000, rows[:200]),
        "nothing": _png(0, 0),
        "a broken sum": _png(4, 4).replace(b"IDAT", b"zTXt", 1),
    }
    for name, data in pictures.items():
        yield "painted sketch", name, data
        yield "picture", name, data
    cells = np.kron(np.random.default_rng(3).integers(0, 2, (160, 160)), np.ones((6, 6)))
    maze = np.where(cells[..., None] > 0, (107, 142, 35), 255).astype(np.uint8)
    down, right = np.mgrid[-500:500, -500:500]
    turns = np.sin(np.hypot(right, down) / 12 + np.arctan2(down, right) / 2)
    spiral = np.where(np.abs(turns)[..., None] < 0.4, (128, 64, 128), 255).astype(np.uint8)
    drawn = {"noise": noise, "stripes": stripes, "checks": checks, "maze": maze, "spiral": spiral}
    for name, pixels in drawn.items():
        yield "painted sketch", name, _picture("png", pixels, compress_level=1)
    images = {
        "a bomb": _claim((35 * _MIB,), 140),
        "more than there is": _claim((2**40,)),
        "a pickle": _npy(np.array([print], dtype=object)),
        "text for numbers": _npy(np.array(["car"])),
    }
    for name, data in images.items():
        yield "cast", name, _zip("depth", data)
        yield "range image", name, _zip("depth", data)
        if name != "a bomb":
            yield "npy", name, data
    for name, text in (
        ("a deep header", "(" * 9000),
        ("a hundred axes", f"{{'descr': '<f4', 'fortran_order': False, 'shape': {(1,) * 100}}}"),
        ("an axis that is no number", "{'descr': '<f4', 'fortran_order': False, 'shape': (True,)}"),
    ):
        data = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode()
        yield "npy", name, data
        yield "depth", name, data
        yield "points", name, _zip("xyz", data)
    yield "points", "one label for all", _zip("xyz", _npy(np.ones((9, 3))), "label", _npy(np.array(1)))
    yield "points", "a field of many axes", _zip("xyz", _npy(np.ones((9, 3, 2))))
    yield "points", "packed slowly", _zip("xyz", _npy(np.ones((9, 3))), kind=zipfile.ZIP_LZMA)
    yield "sensor", "a long name", SENSOR.to_json().replace("few", "few" * 400_000).encode()
    yield "pickled table", "a call", b"\x80\x03cos\n_exit\n(K\x01tR."
    yield "pickled table", "a table of another pandas", b"\x80\x03cpandas.core.frame\nDataFrame\n)\x81."
    yield "pickled table", "nested tuples", b"\x80\x03)" + b"q\x00h\x00\x86" * 60 + b"q\x00}h\x00Ns."
    yield "pickled table", "a million lists", b"\x80\x03(" + b"]" * 2**20 + b"l."
    yield "pickled table", "a memory of thousands of millions", b"\x80\x03Nr\xff\xff\xff\x7f."
    yield "pickled table", "a text that is not there", b"\x80\x03B\xff\xff\xff\xff."
    yield "pickled table", "pointers for objects", pandas_pickle(a=np.arange(3)).replace(b"i8", b"O8")
    yield "pandaset lidar/00.pkl.gz", "a bomb", gzip.compress(bytes(80 * _MIB), 1)
    yield "layout", "two million fields", b"{" + b'"a":1,' * 2_000_000 + b'"a":1}'
    polygon = SVG.replace(b"<line", b'<polygon id="car" points="1 2 3"/><line')
    yield "sketch of shapes", "a polygon of one point", polygon
    counts = {"a trillion points": b"1000000000000", "no number of points": b"-2", "much text": b"9000000"}
    for name, points in counts.items():
        body = b"1 2\n" * (9_000_000 if name == "much text" else 2)
        yield "pcd", name, PCD[: PCD.index(b"POINTS")] + b"POINTS " + points + b"\nDATA ascii\n" + body
    packed = PCD[: PCD.index(b"DATA")].replace(b"POINTS 2", b"POINTS 500000000") + b"DATA binary_compressed\n"
    yield "pcd", "a bomb", packed + struct.pack("<2I", 8, 2**32 - 1) + b"\xe0\xff\x00" * 8
    yield from _models()
    many = ",".join(
        f'{{"shape":"box","center":[{k},0,1],"size":[4,2,1],"label":"car","id":"c{k}"}}' for k in range(400_000)
    )
    yield "layout", "400,000 shapes", f'{{"schema":"lidardraft.layout/1","primitives":[{many}]}}'.encode()
    deep = '{"a":' * 900 + "1" + "}" * 900
    yield "layout", "a deep provenance", LAYOUT.to_json().replace('{"seed": 1}', deep).encode()
    yield "bin", "points that are no numbers", np.full((99, 4), np.nan, "<f4").tobytes()
    yield "bin", "points infinitely far", np.full((99, 4), np.inf, "<f4").tobytes()
    las = bytearray(_written(_las, ".las"))
    las[100:104] = b"\xff" * 4
    yield "las", "four thousand million records", bytes(las)
    yield "label", "more labels than points", bytes(4 * 10_000)


def _models() -> Iterator[tuple[str, str, bytes]]:
    yield "obj", "vertices that are no numbers", b"o car\nv nan 0 0\nv 1 0 0\nv 0 1 1e999\nf 1 2 3\n"
    yield "obj", "a face of no vertices", b"o car\nv 0 0 0\nf 1 2 999999999999\n"
    yield "obj", "a face of a million corners", b"o car\nv 0 0 0\nv 1 0 0\nv 0 1 1\nf" + b" 1 2 3" * 400_000 + b"\n"
    car_of = b"o car_%d\nv 0 0 0\nv 1 0 0\nv 0 1 1\nf -3 -2 -1\n"
    for count in (200_000, 65_000):
        yield "obj", f"{count:,} objects", b"".join(car_of % k for k in range(count))
    triangle = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 1)], "<f4").tobytes()

    def glb(nodes: list[dict[str, object]], count: int = 3, **more: object) -> bytes:
        document = {
            "asset": {"version": "2.0"},
            "buffers": [{"byteLength": 36}],
            "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "scenes": [{"nodes": [0]}],
            "nodes": nodes,
        }
        return glb_bytes(document | more, triangle)

    car: dict[str, object] = {"name": "car", "mesh": 0}
    yield "glb", "a circle of nodes", glb([{**car, "children": [0]}])
    yield "glb", "nodes that double", glb([{"name": "car", "children": [k + 1, k + 1]} for k in range(60)] + [car])
    yield "glb", "more vertices than there are", glb([car], count=2**31)
    yield "glb", "vertices that are no numbers", glb([car]).replace(triangle, np.full((3, 3), np.nan, "<f4").tobytes())
    parts = [{"attributes": {"POSITION": 0}}] * 200_000
    yield "glb", "200,000 parts of one mesh", glb([car], meshes=[{"primitives": parts}])
    yield "glb", "a rotation of zeros", glb([{**car, "rotation": [0, 0, 0, 0]}])
    yield "glb", "another file", glb([car], buffers=[{"uri": "/dev/zero", "byteLength": 36}])
    yield "glb", "a length that is too long", glb([car])[:8] + struct.pack("<I", 2**32 - 1) + glb([car])[12:]
    many = [{"name": f"car_{k}", "mesh": 0, "translation": [k, 0, 0]} for k in range(19_000)]
    yield "glb", "19,000 nodes", glb(many, scenes=[{"nodes": list(range(19_000))}])
    yield "glb", "100,000 nodes", glb(many * 5, scenes=[{"nodes": list(range(95_000))}])


def odd_paths(folder: Path, ending: str) -> Iterator[tuple[str, Path]]:
    """What lies at a path and is no file that can be read."""
    names = ("pipe", "folder", "device", "empty device", "loop", "locked", "6 GB", "missing")
    pipe, inner, device, empty, loop, locked, large, missing = paths = [folder / f"{name}{ending}" for name in names]
    os.mkfifo(pipe)
    inner.mkdir()
    device.symlink_to("/dev/zero")
    empty.symlink_to("/dev/null")
    loop.symlink_to(loop)
    locked.write_bytes(b"\0")
    locked.chmod(0)
    large.touch()
    os.truncate(large, 6 * 2**30)
    assert not missing.exists()
    yield from zip(names, paths, strict=True)


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a reader said of a file (None where it read it; an error's name where it is none of ours), the processor
    time [s] it took, and the memory [bytes] beyond what there was before."""

    reader: str
    file: str
    said: str | None
    seconds: float
    memory: int
    clear: bool


def outcome(name: str, file: str, read: Callable[[Path], object], path: Path) -> Outcome:
    """What comes of reading a file, in a process of its own that may take 30 s and 4 GB more than this one."""
    into, out = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(into)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        used = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
        resource.setrlimit(resource.RLIMIT_AS, (used + 4 * 2**30,) * 2)
        resource.setrlimit(resource.RLIMIT_CPU, (30, 30))
        before, begun = _resident(), time.process_time()
        try:
            read(path)
            said, clear = "", True
        except LidarDraftError as error:
            said, clear = f"{type(error).__name__}: {error}", path.name in str(error) and "\n" not in str(error)
        except BaseException as error:
            said, clear = f"{type(error).__name__}: {error}", False
        took = time.process_time() - begun
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
        os.write(out, f"{took:.6f} {max(0, peak - before)} {int(clear)} {said[:900]}".encode("utf-8", "replace"))
        os._exit(0)
    os.close(out)
    with os.fdopen(into, "rb") as pipe:
        answer = pipe.read().decode("utf-8", "replace")
    os.waitpid(child, 0)
    if not answer:
        return Outcome(name, file, "killed: more than 30 s or 4 GB", 30.0, 4 * 2**30, False)
    seconds, memory, clear_, said_ = answer.split(" ", 3)
    return Outcome(name, file, said_ or None, float(seconds), int(memory), clear_ == "1")


def _resident() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def outcomes(folder: Path, only: str = "") -> Iterator[Outcome]:
    """What comes of every file, or of those of one reader; each is taken away again."""
    known = readers()
    for name, reader in known.items():
        if only in ("", name):
            for file, data in itertools.chain(spoilings(reader), large_spoilings()):
                path = folder / f"spoiled{reader.ending}"
                path.write_bytes(data)
                yield outcome(name, file, reader.read, path)
                path.unlink()
            with tempfile.TemporaryDirectory(dir=folder) as inner:
                for file, path in odd_paths(Path(inner), reader.ending):
                    yield outcome(name, file, reader.read, path)
    for name, file, data in special_files():
        if only in ("", name):
            path = folder / f"special{known[name].ending}"
            path.write_bytes(data)
            yield outcome(name, file, known[name].read, path)
            path.unlink()


def main() -> None:
    """Print a line for each file, worst last."""
    with tempfile.TemporaryDirectory() as folder:
        found = sorted(outcomes(Path(folder), *sys.argv[1:2]), key=lambda each: (not each.clear, each.seconds))
    for each in found:
        print(f"{each.seconds:7.3f} s {each.memory / _MIB:7.0f} MB {each.reader}, {each.file}: {str(each.said)[:160]}")
    print(f"{len(found)} files; not clear: {sum(not each.clear for each in found)}")


if __name__ == "__main__":
    main()
