import json
import struct
from pathlib import Path

from exported_layouts import EVERYTHING

from lidardraft.formats.glb import glb_of, write_glb
from lidardraft.scene.layout import Layout, Primitive


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


def test_an_empty_layout_is_a_file_too(tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", Layout())
    assert (tmp_path / "a.glb").read_bytes()[:4] == b"glTF"
