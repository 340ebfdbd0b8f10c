"""An object of a Blender scene becomes a shape of a layout: the one that it is, where it stands upright, or a mesh."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lidardraft.drafting.blender_scene.mesh_shapes import MeshShape
from lidardraft.drafting.blender_scene.meshes import Mesh
from lidardraft.drafting.blender_scene.objects import SceneObject
from lidardraft.scene.box import THINNEST
from lidardraft.scene.layout import Primitive
from lidardraft.scene.placed_mesh import in_unit_box, placed_mesh


def placed_shape(item: SceneObject, mesh: Mesh, shape: MeshShape, **fields: Any) -> Primitive | None:
    """The primitive of an object with `fields` (label, id, ...); None where it has no surface.

    An object that is only moved, scaled and turned about z keeps its numbers to the last digit. Raises `LayoutError`
    for what is too far away or too large.
    """
    if item.parent is None and item.rotation.numbers[:2] == [0.0, 0.0] and min(item.scale.numbers) >= 0:
        exact = _placed_exactly(item, mesh, shape, **fields)
        if exact is not None:
            return exact
    vertices, faces = shape.triangles()
    known = None if shape.shape == "any" else shape.shape
    return placed_mesh(item.world() @ mesh.matrix, vertices, faces, shape=known, **fields)


def _placed_exactly(item: SceneObject, mesh: Mesh, shape: MeshShape, **fields: Any) -> Primitive | None:
    is_unit = item.properties.get("unit_box")
    if shape.shape == "any" and not is_unit:
        return None
    rows = mesh.matrix.tolist()
    if any(number for row, numbers in enumerate(rows) for column, number in enumerate(numbers) if row != column):
        return None
    stretch, yaw = [rows[axis][axis] for axis in range(3)], item.rotation.numbers[2]
    if shape.shape not in ("mesh", "any"):
        edges = zip(item.scale.numbers, stretch, shape.size, strict=True)
        length, width, height = (abs(scale * factor * edge) for scale, factor, edge in edges)
        flat = shape.shape == "plane" or (shape.shape == "box" and height < THINNEST)  # a slab
        if min(length, width, THINNEST if flat else height) < THINNEST:
            return None
        size = (length, width, 0.0 if flat else height)
        fields |= {"center": tuple(item.location.numbers), "size": size, "yaw": yaw}
        return Primitive(shape="plane" if flat else shape.shape, **fields)
    vertices, faces = shape.triangles()
    vertices, scale = vertices * stretch, np.array(item.scale.numbers)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    if is_unit:
        low, high = np.full(3, -0.5), np.full(3, 0.5)
    x, y, z = ((low + high) / 2 * scale).tolist()
    cos, sin = math.cos(yaw), math.sin(yaw)
    offset = (cos * x - sin * y, sin * x + cos * y, z) if x or y or z else (0.0, 0.0, 0.0)
    center = tuple(a + b for a, b in zip(item.location.numbers, offset, strict=True))
    return in_unit_box(vertices, faces, low, high, scale * (high - low), center=center, yaw=yaw, **fields)
