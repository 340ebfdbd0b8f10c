"""A mesh with its pose becomes a primitive: a box, ellipsoid, cylinder or plane if it is an upright one."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lidardraft.errors import LayoutError
from lidardraft.scene.box import FURTHEST, THINNEST
from lidardraft.scene.layout import Primitive
from lidardraft.scene.mesh import TriangleMesh, has_surface, unit_vertices

_LEAN = 1e-6  # the sine of the angle by which an upright shape may lean, or its axes miss the right angle
_OFF = 1e-4  # of its extents: how far vertices may be off a shape, as files hold them in float32
MOST_RECOGNISED = 10_000  # vertices of a mesh that is compared with simple shapes
_ROUND_VERTICES = 20  # the least vertices of a sphere or a cylinder
_ROUND_VOLUME = 0.85  # of the round shape: the least volume of a polyhedron in its place


def placed_mesh(
    matrix: np.ndarray, vertices: np.ndarray, faces: np.ndarray, *, shape: str | None = None, **fields: Any
) -> Primitive | None:
    """The primitive of vertices [V, 3] and triangles [F, 3] under the map `matrix` [4, 4]; None if it has no surface.

    `shape` is the shape, if known; else it is recognised. `fields` are those of a primitive: label, id and so on.
    Raises `LayoutError` if a coordinate or an extent exceeds `FURTHEST`.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle, extent = (low + high) / 2, high - low
    if not (np.isfinite(matrix).all() and max(abs(matrix).max(), extent.max()) <= FURTHEST):
        raise LayoutError(f"{fields.get('id')}: a transform or an extent is larger than {FURTHEST:g}, or no number")
    shape = recognised_shape(vertices, faces) if shape is None else shape
    stretched = matrix[:3, :3] * np.where(extent > 0, extent, 1.0)
    upright = size_and_yaw(stretched, shape)
    center = matrix[:3, :3] @ middle + matrix[:3, 3]
    if upright is not None:
        size, yaw = upright
        fields |= {"center": tuple(center.tolist()), "yaw": yaw}
        if min(size[:2]) >= THINNEST and (shape == "plane" or (shape == "box" and size[2] < THINNEST)):  # a slab
            return Primitive(shape="plane", size=(size[0], size[1], 0.0), **fields)
        if shape not in ("plane", "mesh") and min(size) >= THINNEST:
            return Primitive(shape=shape, size=(size[0], size[1], size[2]), **fields)
        if shape == "mesh" and np.linalg.det(stretched) > 0:  # keeps its yaw, and so a tight box around it
            return in_unit_box(vertices, faces, low, high, np.array(size), **fields)
        del fields["center"], fields["yaw"]
    world = vertices @ matrix[:3, :3].T + matrix[:3, 3]
    return Primitive.from_mesh(world, faces, **fields) if has_surface(world, faces) else None


def in_unit_box(
    vertices: np.ndarray, faces: np.ndarray, low: np.ndarray, high: np.ndarray, size: np.ndarray, **fields: Any
) -> Primitive | None:
    """The mesh primitive of a `size` [3] whose vertices fill the box from `low` to `high`; None without a surface.

    If all vertices are equal along an axis, the size along it becomes 0.
    """
    extent = high - low
    size = np.where(extent > 0, size, 0.0)
    unit = np.clip((vertices - (low + high) / 2) / np.where(extent > 0, extent, 1.0), -0.5, 0.5)
    if not has_surface(unit * size, faces):
        return None
    return Primitive(shape="mesh", size=tuple(size.tolist()), mesh=TriangleMesh(unit, faces), **fields)


def recognised_shape(vertices: np.ndarray, faces: np.ndarray) -> str:
    """The shape of vertices [V, 3] and triangles [F, 3] in any pose and size; "mesh" if there are too many vertices."""
    if len(vertices) > MOST_RECOGNISED:
        return "mesh"
    return shape_of(unit_vertices(vertices)[2], faces)


def shape_of(unit: np.ndarray, faces: np.ndarray) -> str:
    """The shape of triangles [F, 3] of vertices [V, 3], the outermost of which are at 1/2 on each axis."""
    radius = np.hypot(unit[:, 0], unit[:, 1])
    a, b, c = unit[faces].transpose(1, 0, 2)
    (ux, uy, uz), (vx, vy, vz) = (b - a).T, (c - a).T
    normals = np.stack([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx], axis=1) / 2
    area, volume = np.linalg.norm(normals, axis=1).sum(), abs(np.einsum("fi,fi->", a, normals)) / 3
    at_end = abs(abs(unit) - 0.5) <= _OFF
    if (abs(unit[:, 2]) == 0).all():
        return "plane" if abs(area - 1) <= _OFF else "mesh"
    if at_end.all() and abs(area - 6) <= 6 * _OFF and len(set(((unit > 0) @ (1, 2, 4)).tolist())) == 8:
        return "box"
    if len(unit) < _ROUND_VERTICES:
        return "mesh"
    if (abs(np.hypot(radius, unit[:, 2]) - 0.5) <= _OFF).all() and volume >= _ROUND_VOLUME * math.pi / 6:
        return "ellipsoid"
    on_rim = (abs(radius - 0.5) <= _OFF) | (radius <= _OFF)
    return "cylinder" if (on_rim & at_end[:, 2]).all() and volume >= _ROUND_VOLUME * math.pi / 4 else "mesh"


def size_and_yaw(linear: np.ndarray, shape: str) -> tuple[list[float], float] | None:
    """Full extents and yaw of a unit `shape` under a linear map [3, 3]; None if the result leans or is sheared."""
    lengths = np.linalg.norm(linear, axis=0)
    small = _LEAN * lengths.max()
    if shape == "ellipsoid":  # any map turns a ball into an ellipsoid
        squared = linear @ linear.T
        if abs(squared[2, :2]).max() > small * lengths.max():
            return None
        size, yaw = _ellipse(squared[:2, :2], linear)
        return [*size, math.sqrt(squared[2, 2])], yaw
    if shape == "cylinder":
        if max(abs(linear[2, :2]).max(), abs(linear[:2, 2]).max()) > small:
            return None
        size, yaw = _ellipse(linear[:2, :2] @ linear[:2, :2].T, linear)
        return [*size, float(abs(linear[2, 2]))], yaw
    order = [0, 1, 2]
    if shape == "box":  # whichever axis points up
        upwards = abs(linear[2]) / np.where(lengths > 0, lengths, 1.0)
        up = int(np.argmax(upwards) if upwards.max() > 0.5 else np.argmin(lengths))  # none points up in a slab
        order = [k for k in range(3) if k != up] + [up]
    along, across, upward = (linear[:, k] for k in order)
    level = max(abs(along[2]), abs(across[2])) <= small and abs(along @ across) <= small * lengths.max()
    if not level or (shape != "plane" and abs(upward[:2]).max() > small):
        return None
    return [float(lengths[k]) for k in order], math.atan2(along[1], along[0])


def _ellipse(squared: np.ndarray, linear: np.ndarray) -> tuple[list[float], float]:
    """Full extents and yaw of an ellipse with the matrix [2, 2] of its squared axes.

    The axis nearest to the image of x under `linear` is the length; a circle keeps that direction.
    """
    values, vectors = np.linalg.eigh(squared)
    ahead = math.atan2(linear[1, 0], linear[0, 0])
    if values[1] - values[0] <= 1e-9 * values[1]:
        return [math.sqrt(max(values[1], 0.0))] * 2, ahead
    yaws = [math.atan2(vectors[1, k], vectors[0, k]) for k in (0, 1)]
    first = min((0, 1), key=lambda k: abs(math.remainder(yaws[k] - ahead, math.pi)))
    size = [math.sqrt(max(values[k], 0.0)) for k in (first, 1 - first)]
    return size, ahead + math.remainder(yaws[first] - ahead, math.pi)
