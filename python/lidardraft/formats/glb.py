"""Binary glTF in: the nodes of a modelled scene become the primitives of a layout."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Any

import numpy as np

from lidardraft.errors import FormatError, LayoutError, check_type
from lidardraft.files import named
from lidardraft.formats.glb_file import GlbFile, open_glb
from lidardraft.json_fields import are_numbers, check_object
from lidardraft.scene.class_names import PROPERTIES, check_classes, class_of, id_of
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.mesh import TriangleMesh
from lidardraft.scene.placed_mesh import MOST_RECOGNISED, placed_mesh, recognised_shape
from lidardraft.semantics import BY_NAME

# glTF has y up and looks along +z; Blender's exporters and importers turn it so: x, y, z becomes x, -z, y.
_LAYOUT_FROM_GLTF = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
_MOST_NODES, _DEEPEST = 20_000, 64
_MOST_VERTICES = 2_000_000  # and triangles, of all nodes together: a mesh may be used by many
_TRIANGLES = 4
Piece = tuple[dict[str, Any], np.ndarray, list[str], dict[str, Any]]  # node, world_from_node, names, mesh primitive


def layout_from_glb(path: str | os.PathLike[str], *, classes: Mapping[str, str] | None = None) -> Layout:
    """The layout of a binary glTF file, its y axis up as the format has it, in metres.

    The class of an object is its property (in `extras`) "class", or else what `classes` says of its name or of those
    of its material, parents and mesh, or else what these names say by themselves. Meshes that are boxes, ellipsoids,
    cylinders or planes and stand upright become those shapes, to the rounding of float32; others stay meshes. Raises
    `FormatError` where the file is broken, compressed or needs another file, `LayoutError` listing the names that say
    no class.
    """
    check_type("path", path, str, os.PathLike)
    check_classes(classes or {})
    with named(path):
        file = open_glb(path)
        pieces = list(islice(_pieces(file), _MOST_NODES + 1))
        if len(pieces) > _MOST_NODES:
            raise FormatError(f"more than {_MOST_NODES} meshes, or parts of them of one material, in all nodes")
        labels = [_class_of(piece, file, classes or {}) for piece in pieces]
        nameless = sorted({_name(piece) for piece, label in zip(pieces, labels, strict=True) if not label})
        if nameless:
            raise LayoutError(
                f"no class for {', '.join(nameless)}; say which by --class NAME=CLASS (`classes` in Python)"
            )
        primitives = _primitives(file, pieces, [label or "" for label in labels])
        if not primitives:
            raise FormatError("the file has no triangles")
        travelled = _extras(_scene(file)).get("lidardraft")
        fields: dict[str, Any] = {"provenance": {"source": os.path.basename(os.fspath(path))}, "coverage": None}
        if isinstance(travelled, dict) and travelled.keys() == fields.keys():
            fields = travelled
        return Layout(primitives=tuple(primitives), **fields)


def _primitives(file: GlbFile, pieces: list[Piece], labels: list[str]) -> list[Primitive]:
    taken: dict[str, int] = {}
    instances: dict[str, int] = {}
    used = {_extras(node).get("instance") for node, *_ in pieces}
    free = (number for number in range(1, 2**16) if number not in used)
    primitives: list[Primitive] = []
    meshes: dict[str, tuple[np.ndarray, np.ndarray, str]] = {}
    spent = 0
    for piece, label in zip(pieces, labels, strict=True):
        node, matrix, _, part = piece
        vertices, faces, shape = _shared(file, part, meshes)
        spent += max(len(vertices), len(faces))
        if spent > _MOST_VERTICES:
            raise FormatError(f"more than {_MOST_VERTICES} vertices or triangles in all nodes")
        extras = {name: value for name, value in _extras(node).items() if name in PROPERTIES and name != "class"}
        whole = extras.setdefault("id", _distinct(id_of(_name(piece)), taken))
        if label in BY_NAME and BY_NAME[label].is_thing and "instance" not in extras:
            name = whole.split(".")[0] if isinstance(whole, str) else ""
            extras["instance"] = instances.get(name) or instances.setdefault(name, next(free))
        primitive = placed_mesh(matrix, vertices, faces, shape=shape, label=label, **extras)
        if primitive is not None:
            primitives.append(primitive)
    return primitives


def _distinct(name: str, taken: dict[str, int]) -> str:
    taken[name] = taken.get(name, 0) + 1
    return name if taken[name] == 1 else f"{name}.{taken[name]}"


def _pieces(file: GlbFile) -> Iterator[Piece]:
    """The parts of one material of all nodes that have a mesh, from the roots of the scene down."""
    no_names: tuple[str, ...] = ()
    waiting = [(index, _LAYOUT_FROM_GLTF, no_names) for index in reversed(_indices(_scene(file), "nodes"))]
    count = 0
    while waiting:
        index, parent, names = waiting.pop()
        node = file.item("nodes", index)
        count += 1
        if count > _MOST_NODES or len(names) > _DEEPEST:
            raise FormatError(f"more than {_MOST_NODES} nodes, more than {_DEEPEST} deep, or a circle of nodes")
        with np.errstate(over="ignore", invalid="ignore"):  # the primitive says what is not finite
            matrix = parent @ _local(node)
        below = (_text(node.get("name")), *names)
        waiting.extend((child, matrix, below) for child in reversed(_indices(node, "children")))
        if "mesh" in node:
            mesh = file.item("meshes", node["mesh"])
            parts = mesh.get("primitives", [])
            if not isinstance(parts, list):
                raise FormatError(f"mesh {node['mesh']} has no list of primitives")
            for part in map(check_object, parts):
                if part.get("mode", _TRIANGLES) == _TRIANGLES:  # points and lines have no surface
                    yield node, matrix, [*below, _text(mesh.get("name"))], part


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


def _shared(
    file: GlbFile, part: dict[str, Any], meshes: dict[str, tuple[np.ndarray, np.ndarray, str]]
) -> tuple[np.ndarray, np.ndarray, str]:
    """Vertices, triangles and shape of a mesh primitive, found out once for all nodes that use it."""
    key = repr((part.get("attributes"), part.get("indices")))
    if key not in meshes:
        vertices, faces = _triangles(file, part)
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
    node, _, names, part = piece
    given = _extras(node).get("class")
    if isinstance(given, str):
        return given
    material = _text(file.item("materials", part["material"]).get("name")) if "material" in part else ""
    return class_of([names[0], material, *names[1:]], classes)


def _name(piece: Piece) -> str:
    return next((name for name in piece[2] if name), "unnamed")


def _text(value: Any) -> str:
    return value if isinstance(value, str) else ""


def _extras(owner: dict[str, Any]) -> dict[str, Any]:
    found = owner.get("extras")
    return found if isinstance(found, dict) else {}
