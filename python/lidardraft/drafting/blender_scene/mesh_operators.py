"""`bpy.ops.mesh.primitive_*_add`: new objects with a mesh of a known shape."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lidardraft.drafting.blender_scene import mesh_shapes
from lidardraft.drafting.blender_scene.mesh_shapes import MeshShape
from lidardraft.drafting.blender_scene.meshes import Mesh, scale_of
from lidardraft.drafting.blender_scene.scene import Scene
from lidardraft.drafting.script.limits import RefusalError
from lidardraft.drafting.script.values import Value, describe, real, reals, whole

_STEPS = 30  # that an object costs
_ORIGIN = (0.0, 0.0, 0.0)
_NO_SCALE = (1.0, 1.0, 1.0)


def mesh_operators(scene: Scene) -> dict[str, Callable[..., Value]]:
    """The operators by their names behind `bpy.ops.`."""
    shapes = (*_plain(scene), *_round(scene))
    return {f"mesh.primitive_{shape.__name__}_add": shape for shape in shapes}


def _plain(scene: Scene) -> tuple[Callable[..., Value], ...]:
    def cube(size: Value = 2.0, **where: Value) -> Value:
        return _add(scene, "Cube", mesh_shapes.cube(real(size, "the size")), **where)

    def plane(size: Value = 2.0, **where: Value) -> Value:
        return _add(scene, "Plane", mesh_shapes.plane(real(size, "the size")), **where)

    def grid(x_subdivisions: Value = 10, y_subdivisions: Value = 10, size: Value = 2.0, **where: Value) -> Value:
        counts = _count(x_subdivisions, 1, "x_subdivisions"), _count(y_subdivisions, 1, "y_subdivisions")
        return _add(scene, "Grid", mesh_shapes.grid(real(size, "the size"), *counts), **where)

    def circle(vertices: Value = 32, radius: Value = 1.0, fill_type: Value = "NOTHING", **where: Value) -> Value:
        corners, across = _count(vertices, 3, "vertices"), real(radius, "the radius")
        return _add(scene, "Circle", mesh_shapes.disc(across, corners) if fill_type != "NOTHING" else None, **where)

    def monkey(**_: Value) -> Value:
        raise RefusalError("a monkey is no shape of a layout")

    return cube, plane, grid, circle, monkey


def _round(scene: Scene) -> tuple[Callable[..., Value], ...]:
    def cylinder(
        vertices: Value = 32,
        radius: Value = 1.0,
        depth: Value = 2.0,
        end_fill_type: Value = "NGON",
        **where: Value,
    ) -> Value:
        corners, across, height = _count(vertices, 3, "vertices"), real(radius, "the radius"), real(depth, "the depth")
        shape = mesh_shapes.cone(across, across, height, corners, capped=end_fill_type != "NOTHING")
        return _add(scene, "Cylinder", shape, **where)

    def cone(
        vertices: Value = 32,
        radius1: Value = 1.0,
        radius2: Value = 0.0,
        depth: Value = 2.0,
        end_fill_type: Value = "NGON",
        **where: Value,
    ) -> Value:
        radii = real(radius1, "radius1"), real(radius2, "radius2")
        corners, capped = _count(vertices, 3, "vertices"), end_fill_type != "NOTHING"
        return _add(scene, "Cone", mesh_shapes.cone(*radii, real(depth, "the depth"), corners, capped=capped), **where)

    def uv_sphere(segments: Value = 32, ring_count: Value = 16, radius: Value = 1.0, **where: Value) -> Value:
        counts = _count(segments, 3, "segments"), _count(ring_count, 3, "ring_count")
        return _add(scene, "Sphere", mesh_shapes.sphere(real(radius, "the radius"), *counts), **where)

    def ico_sphere(subdivisions: Value = 2, radius: Value = 1.0, **where: Value) -> Value:
        count = _count(subdivisions, 1, "subdivisions", most=8)
        return _add(scene, "Icosphere", mesh_shapes.icosphere(real(radius, "the radius"), count), **where)

    def torus(
        major_segments: Value = 48,
        minor_segments: Value = 12,
        mode: Value = "MAJOR_MINOR",
        major_radius: Value = 1.0,
        minor_radius: Value = 0.25,
        abso_major_rad: Value = 1.25,
        abso_minor_rad: Value = 0.75,
        **where: Value,
    ) -> Value:
        major, minor = real(major_radius, "the major radius"), real(minor_radius, "the minor radius")
        if mode == "EXT_INT":  # the radius outside and that of the hole
            outer, inner = real(abso_major_rad, "abso_major_rad"), real(abso_minor_rad, "abso_minor_rad")
            major, minor = (outer + inner) / 2, (outer - inner) / 2
        counts = _count(major_segments, 3, "major_segments"), _count(minor_segments, 3, "minor_segments")
        return _add(scene, "Torus", mesh_shapes.torus(major, minor, *counts), **where)

    return cylinder, cone, uv_sphere, ico_sphere, torus


def _add(
    scene: Scene,
    name: str,
    shape: MeshShape | None,
    *,
    location: Value = None,
    rotation: Value = _ORIGIN,
    scale: Value = _NO_SCALE,
    align: Value = "WORLD",
    **others: Value,
) -> Value:
    unknown = set(others) - {"calc_uvs", "generate_uvs", "enter_editmode", "end_fill_type"}
    if unknown:
        raise RefusalError(f"there is no argument {min(unknown)!r:.60}")
    if align != "WORLD" or others.get("enter_editmode"):
        raise RefusalError(f"align={describe(align)} or enter_editmode is not read")
    scene.objects.budget.take_steps(_STEPS)
    mesh: Mesh = scene.meshes.new(name)
    mesh.shape = shape
    if scale is not _NO_SCALE:
        mesh.matrix = np.diag([*scale_of(scale), 1.0])
    item = scene.add(name, mesh)
    item.location.numbers = list(reals(scene.cursor if location is None else location, 3, "the location"))
    item.rotation.numbers = list(reals(rotation, 3, "the rotation"))
    return ["FINISHED"]


def _count(value: Value, least: int, what: str, most: int = 500) -> int:
    count = whole(value, what)
    if not least <= count <= most:
        raise RefusalError(f"{what} is {count}; it must be {least} to {most}")
    return count
