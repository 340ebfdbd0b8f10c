import codecs
import json
import struct
from pathlib import Path

import numpy as np
import pytest

from lidardraft.errors import FormatError
from lidardraft.formats.glb import MAX_BYTES, GlbFile, glb_bytes, open_glb, parse_glb


def test_the_chunks_come_back() -> None:
    file = parse_glb(glb_bytes({"asset": {"version": "2.0"}}, b"12345"))
    assert file.document == {"asset": {"version": "2.0"}}
    assert file.buffers == (b"12345\0\0\0",)
    assert parse_glb(glb_bytes({"a": [1]}, b"")).document == {"a": [1]}


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "no GLB: 0 bytes"),
        (b"glTF" + bytes(20), "glTF 0; version 2 is read"),
        (b"PK\3\4" + bytes(20), "it does not begin with glTF"),
        (
            struct.pack("<5I", 0x46546C67, 2, 999, 4, 0x4E4F534A) + b"{}  ",
            "a broken GLB: its header tells of 999 bytes",
        ),
        (struct.pack("<5I", 0x46546C67, 2, 24, 99, 0x4E4F534A) + b"{}  ", "99 of JSON"),
        (struct.pack("<5I", 0x46546C67, 2, 24, 4, 0x4E4F534A) + b"[]  ", "is no JSON object"),
        (
            glb_bytes({}, b"1234").replace(struct.pack("<2I", 4, 0x004E4942), struct.pack("<2I", 99, 0x004E4942)),
            "its second chunk tells of 99 bytes",
        ),
    ],
)
def test_broken_containers(data: bytes, said: str) -> None:
    with pytest.raises(FormatError, match=said):
        parse_glb(data)


def test_huge_files_are_not_opened(tmp_path: Path) -> None:
    with open(tmp_path / "a.glb", "wb") as file:
        file.truncate(MAX_BYTES + 1)
    with pytest.raises(FormatError, match=rf"a.glb has {MAX_BYTES + 1} bytes; GLB files of up to {MAX_BYTES} are read"):
        open_glb(tmp_path / "a.glb")
    huge = struct.pack("<5I", 0x46546C67, 2, 2**25 + 20, 2**25, 0x4E4F534A) + bytes(2**25)
    with pytest.raises(FormatError, match="33554432 bytes of JSON; up to 16777216 are read"):
        parse_glb(huge)


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


def test_a_byte_order_mark_before_text() -> None:
    assert parse_glb(codecs.BOM_UTF8 + b' {"a": [1]}').document == {"a": [1]}


def test_of_the_extensions_only_those_that_are_not_read_are_named() -> None:
    needed = ["KHR_materials_unlit", "KHR_draco_mesh_compression"]
    with pytest.raises(FormatError, match=r"extensions that are not read, \['KHR_draco_mesh_compression'\] \(export"):
        parse_glb(json.dumps({"extensionsRequired": needed}).encode())
    assert parse_glb(json.dumps({"extensionsRequired": needed[:1]}).encode()).document["extensionsRequired"]
    with pytest.raises(FormatError, match="extensionsRequired is 5; it must be a list"):
        parse_glb(b'{"extensionsRequired": 5}')
