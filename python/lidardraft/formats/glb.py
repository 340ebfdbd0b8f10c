"""Binary glTF, both ways: the pieces placed by its nodes, and a layout as nodes with the colours of their classes."""

from __future__ import annotations

import base64
import codecs
import json
import math
import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import expecting, named, read_bytes, written_whole
from lidardraft.json_fields import are_numbers, check_object, is_number, parse_object
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.mesh import TriangleMesh, unit_mesh
from lidardraft.semantics import BY_NAME

_MAGIC, _VERSION, _JSON, _BINARY = 0x46546C67, 2, 0x4E4F534A, 0x004E4942
_MOST_NODES, _DEEPEST = 20_000, 64
MOST_VERTICES = 1_000_000  # and triangles
_TRIANGLES, _STRIP, _FAN = 4, 5, 6  # modes with a surface
_FAR = 1000.0  # times the extent of a mesh: at this distance float32 rounds it to a ten-thousandth
_INSTANCING = "EXT_mesh_gpu_instancing"
# Extensions that a reader without materials and lights may ignore.
_NO_SHAPES = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_", "KHR_xmp")
_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_FLOAT32, _UINT32, _VERTEX_BUFFER, _INDEX_BUFFER = 5126, 5125, 34962, 34963
_GLTF_FROM_LAYOUT = [-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]  # x y z w: z up becomes y up


@dataclass(frozen=True)
class Piece:
    """The part of a node's mesh with one material."""

    indices: tuple[int, ...]  # of the node, then of its parents
    names: tuple[str, ...]  # of these, and of the mesh
    material: str
    extras: dict[str, Any]
    matrix: np.ndarray  # world_from_node [4, 4]; world_from_scene if it has a skin
    part: dict[str, Any]
    skin: Any = None  # the index of one

    @property
    def name(self) -> str:
        """The name of the node, or the next name found."""
        return next((name for name in self.names if name), "unnamed")


@dataclass(frozen=True, slots=True)
class GlbFile:
    """The JSON document of a file and its buffers: its binary chunk, and those embedded in the document. `unread`, the
    unsupported features with the names of their nodes, and `worlds` are filled as the pieces are read."""

    document: dict[str, Any]
    buffers: tuple[memoryview, ...]
    unread: dict[str, list[str]] = field(default_factory=dict)
    worlds: dict[int, np.ndarray] = field(default_factory=dict)  # world_from_node [4, 4] by indices

    def items(self, name: str) -> list[dict[str, Any]]:
        """The objects of a list of the document, such as "nodes"; an empty list if it has none."""
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
        """The values of an accessor of a `kind`, [N, 3] for VEC3, [N, 16] for MAT4 and [N] for SCALAR; read-only."""
        accessor = self.item("accessors", index)
        if "sparse" in accessor:
            raise FormatError(f"accessor {index} is sparse; only plain ones are read")
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

    @property
    def scene(self) -> dict[str, Any]:
        """The default scene; for a file without scenes, one of all nodes."""
        if not self.items("scenes"):
            return {"nodes": list(range(len(self.items("nodes"))))}
        return self.item("scenes", self.document.get("scene", 0))

    def pieces(self, world: np.ndarray) -> Iterator[Piece]:
        """The parts with one material of all nodes with a mesh, from the roots of the scene down; `world` [4, 4] is the
        frame of the scene."""
        waiting: list[tuple[Any, np.ndarray, tuple[str, ...], tuple[int, ...]]]
        waiting = [(index, world, (), ()) for index in reversed(_indices(self.scene, "nodes"))]
        nodes = pieces = 0
        while waiting:
            index, parent, names, above = waiting.pop()
            node = self.item("nodes", index)
            if _INSTANCING in check_object(node.get("extensions", {})):
                raise FormatError(f"node {index} has {_INSTANCING}; that is not read (export it without GPU instances)")
            if (nodes := nodes + 1) > _MOST_NODES or len(names) > _DEEPEST:
                raise FormatError(f"more than {_MOST_NODES} nodes, more than {_DEEPEST} deep, or a circle of nodes")
            with np.errstate(over="ignore", invalid="ignore"):  # the primitive reports values that are not finite
                matrix = self.worlds[index] = parent @ _local(node)
            below, path = (_text(node, "name"), *names), (index, *above)
            waiting.extend((child, matrix, below, path) for child in reversed(_indices(node, "children")))
            if "mesh" not in node:
                continue
            mesh = self.item("meshes", node["mesh"])
            parts = mesh.get("primitives", [])
            if not isinstance(parts, list):
                raise FormatError(f"mesh {node['mesh']} has no list of primitives")
            for part in map(check_object, parts):
                material = _text(self.item("materials", part["material"]), "name") if "material" in part else ""
                extras = {**extras_of(mesh), **extras_of(node)}
                own = world if "skin" in node else matrix
                piece = Piece(path, (*below, _text(mesh, "name")), material, extras, own, part, node.get("skin"))
                if part.get("mode", _TRIANGLES) not in (_TRIANGLES, _STRIP, _FAN):
                    self.unread.setdefault("points and lines are left out", []).append(piece.name)
                    continue
                weights = node.get("weights", mesh.get("weights"))
                if "targets" in part and isinstance(weights, list) and any(weights):
                    self.unread.setdefault("morph targets are left out", []).append(piece.name)
                if (pieces := pieces + 1) > _MOST_NODES:
                    raise FormatError(f"more than {_MOST_NODES} meshes, or parts of them of one material, in all nodes")
                yield piece

    def triangles(self, piece: Piece) -> TriangleMesh:
        """The triangles of a piece in the frame of its node."""
        attributes = check_object(piece.part.get("attributes", {}))
        positions = self.array(attributes.get("POSITION"), "VEC3")
        if positions.dtype != np.float32:
            raise FormatError("positions must be float32")
        indices = self.array(piece.part["indices"], "SCALAR") if "indices" in piece.part else np.arange(len(positions))
        most = max(len(positions), len(indices) // 3)
        if indices.dtype.kind not in "iu" or len(indices) < 3 or most > MOST_VERTICES:
            raise FormatError(f"{len(positions)} positions and {len(indices)} indices: too many, or no triangle")
        furthest, extent = np.abs(positions).max(), np.abs(positions - positions[0]).max()
        if furthest > _FAR * extent > 0:
            what = f"places so far from their node are rounded to {np.spacing(furthest):g}, as float32 has them"
            self.unread.setdefault(what, []).append(piece.name)
        places = positions if piece.skin is None else self._in_bind_pose(piece, positions, attributes)
        faces = _faces(indices.astype(np.int64), piece.part.get("mode", _TRIANGLES))
        return TriangleMesh(places, faces)  # reports infinite vertices and faces without a vertex

    def _in_bind_pose(self, piece: Piece, positions: np.ndarray, attributes: dict[str, Any]) -> np.ndarray:
        """Positions [V, 3] in the frame of the scene, posed by the joints of the skin (glTF 2.0, 3.7.3)."""
        with expecting("a skin on nodes of the scene"), np.errstate(invalid="ignore"):
            skin = self.item("skins", piece.skin)
            moves = np.linalg.inv(piece.matrix) @ [self.worlds[joint] for joint in skin["joints"]]
            if "inverseBindMatrices" in skin:
                moves = moves @ self.array(skin["inverseBindMatrices"], "MAT4").reshape(-1, 4, 4).swapaxes(1, 2)
            total = np.zeros((len(positions), 4, 4))
            for name in [name for name in attributes if name.startswith("JOINTS_")]:
                joints = self.array(attributes[name], "VEC4").astype(np.uint32)
                weights = self.array(attributes[name.replace("JOINTS", "WEIGHTS")], "VEC4")
                for joint, weight in zip(joints.T, weights.T, strict=True):
                    total += weight[:, None, None] * moves[joint]
            total /= total[:, 3:, 3:]  # the sum of the weights: whole numbers do not add up to 1
            return np.asarray(np.einsum("vij,vj->vi", total[:, :3, :3], positions) + total[:, :3, 3])


def open_glb(path: str | os.PathLike[str]) -> GlbFile:
    """The chunks of a file. Raises `FormatError` naming it for anything but a complete binary glTF 2 without external
    files."""
    data = read_bytes(path)
    with named(path):
        return parse_glb(data)


def parse_glb(data: bytes) -> GlbFile:
    """As `open_glb`, from the bytes of a file."""
    text = data.removeprefix(codecs.BOM_UTF8).lstrip()
    if text[:1] == b"{":  # glTF as text
        return _file(parse_object(text), None)
    if len(data) < 20:
        raise FormatError(f"no GLB: {len(data)} bytes")
    magic, version, length, json_length, json_kind = struct.unpack_from("<5I", data)
    if magic != _MAGIC:
        raise FormatError("no GLB: it does not begin with glTF")
    if version != _VERSION:
        raise FormatError(f"glTF {version}; version {_VERSION} is read")
    if json_kind != _JSON or length > len(data) or 20 + json_length > length:
        raise FormatError(f"a broken GLB: its header says {length} bytes, {json_length} of JSON; it has {len(data)}")
    document, binary, rest = parse_object(data[20 : 20 + json_length]), memoryview(b""), 20 + json_length
    if rest + 8 <= length:
        size, kind = struct.unpack_from("<2I", data, rest)
        if kind != _BINARY or rest + 8 + size > length:
            raise FormatError(f"a broken GLB: its second chunk says {size} bytes")
        binary = memoryview(data)[rest + 8 : rest + 8 + size]
    return _file(document, binary)


def glb_bytes(document: dict[str, Any], binary: bytes) -> bytes:
    """The file of a JSON document and a binary chunk."""
    text = json.dumps(document, allow_nan=False, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    chunks = struct.pack("<2I", len(text), _JSON) + text + struct.pack("<2I", len(binary), _BINARY) + binary
    return struct.pack("<3I", _MAGIC, _VERSION, 12 + len(chunks)) + chunks


def extras_of(owner: dict[str, Any]) -> dict[str, Any]:
    """The custom properties of an object of the document."""
    found = owner.get("extras")
    return found if isinstance(found, dict) else {}


def _faces(corners: np.ndarray, mode: int) -> np.ndarray:
    """The triangles [F, 3] of a list, a strip or a fan of corners [N], all of them turned alike."""
    if mode == _TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    place = np.arange(len(corners) - 2)
    if mode == _FAN:
        return np.stack([corners[place + 1], corners[place + 2], corners[0 * place]], axis=1)
    odd = place % 2
    faces = np.stack([corners[place], corners[place + 1 + odd], corners[place + 2 - odd]], axis=1)
    return faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]  # without degenerate ones


class _Document:
    """The growing lists of a document, and its binary chunk."""

    def __init__(self) -> None:
        self.lists: dict[str, list[dict[str, Any]]] = {
            name: [] for name in ("meshes", "materials", "accessors", "bufferViews")
        }
        self.binary = bytearray()
        self._places: dict[Any, int] = {}

    def add(self, name: str, item: dict[str, Any]) -> int:
        self.lists[name].append(item)
        return len(self.lists[name]) - 1

    def mesh(self, primitive: Primitive) -> int:
        """The index of the mesh for a primitive's shape and class; solid shapes share theirs."""
        key = (primitive.shape if primitive.mesh is None else primitive.id, primitive.label)
        if key not in self._places:
            mesh = primitive.mesh if primitive.mesh is not None else unit_mesh(primitive.shape)
            part = {"attributes": {"POSITION": self._positions(mesh)}, "indices": self._indices(mesh)}
            part["material"] = self._material(primitive.label)
            self._places[key] = self.add("meshes", {"name": "_".join(key), "primitives": [part]})
        return self._places[key]

    def _material(self, label: str) -> int:
        if label not in self._places:
            red, green, blue = (part / 255 for part in BY_NAME[label].colour)
            look = {"baseColorFactor": [red, green, blue, 1.0], "metallicFactor": 0.0}
            self._places[label] = self.add("materials", {"name": label, "pbrMetallicRoughness": look})
        return self._places[label]

    def _positions(self, mesh: TriangleMesh) -> int:
        values = mesh.vertices.astype("<f4")
        bounds = {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        return self._accessor(values, _VERTEX_BUFFER, {"componentType": _FLOAT32, "type": "VEC3", **bounds})

    def _indices(self, mesh: TriangleMesh) -> int:
        values = mesh.faces.astype("<u4").reshape(-1)
        return self._accessor(values, _INDEX_BUFFER, {"componentType": _UINT32, "type": "SCALAR"})

    def _accessor(self, values: np.ndarray, target: int, fields: dict[str, Any]) -> int:
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": values.nbytes, "target": target}
        self.binary += values.tobytes()
        return self.add("accessors", {"bufferView": self.add("bufferViews", view), "count": len(values), **fields})


def glb_of(layout: Layout) -> bytes:
    """The bytes of the file. Vertices are rounded to float32; places, sizes and angles are not."""
    document = _Document()
    nodes = [_node(primitive, document.mesh(primitive)) for primitive in layout]
    root = {"name": "layout", "rotation": _GLTF_FROM_LAYOUT, "children": list(range(1, len(nodes) + 1))}
    if not nodes:
        del root["children"]
    travelling = {"lidardraft": layout.head()}
    fields: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "lidardraft"},
        "scene": 0,
        "scenes": [{"nodes": [0], "extras": travelling}],
        "nodes": [root, *nodes],
        **{name: items for name, items in document.lists.items() if items},
    }
    if document.binary:
        fields["buffers"] = [{"byteLength": len(document.binary)}]
    return glb_bytes(fields, bytes(document.binary))


def write_glb(path: str | os.PathLike[str], layout: Layout) -> None:
    """Write the file of `glb_of`; `layout_from_glb` reads the same shapes, meshes to float32's rounding."""
    with written_whole(path) as temporary:
        temporary.write_bytes(glb_of(layout))


def _node(primitive: Primitive, mesh: int) -> dict[str, Any]:
    half = primitive.yaw / 2
    return {
        "name": primitive.id,
        "mesh": mesh,
        "translation": list(primitive.center),
        "rotation": [0.0, 0.0, math.sin(half), math.cos(half)],
        "scale": [extent or 1.0 for extent in primitive.size],
        "extras": {"class": primitive.label, "id": primitive.id, "instance": primitive.instance, **primitive.more()},
    }


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
    found = [_buffer(check_object(buffer), binary if index == 0 else None) for index, buffer in enumerate(buffers)]
    return GlbFile(document, tuple(found or [binary or memoryview(b"")]))


def _buffer(buffer: dict[str, Any], binary: memoryview | None) -> memoryview:
    uri = buffer.get("uri")
    if uri is None and binary is not None:
        return binary
    head, base64_, text = uri.partition(";base64,") if isinstance(uri, str) else ("", "", "")
    if not (head.startswith("data:") and base64_):
        raise FormatError("the file keeps its values in another file (export it as glTF Binary, .glb)")
    with expecting("base64"):
        return memoryview(base64.b64decode(text, validate=True))


def _size(value: Any, name: str) -> int:
    if not is_number(value) or value != int(value) or not 0 <= value < 2**32:
        raise FormatError(f"{name} is {value!r:.50}; it must be a whole number of 0 or more")
    return int(value)


def _indices(owner: dict[str, Any], name: str) -> list[Any]:
    found = owner.get(name, [])
    if not isinstance(found, list) or len(found) > _MOST_NODES:
        raise FormatError(f"{name} is {found!r:.50}; it must be a list of up to {_MOST_NODES} indices")
    return found


def _local(node: dict[str, Any]) -> np.ndarray:
    """parent_from_node [4, 4]."""
    if "matrix" in node:
        return _numbers(node["matrix"], 16, "matrix").reshape(4, 4).T
    x, y, z, w = _numbers(node.get("rotation", [0, 0, 0, 1]), 4, "rotation")
    if (length := math.sqrt(x * x + y * y + z * z + w * w)) == 0:
        raise FormatError("a rotation of zeros")
    x, y, z, w = (part / length for part in (x, y, z, w))
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, :3] *= _numbers(node.get("scale", [1, 1, 1]), 3, "scale")
    matrix[:3, 3] = _numbers(node.get("translation", [0, 0, 0]), 3, "translation")
    return matrix


def _numbers(value: Any, count: int, name: str) -> np.ndarray:
    if not are_numbers(value, count) or max(map(abs, value)) > 1e9:
        raise FormatError(f"{name} of a node is {value!r:.80}; it must be {count} numbers of up to 1e9")
    return np.array(value, dtype=np.float64)


def _text(owner: dict[str, Any], name: str) -> str:
    value = owner.get(name)
    return value if isinstance(value, str) else ""
