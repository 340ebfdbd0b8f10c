"""`bmesh.ops`: shapes that are added to a mesh that is being edited, and what moves its vertices."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lidardraft.drafting.blender_scene import mesh_shapes
from lidardraft.drafting.blender_scene.edited_mesh import EditedFace, EditedMesh, EditedVertex
from lidardraft.drafting.blender_scene.mesh_shapes import MeshShape
from lidardraft.drafting.blender_scene.rotations import affine
from lidardraft.drafting.blender_scene.vectors import Matrix
from lidardraft.drafting.script.limits import RefusalError
from lidardraft.drafting.script.values import Value, describe, elements, real, reals, truth, whole

_ORIGIN = (0.0, 0.0, 0.0)
_STEPS = 15  # that what is done with a small array costs
# What leaves a surface where it is, or nearly so.
_PASSED_OVER = ("recalc_face_normals", "remove_doubles", "triangulate", "reverse_faces", "join_triangles", "bevel")


def bmesh_operators(note: Callable[[str], None]) -> dict[str, Callable[..., Value]]:
    """The operators by their names."""

    def passed_over(name: str) -> Callable[..., Value]:
        return lambda *_, **__: note(f"bmesh.ops.{name} is passed over")

    return _flat_shapes() | _round_shapes() | _moves() | _cuts() | {name: passed_over(name) for name in _PASSED_OVER}


def _flat_shapes() -> dict[str, Callable[..., Value]]:
    def create_cube(bm: Value, size: Value = 1.0, matrix: Value = None, **_: Value) -> Value:
        return _added(bm, mesh_shapes.cube(real(size, "the size")), matrix)

    def create_grid(
        bm: Value, x_segments: Value = 1, y_segments: Value = 1, size: Value = 1.0, matrix: Value = None, **_: Value
    ) -> Value:
        counts = _counted(bm, x_segments, 1, "x_segments"), _counted(bm, y_segments, 1, "y_segments")
        return _added(bm, mesh_shapes.grid(2 * real(size, "the size"), *counts), matrix)

    def create_circle(
        bm: Value, cap_ends: Value = False, segments: Value = 32, radius: Value = 1.0, matrix: Value = None, **_: Value
    ) -> Value:
        shape = mesh_shapes.disc(real(radius, "the radius"), _counted(bm, segments, 3, "segments"))
        if not truth(cap_ends):
            raise RefusalError("a circle without cap_ends=True has no face")
        return _added(bm, shape, matrix)

    return {maker.__name__: maker for maker in (create_cube, create_grid, create_circle)}


def _round_shapes() -> dict[str, Callable[..., Value]]:
    def create_cone(
        bm: Value,
        cap_ends: Value = False,
        segments: Value = 32,
        radius1: Value = 1.0,
        radius2: Value = 0.0,
        depth: Value = 2.0,
        matrix: Value = None,
        **_: Value,
    ) -> Value:
        radii = real(radius1, "radius1"), real(radius2, "radius2")
        corners = _counted(bm, segments, 3, "segments")
        return _added(bm, mesh_shapes.cone(*radii, real(depth, "depth"), corners, capped=truth(cap_ends)), matrix)

    def create_uvsphere(
        bm: Value, u_segments: Value = 32, v_segments: Value = 16, radius: Value = 1.0, matrix: Value = None, **_: Value
    ) -> Value:
        counts = _counted(bm, u_segments, 3, "u_segments"), _counted(bm, v_segments, 3, "v_segments")
        if counts[0] * counts[1] > bm.budget.limits.length if isinstance(bm, EditedMesh) else True:
            raise RefusalError("a sphere of too many segments")
        return _added(bm, mesh_shapes.sphere(real(radius, "the radius"), *counts), matrix)

    def create_icosphere(
        bm: Value, subdivisions: Value = 2, radius: Value = 1.0, matrix: Value = None, **_: Value
    ) -> Value:
        count = whole(subdivisions, "subdivisions")
        if not 1 <= count <= 6:
            raise RefusalError(f"subdivisions is {count}; it must be 1 to 6")
        return _added(bm, mesh_shapes.icosphere(real(radius, "the radius"), count), matrix)

    return {maker.__name__: maker for maker in (create_cone, create_uvsphere, create_icosphere)}


def _moves() -> dict[str, Callable[..., Value]]:
    def moved(mesh: Value, verts: Value, linear: np.ndarray, offset: np.ndarray, space: Value) -> None:
        matrix = affine(linear, offset)
        _mesh(mesh).budget.take_steps(_STEPS)
        if isinstance(space, Matrix) and space.array.shape == (4, 4):
            mesh.budget.take_steps(4 * _STEPS)
            matrix = np.linalg.pinv(space.array) @ matrix @ space.array
        _mesh(mesh).transform(Matrix(matrix), _vertices(mesh, verts))

    def translate(bm: Value, vec: Value = _ORIGIN, verts: Value = (), space: Value = None, **_: Value) -> None:
        moved(bm, verts, np.eye(3), np.array(reals(vec, 3, "the way")), space)

    def scale(bm: Value, vec: Value = (1.0, 1.0, 1.0), verts: Value = (), space: Value = None, **_: Value) -> None:
        moved(bm, verts, np.diag(reals(vec, 3, "the scale")), np.zeros(3), space)

    def rotate(
        bm: Value, cent: Value = _ORIGIN, matrix: Value = None, verts: Value = (), space: Value = None, **_: Value
    ) -> None:
        if not isinstance(matrix, Matrix):
            raise RefusalError(f"rotate by {describe(matrix)}; it must be a Matrix")
        turn, middle = matrix.array[:3, :3], np.array(reals(cent, 3, "the centre"))
        moved(bm, verts, turn, middle - turn @ middle, space)

    def transform(bm: Value, matrix: Value = None, verts: Value = (), **_: Value) -> None:
        _mesh(bm).transform(matrix, _vertices(bm, verts))

    return {operator.__name__: operator for operator in (translate, scale, rotate, transform)}


def _cuts() -> dict[str, Callable[..., Value]]:
    def extrude_face_region(bm: Value, geom: Value = (), **_: Value) -> Value:
        _mesh(bm).budget.take_steps(_STEPS)
        faces = [item for item in elements(geom, _mesh(bm).budget) if isinstance(item, EditedFace)]
        corners = list(dict.fromkeys(corner for face in faces for corner in face.corners))
        place = {corner: number for number, corner in enumerate(corners)}
        top = [[place[corner] for corner in face.corners] for face in faces]
        first = len(bm.faces)
        bm.charge(len(corners) + len(top))
        made = bm.add(np.array([corner.place.numbers for corner in corners]).reshape(-1, 3), top)
        edges = {(a, b) for face in top for a, b in zip(face, face[1:] + face[:1], strict=True)}
        rim = sorted(edge for edge in edges if edge[::-1] not in edges)  # edges within the region get no side
        bm.charge(len(rim))
        caps = bm.faces[first:]
        bm.faces += [EditedFace([corners[a], corners[b], made[b], made[a]], bm.budget) for a, b in rim]
        return {"geom": [*made, *caps]}

    def delete(bm: Value, geom: Value = (), context: Value = "VERTS", **_: Value) -> None:
        gone = set(elements(geom, _mesh(bm).budget))
        if context not in ("VERTS", "FACES", "FACES_ONLY"):
            raise RefusalError(f"delete in the context {describe(context)} is not read")
        bm.budget.take_steps(3 * len(bm.faces) + len(bm.vertices))
        if context == "VERTS":
            bm.faces = [face for face in bm.faces if not gone.intersection(face.corners)]
        else:
            lost = [face for face in bm.faces if face in gone]
            bm.faces = [face for face in bm.faces if face not in gone]
            # With its faces go the vertices of no other one; FACES_ONLY leaves them.
            kept = {corner for face in bm.faces for corner in face.corners}
            gone = {corner for face in lost for corner in face.corners} - kept if context == "FACES" else set()
        bm.vertices = [vertex for vertex in bm.vertices if vertex not in gone]

    return {"extrude_face_region": extrude_face_region, "delete": delete}


def _added(mesh: Value, shape: MeshShape, matrix: Value) -> Value:
    _mesh(mesh).charge(3 * shape.vertices)  # each has two triangles at most
    vertices, polygons = shape.make()
    made = mesh.add(vertices, [face for each in polygons for face in each.tolist()])
    if matrix is not None:
        mesh.transform(matrix, made)
    return {"verts": made}


def _counted(mesh: Value, count: Value, least: int, what: str) -> int:
    number = whole(count, what)
    if not least <= number <= 500:
        raise RefusalError(f"{what} is {number}; it must be {least} to 500")
    return number if isinstance(mesh, EditedMesh) else 0


def _mesh(value: Value) -> EditedMesh:
    if not isinstance(value, EditedMesh):
        raise RefusalError(f"{describe(value)} is no BMesh")
    return value


def _vertices(mesh: EditedMesh, value: Value) -> list[EditedVertex]:
    found = elements(value, mesh.budget)
    if not all(isinstance(vertex, EditedVertex) for vertex in found):
        raise RefusalError("vertices are moved that are none")
    return found
