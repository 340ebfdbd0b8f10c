"""Binary glTF, and the layouts in it."""

import base64
import dataclasses
import json
import math
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exported_layouts import EVERYTHING, drafted

from lidardraft.drafting.models import layout_from_glb
from lidardraft.errors import FormatError, LayoutError
from lidardraft.formats.glb import GlbFile, glb_bytes, glb_of, parse_glb, write_glb
from lidardraft.scene.layout import Layout, Primitive, primitive_mesh
from lidardraft.scene.mesh import unit_mesh

BOX = unit_mesh("box")


def document(*nodes: dict[str, Any], **more: Any) -> tuple[dict[str, Any], bytes]:
    """A file of a box of 1 m, which the nodes use."""
    vertices, faces = BOX.vertices.astype("<f4").tobytes(), BOX.faces.astype("<u2").tobytes()
    return {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": list(nodes),
        "meshes": [{"name": "Cube", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 8},
            {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 36},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(vertices)},
            {"buffer": 0, "byteOffset": len(vertices), "byteLength": len(faces)},
        ],
        "buffers": [{"byteLength": len(vertices) + len(faces)}],
        **more,
    }, vertices + faces


def read(tmp_path: Path, *nodes: dict[str, Any], classes: dict[str, str] | None = None, **more: Any) -> Layout:
    path = tmp_path / "a.glb"
    path.write_bytes(glb_bytes(*document(*nodes, **more)))
    return layout_from_glb(path, classes=classes)


@pytest.mark.parametrize("layout", [EVERYTHING, *drafted()])
def test_a_layout_comes_back_but_for_float32(tmp_path: Path, layout: Layout) -> None:
    """Places and sizes to 1e-9 m, angles to 1e-9 rad; vertices of meshes to float32."""
    write_glb(tmp_path / "a.glb", layout)
    found = layout_from_glb(tmp_path / "a.glb")
    assert (found.provenance, found.coverage, len(found)) == (layout.provenance, layout.coverage, len(layout))
    for was, is_ in zip(layout, found, strict=True):
        if was.id == "cone":  # a cylinder under the name of a mesh
            assert is_.shape == "cylinder"
            is_ = dataclasses.replace(is_, shape="mesh", mesh=was.mesh)
        for name in ("shape", "label", "id", "instance", "material", "extinction", "open"):
            assert getattr(was, name) == getattr(is_, name)
        off = 1e-9 if was.mesh is None else 1e-6 * max(was.size)
        np.testing.assert_allclose(
            primitive_mesh(was).vertices.min(axis=0), primitive_mesh(is_).vertices.min(axis=0), atol=off
        )
        np.testing.assert_allclose(
            primitive_mesh(was).vertices.max(axis=0), primitive_mesh(is_).vertices.max(axis=0), atol=off
        )
        assert math.remainder(was.yaw - is_.yaw, math.tau) == pytest.approx(0, abs=1e-9 if was.mesh is None else 1e-6)


def test_nodes_place_their_meshes_one_below_the_other(tmp_path: Path) -> None:
    """glTF's y is up: 2 above the parent is 2 m higher, and its -z is our y."""
    half = math.sqrt(0.5)
    layout = read(
        tmp_path,
        {"name": "Cars", "children": [1, 2], "translation": [10, 0, -3]},
        {"name": "Car.001", "mesh": 0, "translation": [1, 2, 0], "scale": [4, 1, 2]},
        {"name": "Cube", "mesh": 0, "rotation": [0, half, 0, half], "scale": [4, 1, 2]},
    )
    first, second = layout
    assert (first.id, first.label, first.instance) == ("Car_001", "car", 1)
    np.testing.assert_allclose(first.center, (11, 3, 2), atol=1e-12)
    np.testing.assert_allclose(first.size, (4, 2, 1), atol=1e-12)
    assert (second.id, second.label, second.instance) == ("Cube", "car", 2)
    assert second.yaw == pytest.approx(math.pi / 2)
    assert first.shape == second.shape == "box"


def test_a_matrix_is_a_transform_too(tmp_path: Path) -> None:
    matrix = [4, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]
    (box,) = read(tmp_path, {"name": "bus", "mesh": 0, "matrix": matrix})
    assert (box.center, box.size) == ((5, -7, 6), (4, 1, 2))


def test_classes_come_from_extras_names_and_materials(tmp_path: Path) -> None:
    materials = {"materials": [{"name": "mat_building"}]}
    part = {"attributes": {"POSITION": 0}, "indices": 1, "material": 0}
    meshes = {"meshes": [{"primitives": [part]}]}
    (found,) = read(tmp_path, {"name": "Blob", "mesh": 0}, **materials, **meshes)
    assert (found.label, found.instance) == ("building", 0)
    extras = {"class": "truck", "id": "lorry.cab", "instance": 9, "unknown": 5}
    (found,) = read(tmp_path, {"name": "Blob", "mesh": 0, "extras": extras})
    assert (found.label, found.id, found.instance) == ("truck", "lorry.cab", 9)
    (found,) = read(tmp_path, {"name": "Blob.003", "mesh": 0}, classes={"Blob": "wall"})
    assert found.label == "wall"
    with pytest.raises(LayoutError, match=r"a.glb: no class for Blob; say which by --class NAME=CLASS"):
        read(tmp_path, {"name": "Blob", "mesh": 0})
    with pytest.raises(LayoutError, match=r"Blob: label is 'unicorn'|label is 'unicorn'"):
        read(tmp_path, {"name": "Blob", "mesh": 0, "extras": {"class": "unicorn"}})


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "needs extensions that are not read, .*draco"),
        ({"buffers": [{"uri": "http://x/a.bin", "byteLength": 168}]}, "in another file .export it as glTF Binary"),
        ({"buffers": [{"byteLength": 168}, {"byteLength": 5}]}, "in another file .export it as glTF Binary"),
        ({"buffers": [{"uri": "data:;base64,%%%", "byteLength": 5}]}, "not base64: "),
        ({"buffers": [{"uri": "data:text/plain,abc", "byteLength": 3}]}, "in another file"),
        ({"bufferViews": [{"buffer": 1, "byteLength": 9}]}, "buffer 1 is not there; the file has 1"),
        ({"nodes": [{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {}}}]}, "node 0 has EXT_mesh_gpu_instancing"),
        ({"nodes": [{"name": "car", "mesh": 7}]}, "meshes 7 is not there; the file has 1"),
        ({"nodes": [{"name": "car", "mesh": 0, "children": [0]}]}, "a circle of nodes"),
        ({"nodes": [{"name": "car", "mesh": 0, "translation": [1, 2]}]}, r"translation of a node is \[1, 2\]"),
        ({"nodes": [{"name": "car", "mesh": 0, "rotation": [0, 0, 0, 0]}]}, "a rotation of zeros"),
        ({"nodes": [{"name": "car", "mesh": 0, "scale": [1e300, 1, 1]}]}, "scale of a node is .* up to 1e9"),
        ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}] * 20_001}]}, "more than 20000 meshes, or parts"),
        ({"nodes": [{"name": "car"}]}, "the file has no triangles"),
        ({"nodes": 5}, "nodes is 5; it must be a list"),
        ({"scenes": [{"nodes": "all"}]}, "nodes is 'all'; it must be a list"),
        ({"scene": 3}, "scenes 3 is not there"),
        ({"meshes": [{"primitives": [{"attributes": {"POSITION": 1}}]}]}, "accessor 1 is no VEC3"),
        ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 0}]}]}, "accessor 0 is no SCALAR"),
        ({"meshes": [{"primitives": [{"attributes": {}}]}]}, "accessors None is not there"),
    ],
)
def test_what_is_not_read_gets_one_line(tmp_path: Path, change: dict[str, Any], said: str) -> None:
    node = {"name": "car", "mesh": 0}
    with pytest.raises(FormatError, match=rf"a\.glb: .*{said}"):
        read(tmp_path, node, **change)


def test_a_file_that_is_not_there_is_named_once() -> None:
    with pytest.raises(FormatError, match=r"^none\.glb: No such file or directory$"):
        layout_from_glb("none.glb")


@pytest.mark.parametrize(
    ("accessor", "said"),
    [
        ({"sparse": {"count": 1}}, "accessor 0 is sparse; only plain ones are read"),
        ({"componentType": 5123}, "positions must be float32"),
        ({"count": 10**9}, "accessor 0 of 1000000000 values reaches to byte"),
        ({"count": -1}, "count is -1; it must be a whole number"),
        ({"componentType": [5126]}, "accessor 0 is no VEC3 of numbers"),
        ({"byteOffset": 10**9}, "reaches to byte"),
        ({"count": 7}, r"face \d+ is .*; the mesh has 7 vertices"),
    ],
)
def test_accessors_stay_within_the_file(tmp_path: Path, accessor: dict[str, Any], said: str) -> None:
    fields, _ = document({})
    accessors = [{**fields["accessors"][0], **accessor}, fields["accessors"][1]]
    with pytest.raises((FormatError, LayoutError), match=rf"a\.glb: .*{said}"):
        read(tmp_path, {"name": "car", "mesh": 0}, accessors=accessors)


def test_scales_that_multiply_without_end(tmp_path: Path) -> None:
    nodes = [{"name": "car", "children": [k + 1], "scale": [1e9] * 3} for k in range(40)] + [{"name": "car", "mesh": 0}]
    with pytest.raises(LayoutError, match=r"a\.glb: car.car: a transform or an extent is larger than"):
        read(tmp_path, *nodes)


def test_a_number_that_is_none_in_a_vertex(tmp_path: Path) -> None:
    fields, binary = document({"name": "car", "mesh": 0})
    (tmp_path / "a.glb").write_bytes(glb_bytes(fields, np.float32(np.nan).tobytes() + binary[4:]))
    with pytest.raises(LayoutError, match=r"a.glb: car: vertex 0 of a mesh is \[nan"):
        layout_from_glb(tmp_path / "a.glb")


def test_copies_of_an_asset_are_things_of_their_own(tmp_path: Path) -> None:
    """As Blender writes the instances of a collection: the same names below one node for each."""
    cars = [{"name": f"Car_{k}", "children": [3 + k, 6 + k], "translation": [9 * k, 0, 0]} for k in range(3)]
    parts = [{"name": name, "mesh": 0} for name in ("Body", "Roof") for _ in range(3)]
    layout = read(tmp_path, *cars, *parts, scenes=[{"nodes": [0, 1, 2]}])
    assert [(p.id, p.instance, p.center[0]) for p in layout] == [
        (f"Car_{k}.{part}", k + 1, 9 * k) for k in range(3) for part in ("Body", "Roof")
    ]


def test_nodes_of_one_name_are_things_of_their_own(tmp_path: Path) -> None:
    layout = read(tmp_path, {"name": "Car", "mesh": 0}, {"name": "Car", "mesh": 0}, scenes=[{"nodes": [0, 1]}])
    assert [(p.id, p.instance) for p in layout] == [("Car", 1), ("Car_2", 2)]
    parts = [{"name": f"Car_1_{part}", "mesh": 0} for part in ("Body", "Wheel")]
    assert [p.instance for p in read(tmp_path, *parts, scenes=[{"nodes": [0, 1]}])] == [1, 1]


def test_properties_of_a_mesh_are_those_of_its_nodes(tmp_path: Path) -> None:
    meshes = [
        {"name": "wall", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}], "extras": {"class": "bus"}}
    ]
    assert read(tmp_path, {"mesh": 0}, meshes=meshes).primitives[0].label == "bus"
    assert read(tmp_path, {"mesh": 0, "extras": {"class": "car"}}, meshes=meshes).primitives[0].label == "car"


def test_the_axis_that_points_up(tmp_path: Path) -> None:
    node = {"name": "wall", "mesh": 0, "translation": [1, 2, 3], "scale": [4, 5, 6]}
    (up_y,) = read(tmp_path, node)
    assert (up_y.center, up_y.size) == ((1, -3, 2), (4, 6, 5))
    (up_z,) = layout_from_glb(tmp_path / "a.glb", up="z")
    assert (up_z.center, up_z.size) == ((1, 2, 3), (4, 5, 6))
    with pytest.raises(LayoutError, match="up is 'x'; it must be 'y' or 'z'"):
        layout_from_glb(tmp_path / "a.glb", up="x")


def test_gltf_as_text_with_its_buffers_in_it(tmp_path: Path) -> None:
    fields, binary = document({"name": "car", "mesh": 0})
    uri = "data:application/octet-stream;base64," + base64.b64encode(binary).decode()
    fields["buffers"] = [{"uri": uri, "byteLength": len(binary)}]
    (tmp_path / "a.gltf").write_text(" " + json.dumps(fields))
    (tmp_path / "b.glb").write_bytes(glb_bytes(fields, b""))
    (box,), (same,) = (layout_from_glb(tmp_path / name) for name in ("a.gltf", "b.glb"))
    assert box == same
    assert (box.shape, box.size) == ("box", (1, 1, 1))


def test_the_name_of_a_mesh_says_the_class_where_no_other_does(tmp_path: Path) -> None:
    """Most meshes are called "Cube": what `classes` says of that is not said of a node whose name says its class."""
    assert read(tmp_path, {"name": "Wall", "mesh": 0}, classes={"Cube": "car"}).primitives[0].label == "wall"
    assert read(tmp_path, {"name": "Blob", "mesh": 0}, classes={"Cube": "car"}).primitives[0].label == "car"


def test_shapes_stand_upright_along_y_as_along_z(tmp_path: Path) -> None:
    """Exporters turn the vertices, and write no rotation; or they write one, and leave the vertices as they are."""
    cylinder = unit_mesh("cylinder")
    quarter = [math.sqrt(0.5), 0, 0, math.sqrt(0.5)]
    for turn, rotation in (([0, 2, 1], [0, 0, 0, 1]), ([0, 1, 2], quarter)):
        fields, _ = document({"name": "pole", "mesh": 0, "rotation": rotation, "translation": [1, 2, 3]})
        vertices = cylinder.vertices[:, turn].astype("<f4").tobytes()
        faces = cylinder.faces.astype("<u2").tobytes()
        fields["accessors"][0]["count"], fields["accessors"][1]["count"] = len(cylinder.vertices), cylinder.faces.size
        fields["bufferViews"][1]["byteOffset"] = len(vertices)
        (tmp_path / "a.glb").write_bytes(glb_bytes(fields, vertices + faces))
        (pole,) = layout_from_glb(tmp_path / "a.glb")
        assert (pole.shape, pole.center) == ("cylinder", pytest.approx((1, -3, 2)))


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "no GLB: 0 bytes"),
        (b"glTF" + bytes(20), "glTF 0; version 2 is read"),
        (b"PK\3\4" + bytes(20), "it does not begin with glTF"),
        (struct.pack("<5I", 0x46546C67, 2, 999, 4, 0x4E4F534A) + b"{}  ", "a broken GLB: its header says 999"),
        (struct.pack("<5I", 0x46546C67, 2, 24, 99, 0x4E4F534A) + b"{}  ", "99 of JSON"),
        (struct.pack("<5I", 0x46546C67, 2, 24, 4, 0x4E4F534A) + b"[]  ", "is not a JSON object"),
        (
            glb_bytes({}, b"1234").replace(struct.pack("<2I", 4, 0x004E4942), struct.pack("<2I", 99, 0x004E4942)),
            "its second chunk says 99 bytes",
        ),
    ],
)
def test_broken_containers(data: bytes, said: str) -> None:
    with pytest.raises(FormatError, match=said):
        parse_glb(data)


def test_arrays_with_a_stride() -> None:
    values = np.arange(12, dtype="<f4").tobytes()
    document = {
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 2, "byteOffset": 4}],
        "bufferViews": [{"buffer": 0, "byteStride": 20, "byteLength": 48}],
    }
    assert GlbFile(document, (memoryview(values),)).array(0, "VEC3").tolist() == [[1, 2, 3], [6, 7, 8]]
    document["bufferViews"][0]["byteStride"] = 4
    with pytest.raises(FormatError, match="accessor 0 of 2 values"):
        GlbFile(document, (memoryview(values),)).array(0, "VEC3")


def test_of_the_extensions_only_those_that_are_not_read_are_named() -> None:
    needed = ["KHR_materials_unlit", "KHR_draco_mesh_compression"]
    with pytest.raises(FormatError, match=r"extensions that are not read, \['KHR_draco_mesh_compression'\] \(export"):
        parse_glb(json.dumps({"extensionsRequired": needed}).encode())
    assert parse_glb(json.dumps({"extensionsRequired": needed[:1]}).encode()).document["extensionsRequired"]
    with pytest.raises(FormatError, match="extensionsRequired is 5; it must be a list"):
        parse_glb(b'{"extensionsRequired": 5}')


def test_solid_shapes_of_one_class_share_a_mesh() -> None:
    poles = [
        Primitive(shape="cylinder", center=(k, 0, 1), size=(0.2, 0.2, 2), label="pole", id=f"p{k}") for k in range(50)
    ]
    assert len(glb_of(Layout(tuple(poles)))) - len(glb_of(Layout((poles[0],)))) < 50 * 300


def test_the_header_and_the_alignment_are_those_of_the_format() -> None:
    data = glb_of(EVERYTHING)
    magic, version, length, json_length, kind = struct.unpack_from("<5I", data)
    assert (magic, version, length, kind) == (0x46546C67, 2, len(data), 0x4E4F534A)
    assert length % 4 == json_length % 4 == 0
    document = json.loads(data[20 : 20 + json_length])
    for accessor in document["accessors"]:
        view = document["bufferViews"][accessor["bufferView"]]
        assert view["byteOffset"] % 4 == 0
        assert view["byteOffset"] + view["byteLength"] <= document["buffers"][0]["byteLength"]
        assert accessor["type"] == "SCALAR" or len(accessor["min"]) == 3
    assert [node["extras"]["class"] for node in document["nodes"][1:]] == [p.label for p in EVERYTHING]
