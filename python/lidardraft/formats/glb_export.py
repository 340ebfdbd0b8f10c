"""A layout as binary glTF: a node a shape, with the class's colour, and what else it is in the node's `extras`."""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np

from lidardraft.files import written_whole
from lidardraft.formats.glb_file import glb_bytes
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.mesh import TriangleMesh, unit_mesh
from lidardraft.semantics import BY_NAME

_FLOAT32, _UINT32, _VERTICES, _INDICES = 5126, 5125, 34962, 34963
_GLTF_FROM_LAYOUT = [-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]  # x y z w: z up becomes y up


class _Document:
    """The lists of a document as they grow, and its binary chunk."""

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
        """The index of the mesh of a primitive's shape and class; those of solid shapes are shared."""
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
        return self._accessor(values, _VERTICES, {"componentType": _FLOAT32, "type": "VEC3", **bounds})

    def _indices(self, mesh: TriangleMesh) -> int:
        values = mesh.faces.astype("<u4").reshape(-1)
        return self._accessor(values, _INDICES, {"componentType": _UINT32, "type": "SCALAR"})

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
    travelling = {"lidardraft": {"provenance": layout.provenance, "coverage": layout.coverage}}
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
    extras: dict[str, Any] = {"class": primitive.label, "id": primitive.id, "instance": primitive.instance}
    extras |= {name: value for name in ("material", "extinction", "open") if (value := getattr(primitive, name))}
    half = primitive.yaw / 2
    return {
        "name": primitive.id,
        "mesh": mesh,
        "translation": list(primitive.center),
        "rotation": [0.0, 0.0, math.sin(half), math.cos(half)],
        "scale": [extent or 1.0 for extent in primitive.size],
        "extras": extras,
    }
