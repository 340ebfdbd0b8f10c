"""Whatever lies at a path, its reader gives what it holds, or one error of ours that names it."""

import json
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from PIL import Image

from lidardraft.drafting.blender.layout import layout_from_blender
from lidardraft.drafting.models import layout_from_glb, layout_from_obj
from lidardraft.drafting.sketch import layout_from_sketch
from lidardraft.drafting.solver.scene_spec import SceneSpec
from lidardraft.errors import LidarDraftError
from lidardraft.formats.blender_script import write_blender_script
from lidardraft.formats.boxes import read_boxes, write_boxes
from lidardraft.formats.carla import read_carla
from lidardraft.formats.cast import read_cast
from lidardraft.formats.cityscapes import read_semantics
from lidardraft.formats.glb import write_glb
from lidardraft.formats.intrinsics import read_intrinsics
from lidardraft.formats.kitti import read_bin, write_bin
from lidardraft.formats.masks import read_masks
from lidardraft.formats.npy import read_npy
from lidardraft.formats.nuscenes import read_pcd_bin
from lidardraft.formats.pcd import read_pcd
from lidardraft.formats.picture import read_picture
from lidardraft.formats.semantickitti import read_label, write_label
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor

SENSOR = Sensor(name="few", elevations=(0.1, 0.0, -0.1), columns=16)
CAR = Primitive(shape="box", center=(9, 0, 1), size=(4, 2, 1.5), label="car", id="car_1", instance=1)
POINTS = np.linspace(-1, 1, 12, dtype=np.float32).reshape(4, 3)
SVG = """<svg width="90" height="60"><g id="road" transform="scale(2)">
<path d="M0 1 c1 2 3 4 9 9" stroke-width="3mm"/></g>
<rect id="car" x="4" y="9" width="2" height="4"/><line id="scale 10 m" x2="10"/></svg>"""
PCD = "FIELDS x ring\nSIZE 4 2\nTYPE F U\nCOUNT 1 1\nPOINTS 2\nDATA"


def write_pcd(path: Path) -> None:
    path.write_bytes(f"{PCD} ascii\n1 2\n3 4\n".encode())


def write_packed_pcd(path: Path) -> None:
    path.write_bytes(f"{PCD} binary_compressed\n".encode() + bytes([13, 0, 0, 0, 12, 0, 0, 0, 11, *range(12)]))


def write_obj(path: Path) -> None:
    path.write_text("o car\nv 0 0 0\nv 4 0 0\nv 0 2 1\nf 1 2 3\n")


def write_ply(path: Path) -> None:
    fields = ["float32 x", "float32 y", "float32 z", "float32 CosAngle", "uint32 ObjIdx", "uint32 ObjTag"]
    head = ["ply", "format ascii 1.0", "element vertex 2", *(f"property {field}" for field in fields), "end_header"]
    path.write_text("\n".join([*head, "9.0000 1.0000 -1.5000 0.5000 7 14", "4.0 -2.0 -1.7 0.3 0 24", ""]))


def write_carla_records(path: Path) -> None:
    fields = [*((name, "<f4") for name in ("x", "y", "z", "CosAngle")), ("ObjIdx", "<u4"), ("ObjTag", "<u4")]
    np.save(path, np.array([(9, 1, -1.5, 0.5, 7, 14)], fields))


def write_painting(path: Path) -> None:
    Image.new("RGB", (9, 7), (0, 0, 142)).save(path)


# What reads a file, the ending it goes by, and what writes one.
READERS: dict[str, tuple[Callable[[Path], object], str, Callable[[Path], object]]] = {
    "bin": (read_bin, ".bin", lambda path: write_bin(path, POINTS, np.ones(4))),
    "nuscenes": (read_pcd_bin, ".pcd.bin", lambda path: np.ones((4, 5), "<f4").tofile(path)),
    "label": (
        lambda path: read_label(path, 4),
        ".label",
        lambda path: write_label(path, np.ones(4, np.uint8), np.ones(4, np.uint32)),
    ),
    "pcd": (read_pcd, ".pcd", write_pcd),
    "packed pcd": (read_pcd, ".pcd", write_packed_pcd),
    "obj": (layout_from_obj, ".obj", write_obj),
    "glb": (layout_from_glb, ".glb", lambda path: write_glb(path, Layout((CAR,), {"seed": 1}))),
    "blender script": (layout_from_blender, ".py", lambda path: write_blender_script(path, Layout((CAR,)))),
    "jpeg": (read_picture, ".jpg", lambda path: Image.new("RGB", (9, 7), (1, 2, 3)).save(path)),
    "png": (read_picture, ".png", lambda path: Image.new("RGB", (9, 7), (1, 2, 3)).save(path)),
    "painted sketch": (lambda path: layout_from_sketch(path, metres_per_pixel=0.5), ".png", write_painting),
    "sketch of shapes": (layout_from_sketch, ".svg", lambda path: path.write_text(SVG)),
    "boxes": (read_boxes, ".json", lambda path: write_boxes(path, Layout((CAR,)).boxes(), [3])),
    "layout": (Layout.load, ".json", Layout((CAR,), {"seed": 1}, (-1.0, 1.0)).save),
    "sensor": (Sensor.load, ".json", lambda path: path.write_text(SENSOR.to_json())),
    "carla ply": (read_carla, ".ply", write_ply),
    "carla npy": (read_carla, ".npy", write_carla_records),
    "train ids": (read_semantics, ".png", lambda path: Image.new("L", (9, 7), 3).save(path)),
    "masks": (read_masks, ".npz", lambda path: np.savez(path, masks=np.ones((2, 3, 4), bool))),
    "numbered masks": (read_masks, ".png", lambda path: Image.new("L", (9, 7), 3).save(path)),
    "intrinsics": (read_intrinsics, ".json", lambda path: path.write_text('{"K": [[9, 0, 4], [0, 9, 3], [0, 0, 1]]}')),
    "calibration": (read_intrinsics, ".txt", lambda path: path.write_text("P2: 9 0 4 0 0 9 3 0 0 0 1 0\n")),
    "npy": (read_npy, ".npy", lambda path: np.save(path, POINTS)),
    "cast": (read_cast, ".npz", raycast(Layout((CAR,)), SENSOR).save),
    "range image": (RangeImage.load, ".npz", raycast(Layout((CAR,)), SENSOR).save),
}
readers = pytest.mark.parametrize("name", READERS)
files = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def refusal(reader: Callable[..., object], *arguments: object) -> str | None:
    """What the reader said of a file that it refused; None where it read it."""
    try:
        reader(*arguments)
    except LidarDraftError as error:
        return str(error)
    return None


def read_or_named(name: str, path: Path) -> None:
    said = refusal(READERS[name][0], path)
    assert said is None or (path.name in said and said.isprintable())


@readers
def test_what_is_written_is_read(tmp_path: Path, name: str) -> None:
    path = tmp_path / f"a{READERS[name][1]}"
    READERS[name][2](path)
    assert refusal(READERS[name][0], path) is None


@readers
def test_what_is_no_file_is_refused_at_once(tmp_path: Path, name: str) -> None:
    ending = READERS[name][1]
    os.mkfifo(tmp_path / f"pipe{ending}")
    (tmp_path / f"folder{ending}").mkdir()
    (tmp_path / f"link{ending}").symlink_to("/dev/null")
    for stem in ("pipe", "folder", "link", "none", "none\x1b[31m"):
        path = tmp_path / f"{stem}{ending}"
        with pytest.raises(LidarDraftError, match=r"No such file|it must be a regular file"):
            READERS[name][0](path)


@readers
@files
@given(data=st.binary(max_size=400))
@example(data=b"")
def test_bytes_that_mean_nothing(tmp_path: Path, name: str, data: bytes) -> None:
    path = tmp_path / f"a{READERS[name][1]}"
    path.write_bytes(data)
    read_or_named(name, path)


@readers
@files
@given(
    edits=st.lists(
        st.tuples(
            st.floats(0, 1),
            st.integers(0, 9),
            st.one_of(
                st.binary(max_size=6),
                st.sampled_from(
                    [
                        b"9" * 400,
                        b"9" * 5000,
                        b"-1",
                        b"nan",
                        b"1e999",
                        b"[]",
                        b"{}",
                        b"null",
                        b'"',
                        b"\x00" * 8,
                        b"\xff" * 8,
                    ]
                ),
            ),
        ),
        min_size=1,
        max_size=4,
    )
)
def test_files_with_errors_in_them(tmp_path: Path, name: str, edits: list[tuple[float, int, bytes]]) -> None:
    path = tmp_path / f"a{READERS[name][1]}"
    READERS[name][2](path)
    data = path.read_bytes()
    for share, gone, put in edits:
        at = int(share * len(data))
        data = data[:at] + put + data[at + gone :]
    path.write_bytes(data)
    read_or_named(name, path)


VALUES = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(),
        st.sampled_from([10**400, -(10**400), 1e308, 2**63, float("nan"), float("inf"), "", "car", "box", "\x1b[31m"]),
        st.floats(),
        st.text(max_size=5),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.sampled_from(["id", "x", "kind"]), inner, max_size=3)
    ),
    max_leaves=8,
)
DOCUMENTS: dict[str, tuple[Callable[[str], object], dict[str, object]]] = {
    "layout": (Layout.from_json, json.loads(Layout((CAR,), {"seed": 1}, (-1.0, 1.0)).to_json())),
    "sensor": (Sensor.from_json, json.loads(SENSOR.to_json())),
    "spec": (
        SceneSpec.from_json,
        {
            "road": {"kind": "bend", "lanes": 2, "sidewalk": True},
            "groups": [{"kind": "car", "count": 3, "places": ["front"], "distance": [3.0, 9.0], "spacing": 2.0}],
            "absent": ["bus"],
            "not_understood": ["sky"],
        },
    ),
}


@pytest.mark.parametrize("name", DOCUMENTS)
@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_documents_with_other_values_in_them(name: str, data: st.DataObject) -> None:
    parse, document = DOCUMENTS[name]
    document = json.loads(json.dumps(document))
    target: object = document
    while True:  # down to a place of any depth
        keys = list(target) if isinstance(target, dict) else list(range(len(target)))  # type: ignore[arg-type]
        key = data.draw(st.sampled_from(keys))
        inner = target[key]  # type: ignore[index]
        if isinstance(inner, dict | list) and inner and data.draw(st.booleans()):
            target = inner
            continue
        target[key] = data.draw(VALUES)  # type: ignore[index]
        break
    said = refusal(parse, json.dumps(document))
    assert said is None or said.isprintable()
