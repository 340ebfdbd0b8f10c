"""Meshes and their materials, as `bpy.data` holds them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from lidardraft.drafting.blender_scene.blocks import Block, Blocks, Unread
from lidardraft.drafting.blender_scene.mesh_shapes import MeshShape, polygons_of, polyhedron
from lidardraft.drafting.blender_scene.vectors import IDENTITY, Matrix, Vector
from lidardraft.drafting.script.limits import RefusalError
from lidardraft.drafting.script.values import Builtin, Record, Value, describe, elements, is_number, reals, whole

_STEPS, _CELLS = 2, 8  # that a vertex costs which a script moves
_STEPS_OF_COPY = 10
_MESH_ELEMENTS = ("edges", "polygons", "loops", "uv_layers", "vertex_colors", "color_attributes", "attributes")


class Material(Block):
    """A material, of which the name is read alone."""

    kind = "a material"

    def attribute(self, name: str) -> Value:
        if name in ("node_tree", "diffuse_color", "use_nodes"):
            return Unread(f"{name} of materials", self.owner.note)
        return super().attribute(name)

    def set_attribute(self, name: str, value: Value) -> None:
        if name == "name":
            super().set_attribute(name, value)
        else:
            self.owner.note("what materials look like is passed over")


class MaterialList(Record):
    """The materials of a mesh, in order."""

    kind = "the materials of a mesh"

    def __init__(self) -> None:
        self.materials: list[Material | None] = []

    def attribute(self, name: str) -> Value:
        methods: dict[str, Callable[..., Value]] = {
            "append": self.append,
            "clear": self.materials.clear,
            "pop": lambda index=-1, **_: self.materials.pop(whole(index, "the index")),
        }
        return Builtin(name, methods[name]) if name in methods else super().attribute(name)

    def append(self, material: Value) -> None:
        """Add a material."""
        if not isinstance(material, Material | None):
            raise RefusalError(f"{describe(material)} is no material")
        if len(self.materials) >= 256:
            raise RefusalError("a mesh of more than 256 materials")
        self.materials.append(material)

    def elements(self) -> list[Value]:
        return list(self.materials)

    def item(self, key: Value) -> Value:
        return self.materials[self._place(key)]

    def set_item(self, key: Value, value: Value) -> None:
        if not isinstance(value, Material | None):
            raise RefusalError(f"{describe(value)} is no material")
        self.materials[self._place(key)] = value

    def _place(self, key: Value) -> int:
        if not isinstance(key, int) or not -len(self.materials) <= key < len(self.materials):
            raise RefusalError(f"the mesh has no material {describe(key)}")
        return key

    def truth(self) -> bool:
        return bool(self.materials)


class Mesh(Block):
    """A mesh: the shape that it is made from, what has been done to that, and its materials."""

    kind = "a mesh"
    ignored = ("use_auto_smooth", "auto_smooth_angle")

    def __init__(self, owner: Blocks, shape: MeshShape | None = None) -> None:
        super().__init__(owner)
        self.shape = shape
        self.matrix = IDENTITY
        self.materials = MaterialList()
        self._vertices: list[Vertex] = []
        self._read: MeshShape | None = None  # the shape that these are of

    def attribute(self, name: str) -> Value:
        if name == "materials":
            return self.materials
        if name == "vertices":
            return MeshVertices(self)
        if name in _MESH_ELEMENTS:
            return MeshElements(self, name)
        methods: dict[str, Callable[..., Value]] = {
            "from_pydata": self._from_pydata,
            "copy": self.copy,
            "validate": lambda **_: False,
            "update": lambda **_: None,
            "calc_normals": lambda: None,
            "shade_smooth": lambda: None,
            "shade_flat": lambda: None,
            "transform": self._transform,
        }
        return Builtin(name, methods[name]) if name in methods else super().attribute(name)

    def copy(self) -> Mesh:
        """Another mesh of the same shape and materials."""
        self.owner.budget.take_steps(_STEPS_OF_COPY)
        self.owner.budget.take_cells(3 * len(self.properties) + len(self.materials.materials))
        mesh: Mesh = self.owner.new(self.name)
        mesh.shape, mesh.matrix = self.shape, self.matrix
        mesh.materials.materials = list(self.materials.materials)
        mesh.properties = dict(self.properties)
        return mesh

    def vertices(self) -> list[Vertex]:
        """Its vertices; it follows where they are moved."""
        if self._vertices and self._read is self.shape:
            return self._vertices
        if self.shape is None:
            return []
        self.owner.budget.take_steps(_STEPS * self.shape.vertices)
        self.owner.budget.take_cells(_CELLS * self.shape.vertices)
        places, faces = self.shape.make()
        places = places @ self.matrix[:3, :3].T + self.matrix[:3, 3]
        vertices = [Vertex(number, Vector(place)) for number, place in enumerate(places.tolist())]
        read = lambda: (np.array([vertex.place.numbers for vertex in vertices]), faces)  # noqa: E731
        self.shape, self.matrix = dataclasses.replace(self.shape, shape="any", make=read), IDENTITY
        self._vertices, self._read = vertices, self.shape
        return vertices

    def _transform(self, matrix: Value) -> None:
        if not isinstance(matrix, Matrix) or matrix.array.shape != (4, 4):
            raise RefusalError("a mesh is transformed by a matrix of 4 rows")
        self.matrix = matrix.array @ self.matrix

    def _from_pydata(self, vertices: Value, edges: Value, faces: Value, *_: Value) -> None:
        budget = self.owner.budget
        budget.take_steps(len(elements(vertices, budget)) + len(elements(edges, budget)) + len(elements(faces, budget)))
        points = np.array([reals(v, 3, "a vertex") for v in elements(vertices, budget)]).reshape(-1, 3)
        polygons: list[tuple[int, ...]] = []
        for face in elements(faces, budget):
            corners = tuple(elements(face, budget))
            if not all(type(corner) is int and 0 <= corner < len(points) for corner in corners):
                raise RefusalError(f"face {len(polygons)} is {corners!r:.60}; the mesh has {len(points)} vertices")
            polygons.append(corners)
        shaped = polygons_of(polygons)
        budget.take_steps(2 * len(shaped))
        self.shape = polyhedron(points, shaped) if shaped else None


class Vertex(Record):
    """A vertex of a mesh."""

    kind = "a vertex"

    def __init__(self, number: int, place: Vector) -> None:
        self._number = number
        self.place = place

    def attribute(self, name: str) -> Value:
        if name == "co":
            return self.place
        return self._number if name == "index" else super().attribute(name)

    def set_attribute(self, name: str, value: Value) -> None:
        if name == "co":
            self.place.numbers = list(reals(value, 3, "the place of a vertex"))
        elif name not in ("select", "hide"):
            super().set_attribute(name, value)


class MeshVertices(Record):
    """The vertices of a mesh."""

    kind = "`vertices` of a mesh"

    def __init__(self, mesh: Mesh) -> None:
        self._mesh = mesh

    def elements(self) -> list[Value]:
        return list(self._mesh.vertices())

    def length(self) -> int:
        return self._mesh.shape.vertices if self._mesh.shape else 0

    def item(self, key: Value) -> Value:
        vertices = self._mesh.vertices()
        if isinstance(key, slice):
            return vertices[key]
        if not isinstance(key, int) or not -len(vertices) <= key < len(vertices):
            raise RefusalError(f"{self.kind} has no place {describe(key)}")
        return vertices[key]

    def truth(self) -> bool:
        return self._mesh.shape is not None


class MeshElements(Record):
    """The faces, edges and so on of a mesh: how many there are, and that they are not changed here."""

    def __init__(self, mesh: Mesh, name: str) -> None:
        self.kind = f"`{name}` of a mesh"
        self._mesh = mesh
        self._name = name

    def attribute(self, name: str) -> Value:
        if self._name == "edges":
            return super().attribute(name)
        return Unread(self.kind, self._mesh.owner.note).attribute(name)

    def elements(self) -> list[Value]:
        if self._name == "edges":
            raise RefusalError(f"{self.kind} cannot be looped over")
        return Unread(self.kind, self._mesh.owner.note).elements()

    def item(self, key: Value) -> Value:
        return self.attribute("item") if self._name != "edges" else super().item(key)

    def truth(self) -> bool:
        return self._mesh.shape is not None


def scale_of(value: Value) -> tuple[float, ...]:
    """Three factors, or one for all axes."""
    return (float(value),) * 3 if is_number(value) else reals(value, 3, "the scale")
