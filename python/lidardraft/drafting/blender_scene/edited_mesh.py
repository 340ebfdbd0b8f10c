"""A mesh that is being edited: vertices that can be moved one by one, and faces between them."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from lidardraft.drafting.blender_scene.blocks import Unread
from lidardraft.drafting.blender_scene.mesh_shapes import MeshShape, polygons_of, polyhedron
from lidardraft.drafting.blender_scene.meshes import Mesh
from lidardraft.drafting.blender_scene.vectors import IDENTITY, Matrix, Vector
from lidardraft.drafting.script.limits import Budget, RaisedError, RefusalError
from lidardraft.drafting.script.values import Builtin, Record, Value, describe, elements, reals

_STEPS = 6  # that a vertex or a face costs
_CELLS = 8
_LOOKS = ("select", "smooth", "material_index", "hide", "tag", "index", "seam")


class EditedVertex(Record):
    """A vertex."""

    kind = "a BMVert"
    is_key = True

    def __init__(self, place: list[float]) -> None:
        self.place = Vector(place)

    def attribute(self, name: str) -> Value:
        return self.place if name == "co" else super().attribute(name)

    def set_attribute(self, name: str, value: Value) -> None:
        if name == "co":
            self.place.numbers = list(reals(value, 3, "the place of a vertex"))
        elif name not in _LOOKS:
            super().set_attribute(name, value)


class EditedFace(Record):
    """A polygon."""

    kind = "a BMFace"
    is_key = True

    def __init__(self, corners: list[EditedVertex], budget: Budget) -> None:
        self.corners = corners
        self._budget = budget

    def attribute(self, name: str) -> Value:
        if name == "verts":
            self._budget.take_steps(len(self.corners) // 4)
            return list(self.corners)
        if name in ("calc_center_median", "calc_center_bounds"):
            return Builtin(name, lambda: Vector(self._places().mean(axis=0).tolist()))
        if name == "normal":
            return Vector(self._normal().tolist())
        return Builtin(name, lambda: None) if name in ("normal_update", "normal_flip") else super().attribute(name)

    def set_attribute(self, name: str, value: Value) -> None:
        if name not in _LOOKS:
            super().set_attribute(name, value)

    def _places(self) -> np.ndarray:
        self._budget.take_steps(6 * _STEPS + len(self.corners))
        return np.array([corner.place.numbers for corner in self.corners])

    def _normal(self) -> np.ndarray:
        places = self._places()
        normal = np.cross(places, np.roll(places, -1, axis=0)).sum(axis=0)  # Newell's
        length = np.linalg.norm(normal)
        return np.asarray(normal / length if length else normal)


class EditedEdge(Record):
    """An edge between two vertices."""

    kind = "a BMEdge"
    is_key = True
    weight = 2

    def __init__(self, verts: tuple[EditedVertex, EditedVertex]) -> None:
        self.verts = verts

    def attribute(self, name: str) -> Value:
        if name == "verts":
            return list(self.verts)
        if name == "calc_length":
            return Builtin(name, lambda: math.dist(*(vertex.place.numbers for vertex in self.verts)))
        return super().attribute(name)

    def set_attribute(self, name: str, value: Value) -> None:
        if name not in _LOOKS:
            super().set_attribute(name, value)


class EditedMesh(Record):
    """`bmesh.types.BMesh`."""

    kind = "a BMesh"

    def __init__(self, budget: Budget, note: Callable[[str], None]) -> None:
        self.budget = budget
        self.vertices: list[EditedVertex] = []
        self.faces: list[EditedFace] = []
        self._note = note

    def attribute(self, name: str) -> Value:
        if name in ("verts", "faces"):
            return EditedElements(self, name)
        if name == "edges":
            return EditedEdges(self)
        if name in ("loops", "select_history", "select_mode"):
            return Unread(f"{name} of a BMesh", self._note)
        methods: dict[str, Callable[..., Value]] = {
            "to_mesh": self.to_mesh,
            "from_mesh": self.take_mesh,
            "transform": lambda matrix, **_: self.transform(matrix, self.vertices),
            "free": lambda: None,
            "normal_update": lambda: None,
            "clear": self._clear,
            "copy": self.copy,
        }
        return Builtin(name, methods[name]) if name in methods else super().attribute(name)

    def edges(self) -> list[EditedEdge]:
        """The edges of its faces; those of no face are in no shape."""
        sides = sum(len(face.corners) for face in self.faces)
        self.budget.take_steps(2 * sides)
        self.budget.take_cells(_CELLS * sides)
        found: dict[frozenset[EditedVertex], tuple[EditedVertex, EditedVertex]] = {}
        for face in self.faces:
            for pair in zip(face.corners, face.corners[1:] + face.corners[:1], strict=True):
                found.setdefault(frozenset(pair), pair)
        return [EditedEdge(pair) for pair in found.values()]

    def charge(self, count: int) -> None:
        """Count so many vertices and faces, before they are made."""
        self.budget.take_steps(_STEPS * count)
        self.budget.take_cells(_CELLS * count)

    def add(self, vertices: np.ndarray, faces: list[list[int]]) -> list[EditedVertex]:
        """Add vertices [V, 3] and faces between them, which are charged already; gives the new vertices."""
        made = [EditedVertex(place) for place in vertices.tolist()]
        self.vertices += made
        self.faces += [EditedFace([made[corner] for corner in face], self.budget) for face in faces]
        return made

    def transform(self, matrix: Value, vertices: list[EditedVertex]) -> None:
        """Move vertices by a matrix of 3 or 4 rows."""
        if not isinstance(matrix, Matrix):
            raise RefusalError(f"vertices are moved by {describe(matrix)}; it must be a Matrix")
        offset = matrix.array[:3, 3] if len(matrix.array) == 4 else np.zeros(3)
        self.budget.take_steps(_STEPS + len(vertices))
        if vertices:
            places = np.array([vertex.place.numbers for vertex in vertices]) @ matrix.array[:3, :3].T + offset
            for vertex, place in zip(vertices, places.tolist(), strict=True):
                vertex.place.numbers = place

    def _clear(self) -> None:
        self.vertices.clear()
        self.faces.clear()

    def copy(self) -> EditedMesh:
        """Another one with vertices and faces of its own."""
        other = EditedMesh(self.budget, self._note)
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

    def shape(self) -> MeshShape | None:
        """The mesh that it is now; None without a face."""
        self.budget.take_steps(len(self.vertices) + len(self.faces))
        places, corners = self._places(), self._corners()
        polygons = polygons_of(corners)
        self.budget.take_steps(2 * len(polygons))
        return polyhedron(places, polygons) if polygons else None

    def to_mesh(self, mesh: Value) -> None:
        """Make a mesh of it."""
        if not isinstance(mesh, Mesh):
            raise RefusalError(f"{describe(mesh)} is no mesh")
        mesh.shape, mesh.matrix = self.shape(), IDENTITY

    def take_mesh(self, mesh: Value, **_: Value) -> None:
        """Add what a mesh has."""
        if not isinstance(mesh, Mesh):
            raise RefusalError(f"{describe(mesh)} is no mesh")
        if mesh.shape is not None:
            self.charge(3 * mesh.shape.vertices)
            vertices, polygons = mesh.shape.make()
            faces = [face for each in polygons for face in each.tolist()]
            self.add(vertices @ mesh.matrix[:3, :3].T + mesh.matrix[:3, 3], faces)


class EditedEdges(Record):
    """The edges of a mesh that is being edited."""

    kind = "`edges` of a BMesh"

    def __init__(self, mesh: EditedMesh) -> None:
        self._mesh = mesh

    def elements(self) -> list[Value]:
        return list(self._mesh.edges())

    def attribute(self, name: str) -> Value:
        if name not in ("new", "ensure_lookup_table", "index_update"):
            return super().attribute(name)
        return Builtin(f"edges.{name}", lambda *_: None)  # an edge of no face is in no shape

    def item(self, key: Value) -> Value:
        edges = self._mesh.edges()
        if not isinstance(key, slice) and (not isinstance(key, int) or not -len(edges) <= key < len(edges)):
            raise RefusalError(f"{self.kind} has no place {describe(key)}")
        return edges[key]


class EditedElements(Record):
    """The vertices, or the faces, of a mesh that is being edited."""

    def __init__(self, mesh: EditedMesh, name: str) -> None:
        self.kind = f"`{name}` of a BMesh"
        self._mesh = mesh
        self._name = name

    def elements(self) -> list[Value]:
        return list(self._mesh.vertices if self._name == "verts" else self._mesh.faces)

    def length(self) -> int:
        return len(self._mesh.vertices if self._name == "verts" else self._mesh.faces)

    def attribute(self, name: str) -> Value:
        methods: dict[str, Callable[..., Value]] = {
            "new": self._new_vertex if self._name == "verts" else self._new_face,
            "remove": self._remove,
            "ensure_lookup_table": lambda: None,
            "index_update": lambda: None,
        }
        return Builtin(f"{self._name}.{name}", methods[name]) if name in methods else super().attribute(name)

    def item(self, key: Value) -> Value:
        items = self._mesh.vertices if self._name == "verts" else self._mesh.faces
        if isinstance(key, slice):
            self._mesh.budget.take_cells(len(items))
        elif not isinstance(key, int) or not -len(items) <= key < len(items):
            raise RefusalError(f"{self.kind} has no place {describe(key)}")
        return items[key]

    def truth(self) -> bool:
        return self.length() > 0

    def _new_vertex(self, co: Value = (0.0, 0.0, 0.0), *_: Value) -> EditedVertex:
        self._mesh.charge(1)
        self._mesh.vertices.append(EditedVertex(list(reals(co, 3, "a vertex"))))
        return self._mesh.vertices[-1]

    def _new_face(self, verts: Value, *_: Value) -> EditedFace:
        corners = elements(verts, self._mesh.budget)
        self._mesh.budget.take_steps(len(corners))
        self._mesh.charge(1)
        if not all(isinstance(corner, EditedVertex) for corner in corners):
            raise RefusalError("a face of what is no vertex")
        if len(corners) < 3 or len(set(corners)) < len(corners):
            raise RaisedError("ValueError", f"a face of {len(set(corners))} vertices; it needs 3 or more, each once")
        self._mesh.faces.append(EditedFace(corners, self._mesh.budget))
        return self._mesh.faces[-1]

    def _remove(self, item: Value) -> None:
        items: list[Value] = list(self.elements())
        self._mesh.budget.take_steps(len(items))
        if item not in items:
            raise RefusalError(f"{describe(item)} is not in {self.kind}")
        if self._name == "faces":
            self._mesh.faces.remove(item)
        else:
            self._mesh.vertices.remove(item)
            self._mesh.faces = [face for face in self._mesh.faces if item not in face.corners]
