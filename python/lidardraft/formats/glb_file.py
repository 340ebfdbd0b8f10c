"""The container of binary glTF: its two chunks, and the arrays that its accessors describe."""

from __future__ import annotations

import base64
import codecs
import json
import os
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import read_bytes, regular_size
from lidardraft.json_fields import check_object, is_number, parse_object

MAX_BYTES = 2**27  # of a file: what is made of it fits into 1 GB beside it
_MAX_JSON = 2**24  # bytes, that may become ten times as many in memory
_MAGIC, _VERSION, _JSON, _BINARY = 0x46546C67, 2, 0x4E4F534A, 0x004E4942
_MOST_BUFFERS = 1000
# Extensions without which a reader may do that shows no materials and lights.
_NO_SHAPES = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_", "KHR_xmp")
_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC3": 3}


@dataclass(frozen=True, slots=True)
class GlbFile:
    """The JSON document of a file and its buffers: its binary chunk, and those that stand in the document."""

    document: dict[str, Any]
    buffers: tuple[memoryview, ...]

    def items(self, name: str) -> list[dict[str, Any]]:
        """The objects of a list of the document, such as "nodes"; none where it has no such list."""
        found = self.document.get(name, [])
        if not isinstance(found, list):
            raise FormatError(f"{name} is {found!r:.50}; it must be a list")
        return found

    def item(self, name: str, index: Any) -> dict[str, Any]:
        """The object with an index in a list of the document."""
        found = self.items(name)
        if type(index) is not int or not 0 <= index < len(found):
            raise FormatError(f"{name} {index!r:.50} is not there; the file has {len(found)}")
        return check_object(found[index])

    def array(self, index: Any, kind: str) -> np.ndarray:
        """The values of an accessor of a `kind`, [N, 3] for VEC3 and [N] for SCALAR; read-only."""
        accessor = self.item("accessors", index)
        if "sparse" in accessor:
            raise FormatError(f"accessor {index} is sparse; that is not read")
        if accessor.get("type") != kind or accessor.get("componentType") not in list(_COMPONENTS):
            raise FormatError(f"accessor {index} is no {kind} of numbers")
        if "bufferView" not in accessor:
            raise FormatError(f"accessor {index} has no values")
        view = self.item("bufferViews", accessor["bufferView"])
        buffer = view.get("buffer", 0)
        if type(buffer) is not int or not 0 <= buffer < len(self.buffers):
            raise FormatError(f"buffer {buffer!r:.50} is not there; the file has {len(self.buffers)}")
        binary = self.buffers[buffer]
        dtype, width = np.dtype(_COMPONENTS[accessor["componentType"]]), _WIDTHS[kind]
        count = _size(accessor.get("count"), "count")
        start = _size(view.get("byteOffset", 0), "byteOffset") + _size(accessor.get("byteOffset", 0), "byteOffset")
        row = dtype.itemsize * width
        stride = _size(view.get("byteStride", row), "byteStride")
        end = start + stride * (count - 1) + row if count else start
        if stride < row or count == 0 or end > len(binary):
            raise FormatError(f"accessor {index} of {count} values reaches to byte {end}; there are {len(binary)}")
        flat = np.ndarray((count, width), dtype, binary, start, (stride, dtype.itemsize))
        return flat if width > 1 else flat[:, 0]


def open_glb(path: str | os.PathLike[str]) -> GlbFile:
    """The chunks of a file. Raises `FormatError` for anything but a whole binary glTF 2 that needs no other file."""
    if (size := regular_size(path)) > MAX_BYTES:
        raise FormatError(f"{os.fspath(path)} has {size} bytes; GLB files of up to {MAX_BYTES} are read")
    return parse_glb(read_bytes(path))


def parse_glb(data: bytes) -> GlbFile:
    """As `open_glb`, of the bytes of a file."""
    text = data.removeprefix(codecs.BOM_UTF8).lstrip()
    if text[:1] == b"{":  # glTF as text
        return _file(_document(text), None)
    if len(data) < 20:
        raise FormatError(f"no GLB: {len(data)} bytes")
    magic, version, length, json_length, json_kind = struct.unpack_from("<5I", data)
    if magic != _MAGIC:
        raise FormatError("no GLB: it does not begin with glTF")
    if version != _VERSION:
        raise FormatError(f"glTF {version}; version {_VERSION} is read")
    if json_kind != _JSON or length > len(data) or 20 + json_length > length:
        raise FormatError(
            f"a broken GLB: its header tells of {length} bytes, {json_length} of JSON; it has {len(data)}"
        )
    document, binary, rest = _document(data[20 : 20 + json_length]), memoryview(b""), 20 + json_length
    if rest + 8 <= length:
        size, kind = struct.unpack_from("<2I", data, rest)
        if kind != _BINARY or rest + 8 + size > length:
            raise FormatError(f"a broken GLB: its second chunk tells of {size} bytes")
        binary = memoryview(data)[rest + 8 : rest + 8 + size]
    return _file(document, binary)


def glb_bytes(document: dict[str, Any], binary: bytes) -> bytes:
    """The file of a JSON document and a binary chunk."""
    text = json.dumps(document, allow_nan=False, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    chunks = struct.pack("<2I", len(text), _JSON) + text + struct.pack("<2I", len(binary), _BINARY) + binary
    return struct.pack("<3I", _MAGIC, _VERSION, 12 + len(chunks)) + chunks


def _document(text: bytes) -> dict[str, Any]:
    if len(text) > _MAX_JSON:
        raise FormatError(f"{len(text)} bytes of JSON; up to {_MAX_JSON} are read")
    return parse_object(text)


def _file(document: dict[str, Any], binary: memoryview | None) -> GlbFile:
    """The file of a document and its binary chunk, if it has one."""
    needed = document.get("extensionsRequired", [])
    if not isinstance(needed, list):
        raise FormatError(f"extensionsRequired is {needed!r:.80}; it must be a list")
    if unread := [name for name in needed if not str(name).startswith(_NO_SHAPES)]:
        raise FormatError(
            f"the file needs extensions that are not read, {unread!r:.80} (export it without compression)"
        )
    buffers = GlbFile(document, ()).items("buffers")
    if len(buffers) > _MOST_BUFFERS:
        raise FormatError(f"{len(buffers)} buffers; up to {_MOST_BUFFERS} are read")
    found = [_buffer(check_object(buffer), binary if index == 0 else None) for index, buffer in enumerate(buffers)]
    return GlbFile(document, tuple(found or [binary or memoryview(b"")]))


def _buffer(buffer: dict[str, Any], binary: memoryview | None) -> memoryview:
    uri = buffer.get("uri")
    if uri is None and binary is not None:
        return binary
    head, base64_, text = uri.partition(";base64,") if isinstance(uri, str) else ("", "", "")
    if not (head.startswith("data:") and base64_):
        raise FormatError(
            "the file keeps values in another file; only its own are read (export it as glTF Binary, .glb)"
        )
    try:
        return memoryview(base64.b64decode(text, validate=True))
    except ValueError as error:
        raise FormatError(f"a buffer that is no base64: {error}") from None


def _size(value: Any, name: str) -> int:
    if not is_number(value) or value != int(value) or not 0 <= value < 2**32:
        raise FormatError(f"{name} is {value!r:.50}; it must be a whole number of 0 or more")
    return int(value)
