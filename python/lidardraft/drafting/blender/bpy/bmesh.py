"""`bmesh` for scripts: vertices and faces that are made, moved and extruded before they become a mesh."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import ClassVar

import numpy as np

from lidardraft.drafting.blender.bpy.blocks import Listing, ignored, unread
from lidardraft.drafting.blender.bpy.mathutils import IDENTITY, Matrix, Vector, affine, moved
from lidardraft.drafting.blender.bpy.meshes import SHAPES, Mesh, MeshShape, Vertex, polygons_of, polyhedron, shape_of
from lidardraft.drafting.blender.bpy.scene import Scene
from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script
from lidardraft.drafting.blender.script.values import (
    Methods,
    Namespace,
    Record,
    Value,
    builtins,
    describe,
    elements,
    nothing,
    of_kind,
    reals,
    type_of,
)

_CELLS = 8  # the cost of a vertex or a face
_ORIGIN = (0.0, 0.0, 0.0)
_LOOKS = ("select", "smooth", "material_index", "hide", "tag", "index", "seam")
_LOOKUP = dict.fromkeys(("ensure_lookup_table", "index_update"), nothing)
# Operators that leave a surface in place, or nearly so.
_PASSED_OVER = ("recalc_face_normals", "remove_doubles", "triangulate", "reverse_faces", "join_triangles", "bevel")


class Face(Record):
    """A polygon of an edited mesh."""

    kind = "a BMFace"
    is_key = True

    def __init__(self, corners: list[Vertex], script: Script) -> None:
        self.corners = corners
        self._script = script

    def _verts(self) -> list[Vertex]:
        return list(self.corners)

    def _places(self) -> np.ndarray:
        return np.array([corner.place.numbers for corner in self.corners])

    def _normal(self) -> Vector:
        places = self._places()
        normal = np.cross(places, np.roll(places, -1, axis=0)).sum(axis=0)  # Newell's
        return Vector((normal / (np.linalg.norm(normal) or 1.0)).tolist())

    def _middle_of_bounds(self) -> Vector:
        places = self._places()
        return Vector(((places.min(axis=0) + places.max(axis=0)) / 2).tolist())

    fields: ClassVar[Methods] = {"verts": _verts, "normal": _normal}
    setters: ClassVar[Methods] = ignored(*_LOOKS)
    methods: ClassVar[Methods] = {
        "calc_center_median": lambda self: Vector(self._places().mean(axis=0).tolist()),
        "calc_center_bounds": _middle_of_bounds,
        **dict.fromkeys(("normal_update", "normal_flip"), nothing),
    }


class Edge(Record):
    """An edge between two vertices."""

    kind = "a BMEdge"
    is_key = True

    def __init__(self, verts: tuple[Vertex, Vertex]) -> None:
        self.verts = verts

    fields: ClassVar[Methods] = {"verts": lambda self: list(self.verts)}
    setters: ClassVar[Methods] = ignored(*_LOOKS)
    methods: ClassVar[Methods] = {"calc_length": lambda self: math.dist(*(end.place.numbers for end in self.verts))}


class EditedMesh(Record):
    """`bmesh.types.BMesh`."""

    kind = "a BMesh"

    def __init__(self, script: Script) -> None:
        self.script = script
        self.vertices: list[Vertex] = []
        self.faces: list[Face] = []

    def edges(self) -> list[Edge]:
        """The edges of its faces; loose edges are in no shape."""
        sides = sum(len(face.corners) for face in self.faces)
        self.script.take_cells(_CELLS * sides)
        found: dict[frozenset[Vertex], tuple[Vertex, Vertex]] = {}
        for face in self.faces:
            for pair in zip(face.corners, face.corners[1:] + face.corners[:1], strict=True):
                found.setdefault(frozenset(pair), pair)
        return [Edge(pair) for pair in found.values()]

    def charge(self, count: int) -> None:
        """Count vertices and faces before they are made."""
        self.script.take_cells(_CELLS * count)

    def add(self, vertices: np.ndarray, faces: list[list[int]]) -> list[Vertex]:
        """Add vertices [V, 3] and faces between them, already charged; returns the new vertices."""
        made = [Vertex(place) for place in vertices.tolist()]
        self.vertices += made
        self.faces += [Face([made[corner] for corner in face], self.script) for face in faces]
        return made

    def add_shape(self, shape: MeshShape, matrix: np.ndarray = IDENTITY) -> list[Vertex]:
        """Add the vertices and faces of a shape, transformed by a matrix [4, 4]; returns the new vertices."""
        self.charge(3 * shape.vertices)  # each has two triangles at most
        vertices, polygons = shape.make()
        return self.add(moved(vertices, matrix), [face for each in polygons for face in each.tolist()])

    def transform(self, matrix: Value, vertices: list[Vertex]) -> None:
        """Move vertices by a matrix of 3 or 4 rows."""
        four_rows = of_kind(matrix, Matrix, "the matrix").four_rows()
        if vertices:
            places = moved(np.array([vertex.place.numbers for vertex in vertices]), four_rows)
            for vertex, place in zip(vertices, places.tolist(), strict=True):
                vertex.place.change(place)

    def _clear(self) -> None:
        self.vertices.clear()
        self.faces.clear()

    def copy(self) -> EditedMesh:
        """A copy with its own vertices and faces."""
        other = EditedMesh(self.script)
        other.charge(len(self.vertices) + len(self.faces))
        other.add(self._places(), self._corners())
        return other

    def _places(self) -> np.ndarray:
        return np.array([vertex.place.numbers for vertex in self.vertices]).reshape(-1, 3)

    def _corners(self) -> list[list[int]]:
        number = {vertex: place for place, vertex in enumerate(self.vertices)}
        if any(corner not in number for face in self.faces for corner in face.corners):
            raise RefusalError("a face of a BMesh has a vertex that has been removed, or is one of another BMesh")
        return [[number[corner] for corner in face.corners] for face in self.faces]

    def to_mesh(self, mesh: Value) -> None:
        """Write it to a mesh; without faces the mesh has no shape."""
        polygons = polygons_of(self._corners())
        of_kind(mesh, Mesh, "the mesh").shape = polyhedron(self._places(), polygons) if polygons else None
        mesh.matrix = IDENTITY

    def take_mesh(self, mesh: Value, **_: Value) -> None:
        """Add the vertices and faces of a mesh."""
        if (shape := of_kind(mesh, Mesh, "the mesh").shape) is not None:
            self.add_shape(shape, mesh.matrix)

    def _new_vertex(self, co: Value = _ORIGIN, *_: Value) -> Vertex:
        self.vertices.append(Vertex(list(reals(co, 3, "a vertex"))))
        return self.vertices[-1]

    def _new_face(self, verts: Value, *_: Value) -> Face:
        corners = [of_kind(corner, Vertex, "a corner of a face") for corner in elements(verts, self.script)]
        if len(corners) < 3 or len(set(corners)) < len(corners):
            raise RaisedError("ValueError", f"a face of {len(set(corners))} vertices; it needs 3 or more, each once")
        self.faces.append(Face(corners, self.script))
        return self.faces[-1]

    def _remove(self, parts: list[Value], part: Value) -> None:
        if part not in parts:
            raise RefusalError(f"{describe(part)} is not in this part of the BMesh")
        parts.remove(part)
        self.faces = [face for face in self.faces if part not in face.corners]

    def _verts(self) -> Listing:
        own: Methods = {"new": self._new_vertex, "remove": lambda part: self._remove(self.vertices, part)}
        return Listing("`verts` of a BMesh", lambda: self.vertices, own | _LOOKUP)

    def _faces(self) -> Listing:
        own: Methods = {"new": self._new_face, "remove": lambda part: self._remove(self.faces, part)}
        return Listing("`faces` of a BMesh", lambda: self.faces, own | _LOOKUP)

    fields: ClassVar[Methods] = {
        "verts": _verts,
        "faces": _faces,
        "edges": lambda self: Listing("`edges` of a BMesh", self.edges, {**_LOOKUP, "new": nothing}),
        **unread("a BMesh", "loops", "select_history", "select_mode"),
    }
    methods: ClassVar[Methods] = {
        "to_mesh": to_mesh,
        "from_mesh": take_mesh,
        "transform": lambda self, matrix, **_: self.transform(matrix, self.vertices),
        **dict.fromkeys(("free", "normal_update"), nothing),
        "clear": _clear,
        "copy": copy,
    }


def bmesh_module(scene: Scene) -> Namespace:
    """The module; its meshes go into the scene."""
    script = scene.script

    def from_edit_mesh(mesh: Value) -> EditedMesh:
        if not scene.edit_mode:
            raise RefusalError("from_edit_mesh outside of the edit mode")
        if of_kind(mesh, Mesh, "the mesh") not in scene.edited:
            scene.edited[mesh] = EditedMesh(script)
            scene.edited[mesh].take_mesh(mesh)
        return scene.edited[mesh]

    def passed_over(name: str) -> Callable[..., Value]:
        return lambda *_, **__: script.note(f"bmesh.ops.{name} is passed over")

    kinds = {"BMVert": Vertex, "BMFace": Face, "BMesh": EditedMesh, "BMEdge": Edge}
    operators: Methods = {"translate": _translate, "scale": _scale, "rotate": _rotate, "transform": _transform}
    operators |= {"extrude_face_region": _extrude_face_region, "delete": _delete}
    operators |= {name: _adding(name) for name in SHAPES if name.startswith("create_")} | {
        name: passed_over(name) for name in _PASSED_OVER
    }
    functions: Methods = {
        "new": lambda **_: EditedMesh(script),
        "from_edit_mesh": from_edit_mesh,
        "update_edit_mesh": lambda mesh, **_: of_kind(mesh, Mesh, "the mesh") and None,
    }
    parts = {
        "types": Namespace("bmesh.types", {name: type_of(kind) for name, kind in kinds.items()}),
        "ops": Namespace("bmesh.ops", builtins("bmesh.ops.", operators)),
    }
    return Namespace("bmesh", parts | builtins("bmesh.", functions))


def _adding(name: str) -> Callable[..., Value]:
    def add(bm: Value, matrix: Value = None, **given: Value) -> Value:
        mesh, shape = of_kind(bm, EditedMesh, "bm"), shape_of(name, given)
        if shape is None:
            raise RefusalError("a circle without cap_ends=True has no face")
        made = mesh.add_shape(shape)
        if matrix is not None:
            mesh.transform(matrix, made)
        return {"verts": made}

    return add


def _move(bm: Value, verts: Value, linear: np.ndarray, offset: np.ndarray, space: Value) -> None:
    mesh, matrix = of_kind(bm, EditedMesh, "bm"), affine(linear, offset)
    if isinstance(space, Matrix) and space.array.shape == (4, 4):
        matrix = np.linalg.pinv(space.array) @ matrix @ space.array
    _transform(mesh, Matrix(matrix), verts)


def _translate(bm: Value, vec: Value = _ORIGIN, verts: Value = (), space: Value = None, **_: Value) -> None:
    _move(bm, verts, np.eye(3), np.array(reals(vec, 3, "the way")), space)


def _scale(bm: Value, vec: Value = (1.0, 1.0, 1.0), verts: Value = (), space: Value = None, **_: Value) -> None:
    _move(bm, verts, np.diag(reals(vec, 3, "the scale")), np.zeros(3), space)


def _rotate(
    bm: Value, cent: Value = _ORIGIN, matrix: Value = None, verts: Value = (), space: Value = None, **_: Value
) -> None:
    turn, middle = of_kind(matrix, Matrix, "the matrix").array[:3, :3], np.array(reals(cent, 3, "the centre"))
    _move(bm, verts, turn, middle - turn @ middle, space)


def _transform(bm: Value, matrix: Value = None, verts: Value = (), **_: Value) -> None:
    mesh = of_kind(bm, EditedMesh, "bm")
    mesh.transform(matrix, [of_kind(vertex, Vertex, "what is moved") for vertex in elements(verts, mesh.script)])


def _extrude_face_region(bm: Value, geom: Value = (), **_: Value) -> Value:
    mesh = of_kind(bm, EditedMesh, "bm")
    faces = [item for item in elements(geom, mesh.script) if isinstance(item, Face)]
    corners = list(dict.fromkeys(corner for face in faces for corner in face.corners))
    place = {corner: number for number, corner in enumerate(corners)}
    top = [[place[corner] for corner in face.corners] for face in faces]
    first = len(mesh.faces)
    mesh.charge(len(corners) + len(top))
    made = mesh.add(np.array([corner.place.numbers for corner in corners]).reshape(-1, 3), top)
    edges = {(a, b) for face in top for a, b in zip(face, face[1:] + face[:1], strict=True)}
    rim = sorted(edge for edge in edges if edge[::-1] not in edges)  # edges within the region get no side
    mesh.charge(len(rim))
    caps = mesh.faces[first:]
    mesh.faces += [Face([corners[a], corners[b], made[b], made[a]], mesh.script) for a, b in rim]
    return {"geom": [*made, *caps]}


def _delete(bm: Value, geom: Value = (), context: Value = "VERTS", **_: Value) -> None:
    mesh = of_kind(bm, EditedMesh, "bm")
    gone = set(elements(geom, mesh.script))
    if context not in ("VERTS", "FACES", "FACES_ONLY"):
        raise RefusalError(f"delete in the context {describe(context)} is not supported")
    if context == "VERTS":
        mesh.faces = [face for face in mesh.faces if not gone.intersection(face.corners)]
    else:
        lost = [face for face in mesh.faces if face in gone]
        mesh.faces = [face for face in mesh.faces if face not in gone]
        # Vertices of deleted faces only are deleted too; FACES_ONLY leaves them.
        kept = {corner for face in mesh.faces for corner in face.corners}
        gone = {corner for face in lost for corner in face.corners} - kept if context == "FACES" else set()
    mesh.vertices = [vertex for vertex in mesh.vertices if vertex not in gone]
