"""A mesh with its place becomes a shape of a layout: the one that it is, where it stands upright, or else a mesh."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lidardraft.drafting.blender_scene.mesh_shapes import MeshShape
from lidardraft.drafting.blender_scene.meshes import Mesh
from lidardraft.drafting.blender_scene.objects import SceneObject
from lidardraft.scene.layout import Primitive
from lidardraft.scene.mesh import TriangleMesh

_UPRIGHT = 1e-6  # rad, by which a shape may lean and stay a box, cylinder, ellipsoid or plane


def placed_shape(item: SceneObject, mesh: Mesh, shape: MeshShape, **fields: Any) -> Primitive | None:
    """The primitive of an object with `fields` (label, id, ...); None where it has no surface.

    Raises `LayoutError` for what is too far away or too large.
    """
    placed = _as_solid(item, mesh, shape)
    if placed is not None:
        center, size, yaw = placed
        if min(size) > 0 or (shape.shape == "plane" and min(size[:2]) > 0):
            return Primitive(shape=shape.shape, center=center, size=size, yaw=yaw, **fields)
        if shape.shape == "box" and min(size[:2]) > 0:  # a slab without height
            return Primitive(shape="plane", center=center, size=(*size[:2], 0.0), yaw=yaw, **fields)
    return _as_mesh(item, mesh, shape, **fields)


def _as_solid(
    item: SceneObject, mesh: Mesh, shape: MeshShape
) -> tuple[tuple[float, float, float], tuple[float, float, float], float] | None:
    """Center, size and yaw; None where the shape is a mesh, or leans."""
    if shape.shape == "mesh":
        return None
    stretch = np.diag(mesh.matrix)[:3]
    if _turns_about_z_alone(item) and np.array_equal(mesh.matrix, np.diag([*stretch, 1.0])):  # no angle is rounded
        extents = np.abs(np.array(item.scale.numbers) * stretch * shape.size)
        return _triple(item.location.numbers), _triple(extents.tolist()), item.rotation.numbers[2]
    matrix = item.world() @ mesh.matrix
    upright = _upright(matrix[:3, :3] * np.where(np.array(shape.size) > 0, shape.size, 1.0), shape.shape)
    if upright is None:
        return None
    size, yaw = upright
    return _triple(matrix[:3, 3].tolist()), _triple([*size[:2], size[2] if shape.shape != "plane" else 0.0]), yaw


def _turns_about_z_alone(item: SceneObject) -> bool:
    return item.parent is None and item.rotation.numbers[0] == 0 and item.rotation.numbers[1] == 0


def _upright(linear: np.ndarray, shape: str) -> tuple[list[float], float] | None:
    """Full extents and yaw of a unit shape under a linear map [3, 3]; None where the result is no upright one."""
    lengths = np.linalg.norm(linear, axis=0)
    small = _UPRIGHT * max(lengths.max(), 1e-9)
    if shape == "ellipsoid":  # any map makes an ellipsoid of a ball; its axes are those of this matrix
        return _ellipsoid(linear @ linear.T, small)
    if shape == "cylinder":
        if max(abs(linear[2, :2]).max(), abs(linear[:2, 2]).max()) > small:
            return None
        size, yaw = _ellipse(linear[:2, :2] @ linear[:2, :2].T)
        return [*size, float(abs(linear[2, 2]))], yaw
    order = [0, 1, 2]
    if shape == "box":  # whichever axis points up
        up = int(np.argmax(abs(linear[2]) / np.maximum(lengths, 1e-300)))
        order = [k for k in range(3) if k != up] + [up]
    along, across, up_column = (linear[:, k] for k in order)
    level = max(abs(along[2]), abs(across[2])) <= small and abs(along @ across) <= small * max(lengths.max(), 1e-9)
    if not level or (shape == "box" and abs(up_column[:2]).max() > small):
        return None
    return [float(lengths[k]) for k in order], math.atan2(along[1], along[0])


def _ellipse(squared: np.ndarray) -> tuple[list[float], float]:
    """Full extents and yaw of an ellipse with the matrix [2, 2] of its squared axes; the yaw nearest to 0."""
    values, vectors = np.linalg.eigh(squared)
    if values[1] - values[0] <= 1e-9 * abs(values[1]):
        return [float(math.sqrt(max(values[1], 0.0)))] * 2, 0.0
    yaw = math.remainder(math.atan2(vectors[1, 1], vectors[0, 1]), math.pi)
    long, short = (float(math.sqrt(max(value, 0.0))) for value in values[::-1])
    if abs(yaw) > math.pi / 4:
        return [short, long], yaw - math.copysign(math.pi / 2, yaw)
    return [long, short], yaw


def _ellipsoid(squared: np.ndarray, small: float) -> tuple[list[float], float] | None:
    if abs(squared[2, :2]).max() > small * math.sqrt(max(squared.max(), 0.0)):
        return None
    size, yaw = _ellipse(squared[:2, :2])
    return [*size, float(math.sqrt(squared[2, 2]))], yaw


def _as_mesh(item: SceneObject, mesh: Mesh, shape: MeshShape, **fields: Any) -> Primitive | None:
    vertices, faces = shape.triangles()
    local = vertices @ mesh.matrix[:3, :3].T + mesh.matrix[:3, 3]
    scale = np.array(item.scale.numbers)
    if _turns_about_z_alone(item) and (scale > 0).all():  # keeps its yaw, and so a tight box around it
        low, high = local.min(axis=0), local.max(axis=0)
        if (abs(local).max(axis=0) <= 0.5).all() and ((high - low == 1) | (high == low) & (high == 0)).all():
            low, high = np.full(3, -0.5), np.full(3, 0.5)  # fills the unit box already
        middle, extent = (low + high) / 2, high - low
        if (scale * extent > 0).sum() < 2:
            return None
        unit = np.clip((local - middle) / np.where(extent > 0, extent, 1.0), -0.5, 0.5)
        return _mesh_in_box(item, unit, faces, middle * scale, scale * extent, **fields)
    matrix = item.world()
    world = local @ matrix[:3, :3].T + matrix[:3, 3]
    if (np.ptp(world, axis=0) > 0).sum() < 2:
        return None
    return Primitive.from_mesh(world, faces, **fields)


def _mesh_in_box(
    item: SceneObject, unit: np.ndarray, faces: np.ndarray, middle: np.ndarray, size: np.ndarray, **fields: Any
) -> Primitive:
    yaw = item.rotation.numbers[2]
    cos, sin = math.cos(yaw), math.sin(yaw)
    x, y, z = item.location.numbers
    offset = (cos * middle[0] - sin * middle[1], sin * middle[0] + cos * middle[1], middle[2])
    center = _triple([x + offset[0], y + offset[1], z + offset[2]])
    fields |= {"center": center, "size": _triple(size.tolist()), "yaw": yaw, "mesh": TriangleMesh(unit, faces)}
    return Primitive(shape="mesh", **fields)


def _triple(numbers: list[float]) -> tuple[float, float, float]:
    x, y, z = numbers
    return x, y, z
