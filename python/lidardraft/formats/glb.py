"""Binary glTF in: the nodes of a modelled scene become the primitives of a layout."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from lidardraft.errors import FormatError, LayoutError, check_type
from lidardraft.files import named
from lidardraft.formats.glb_file import GlbFile, open_glb
from lidardraft.formats.piece_ids import PieceIds
from lidardraft.json_fields import are_numbers, check_object
from lidardraft.scene.class_names import PROPERTIES, check_classes, class_of
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.mesh import TriangleMesh
from lidardraft.scene.placed_mesh import MOST_RECOGNISED, placed_mesh, recognised_shape
from lidardraft.semantics import BY_NAME

# glTF has y up and looks along +z; Blender's exporters and importers turn it so: x, y, z becomes x, -z, y.
_FRAMES = {"y": np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]), "z": np.eye(4)}
_MOST_NODES, _DEEPEST = 20_000, 64
_MOST_VERTICES = 1_000_000  # and triangles, of all nodes together: a mesh may be used by many
_TRIANGLES = 4
_LEAN = 1e-5  # the tangent of the angle by which an axis may lean that points up
_INSTANCING = "EXT_mesh_gpu_instancing"


@dataclass(frozen=True)
class Piece:
    """A part of one material of the mesh of a node."""

    indices: tuple[int, ...]  # of the node, then of its parents
    names: tuple[str, ...]  # of these, and of the mesh
    extras: dict[str, Any]
    matrix: np.ndarray  # world_from_node [4, 4]
    part: dict[str, Any]

    @property
    def name(self) -> str:
        """The name of the node, or the next one that there is."""
        return next((name for name in self.names if name), "unnamed")


def layout_from_glb(path: str | os.PathLike[str], *, classes: Mapping[str, str] | None = None, up: str = "y") -> Layout:
    """The layout of a glTF file, binary or with its buffers in the text, whose axis `up` points up, in metres; y does
    as the format has it.

    The class of an object is its property (in `extras`) "class" or that of its mesh, or else what `classes` says of its
    name or of those of its material, parents and mesh, or else what these names say by themselves. All that is below a
    node whose name says that class of one thing ("Truck_2", and not "Trucks") is that thing. Meshes that are boxes,
    ellipsoids, cylinders or planes and stand upright become those shapes, to the rounding of float32; others stay
    meshes. Raises `FormatError` where the file is broken, compressed or needs another file, `LayoutError` listing the
    names that say no class.
    """
    check_type("path", path, str, os.PathLike)
    check_classes(classes or {})
    if not isinstance(up, str) or up not in _FRAMES:
        raise LayoutError(f"up is {up!r}; it must be 'y' or 'z'")
    with named(path):
        file = open_glb(path)
        pieces = list(islice(_pieces(file, _FRAMES[up]), _MOST_NODES + 1))
        if len(pieces) > _MOST_NODES:
            raise FormatError(f"more than {_MOST_NODES} meshes, or parts of them of one material, in all nodes")
        labels = [_class_of(piece, file, classes or {}) for piece in pieces]
        nameless = sorted({piece.name for piece, label in zip(pieces, labels, strict=True) if not label})
        if nameless:
            raise LayoutError(
                f"no class for {', '.join(nameless)}; say which by --class NAME=CLASS (`classes` in Python)"
            )
        primitives = _primitives(file, pieces, [label or "" for label in labels], classes or {})
        if not primitives:
            raise FormatError("the file has no triangles")
        travelled = _extras(_scene(file)).get("lidardraft")
        fields: dict[str, Any] = {"provenance": {"source": os.path.basename(os.fspath(path))}, "coverage": None}
        if isinstance(travelled, dict) and travelled.keys() == fields.keys():
            fields = travelled
        return Layout(primitives=tuple(primitives), **fields)


def _primitives(file: GlbFile, pieces: list[Piece], labels: list[str], classes: Mapping[str, str]) -> list[Primitive]:
    given = [piece.extras.get("instance") for piece in pieces]
    ids = PieceIds(given, classes, ((piece.indices, piece.names) for piece in pieces))
    primitives: list[Primitive] = []
    meshes: dict[tuple[str, bool], tuple[np.ndarray, np.ndarray, str]] = {}
    spent = 0
    for piece, label in zip(pieces, labels, strict=True):
        is_y_up = _is_upright(piece.matrix[:3, 1])  # the axis of the mesh that points up becomes its z
        matrix = piece.matrix @ _FRAMES["y"].T if is_y_up else piece.matrix
        vertices, faces, shape = _shared(file, piece.part, is_y_up, meshes)
        spent += max(len(vertices), len(faces))
        if spent > _MOST_VERTICES:
            raise FormatError(f"more than {_MOST_VERTICES} vertices or triangles in all nodes")
        extras = {name: value for name, value in piece.extras.items() if name in PROPERTIES and name != "class"}
        whole = extras.setdefault("id", ids.id_of(piece.indices, piece.names, label))
        if label in BY_NAME and BY_NAME[label].is_thing and "instance" not in extras:
            extras["instance"] = ids.instance_of(whole)
        primitive = placed_mesh(matrix, vertices, faces, shape=shape, label=label, **extras)
        if primitive is not None:
            primitives.append(primitive)
    return primitives


def _pieces(file: GlbFile, layout_from_gltf: np.ndarray) -> Iterator[Piece]:
    """The parts of one material of all nodes that have a mesh, from the roots of the scene down."""
    no_names: tuple[str, ...] = ()
    no_indices: tuple[int, ...] = ()
    waiting = [(i, layout_from_gltf, no_names, no_indices) for i in reversed(_indices(_scene(file), "nodes"))]
    count = 0
    while waiting:
        index, parent, names, above = waiting.pop()
        node = file.item("nodes", index)
        if _INSTANCING in check_object(node.get("extensions", {})):
            raise FormatError(f"node {index} has {_INSTANCING}; that is not read (export it without GPU instances)")
        count += 1
        if count > _MOST_NODES or len(names) > _DEEPEST:
            raise FormatError(f"more than {_MOST_NODES} nodes, more than {_DEEPEST} deep, or a circle of nodes")
        with np.errstate(over="ignore", invalid="ignore"):  # the primitive says what is not finite
            matrix = parent @ _local(node)
        below, path = (_text(node.get("name")), *names), (index, *above)
        waiting.extend((child, matrix, below, path) for child in reversed(_indices(node, "children")))
        if "mesh" in node:
            mesh = file.item("meshes", node["mesh"])
            parts = mesh.get("primitives", [])
            if not isinstance(parts, list):
                raise FormatError(f"mesh {node['mesh']} has no list of primitives")
            for part in map(check_object, parts):
                if part.get("mode", _TRIANGLES) == _TRIANGLES:  # points and lines have no surface
                    extras = {**_extras(mesh), **_extras(node)}
                    yield Piece(path, (*below, _text(mesh.get("name"))), extras, matrix, part)


def _scene(file: GlbFile) -> dict[str, Any]:
    if not file.items("scenes"):
        return {"nodes": list(range(len(file.items("nodes"))))}
    return file.item("scenes", file.document.get("scene", 0))


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


def _is_upright(axis: np.ndarray) -> bool:
    x, y, z = axis.tolist()
    return z > 0 and math.hypot(x, y) <= _LEAN * z


def _shared(
    file: GlbFile,
    part: dict[str, Any],
    is_y_up: bool,
    meshes: dict[tuple[str, bool], tuple[np.ndarray, np.ndarray, str]],
) -> tuple[np.ndarray, np.ndarray, str]:
    """Vertices, triangles and shape of a mesh primitive, found out once for all nodes that use it."""
    key = repr((part.get("attributes"), part.get("indices"))), is_y_up
    if key not in meshes:
        vertices, faces = _triangles(file, part)
        if is_y_up:
            vertices = vertices @ _FRAMES["y"][:3, :3].T
        meshes[key] = vertices, faces, recognised_shape(vertices, faces)
    return meshes[key]


def _triangles(file: GlbFile, part: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Vertices float64 [V, 3], each once, and triangles [F, 3] of a mesh primitive, checked."""
    attributes = check_object(part.get("attributes", {}))
    positions = file.array(attributes.get("POSITION"), "VEC3")
    if positions.dtype != np.float32:
        raise FormatError("positions that are not float32 are not read")
    indices = file.array(part["indices"], "SCALAR") if "indices" in part else np.arange(len(positions))
    if indices.dtype.kind not in "iu" or len(indices) < 3 or max(len(positions), len(indices) // 3) > _MOST_VERTICES:
        raise FormatError(f"{len(positions)} positions and {len(indices)} indices make no triangles that are read")
    faces = indices[: len(indices) // 3 * 3].astype(np.int64).reshape(-1, 3)
    mesh = TriangleMesh(positions, faces)  # names a vertex that is not finite and a face that has no vertex
    if len(positions) > MOST_RECOGNISED:
        return mesh.vertices, mesh.faces
    # Exporters part the faces at sharp edges; vertices at one place are one vertex again.
    order = np.lexsort(mesh.vertices.T[::-1])
    ordered = mesh.vertices[order]
    new = np.concatenate([[True], (ordered[1:] != ordered[:-1]).any(axis=1)])
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.cumsum(new) - 1
    return ordered[new], place[mesh.faces]


def _class_of(piece: Piece, file: GlbFile, classes: Mapping[str, str]) -> str | None:
    if isinstance(given := piece.extras.get("class"), str):
        return given
    material = _text(file.item("materials", piece.part["material"]).get("name")) if "material" in piece.part else ""
    own, *parents, mesh = piece.names
    # The mesh comes last: most are called after what made them, as "Cube" or "Plane".
    return class_of([own, material, *parents], classes) or class_of([mesh], classes)


def _text(value: Any) -> str:
    return value if isinstance(value, str) else ""


def _extras(owner: dict[str, Any]) -> dict[str, Any]:
    found = owner.get("extras")
    return found if isinstance(found, dict) else {}
