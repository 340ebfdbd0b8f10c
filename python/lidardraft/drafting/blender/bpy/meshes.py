"""Meshes and their materials, as `bpy.data` holds them."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

import numpy as np

from lidardraft.drafting.blender.bpy.blocks import Block, Blocks, Listed, Unread, ignored
from lidardraft.drafting.blender.bpy.mathutils import IDENTITY, Matrix, Vector, moved
from lidardraft.drafting.blender.bpy.mesh_shapes import MeshShape, Polygons, polygons_of, polyhedron
from lidardraft.drafting.blender.script.limits import RefusalError
from lidardraft.drafting.blender.script.values import (
    Methods,
    Record,
    Value,
    elements,
    is_number,
    nothing,
    of_kind,
    reals,
    whole,
)

_STEPS, _CELLS = 2, 8  # that a vertex costs which a script moves
_STEPS_OF_COPY = 10
_MOST_MATERIALS = 256
_MESH_ELEMENTS = ("edges", "polygons", "loops", "uv_layers", "vertex_colors", "color_attributes", "attributes")


class Material(Block):
    """A material, of which the name is read alone."""

    kind = "a material"
    fields: ClassVar[Methods] = Block.fields | {
        name: lambda self, name=name: Unread(f"{name} of materials", self.script)
        for name in ("node_tree", "diffuse_color", "use_nodes")
    }

    def set_attribute(self, name: str, value: Value) -> None:
        if name == "name":
            super().set_attribute(name, value)
        else:
            self.script.note("what materials look like is passed over")


class MaterialList(Listed):
    """The materials of a mesh, in order."""

    kind = "the list of materials"

    def __init__(self) -> None:
        self.materials: list[Material | None] = []

    def append(self, material: Value) -> None:
        """Add a material."""
        if len(self.materials) >= _MOST_MATERIALS:
            raise RefusalError(f"a mesh of more than {_MOST_MATERIALS} materials")
        self.materials.append(_material(material))

    def held(self) -> list[Material | None]:
        return self.materials

    def set_item(self, key: Value, value: Value) -> None:
        self.item(whole(key, "the place of a material"))
        self.materials[key] = _material(value)

    methods: ClassVar[Methods] = Listed.methods | {
        "append": append,
        "clear": lambda self: self.materials.clear(),
        "pop": lambda self, index=-1, **_: self.materials.pop(whole(index, "the index")),
    }


def _material(value: Value) -> Material | None:
    return value if value is None else of_kind(value, Material, "the material")


class Mesh(Block):
    """A mesh: the shape that it is made from, what has been done to that, and its materials."""

    kind = "a mesh"

    def __init__(self, owner: Blocks, shape: MeshShape | None = None) -> None:
        super().__init__(owner)
        self.shape = shape
        self.matrix = IDENTITY
        self.materials = MaterialList()
        self._vertices: list[Vertex] = []
        self._read: MeshShape | None = None  # the shape that these are of

    def copy(self) -> Mesh:
        """Another mesh of the same shape and materials."""
        self.script.take_steps(_STEPS_OF_COPY)
        self.script.take_cells(3 * len(self.properties) + len(self.materials.materials))
        mesh: Mesh = self.owner.new(self.name)
        mesh.shape, mesh.matrix = self.shape, self.matrix
        mesh.materials.materials = list(self.materials.materials)
        mesh.properties = dict(self.properties)
        return mesh

    def made(self) -> tuple[np.ndarray, Polygons]:
        """Its vertices float64 [V, 3] and its faces; none, without a shape."""
        if self.shape is None:
            return np.zeros((0, 3)), []
        vertices, polygons = self.shape.make()
        return moved(vertices, self.matrix), polygons

    def vertices(self) -> list[Vertex]:
        """Its vertices; it follows where they are moved."""
        if self.shape is None or (self._vertices and self._read is self.shape):
            return self._vertices if self.shape else []
        self.script.take_steps(_STEPS * self.shape.vertices)
        self.script.take_cells(_CELLS * self.shape.vertices)
        places, faces = self.made()
        vertices = [Vertex(place, number) for number, place in enumerate(places.tolist())]
        self.shape = dataclasses.replace(
            self.shape, shape="any", make=lambda: (np.array([vertex.place.numbers for vertex in vertices]), faces)
        )
        self.matrix, self._vertices, self._read = IDENTITY, vertices, self.shape
        return vertices

    def _transform(self, matrix: Value) -> None:
        if not isinstance(matrix, Matrix) or matrix.array.shape != (4, 4):
            raise RefusalError("a mesh is transformed by a matrix of 4 rows")
        self.matrix = matrix.array @ self.matrix

    def _from_pydata(self, vertices: Value, edges: Value, faces: Value, *_: Value) -> None:
        script = self.script
        places, sides = elements(vertices, script), elements(faces, script)
        script.take_steps(len(places) + len(elements(edges, script)) + len(sides))
        points = np.array([reals(place, 3, "a vertex") for place in places]).reshape(-1, 3)
        polygons: list[tuple[int, ...]] = []
        for face in sides:
            corners = tuple(elements(face, script))
            if not all(type(corner) is int and 0 <= corner < len(points) for corner in corners):
                raise RefusalError(f"face {len(polygons)} is {corners!r:.60}; the mesh has {len(points)} vertices")
            polygons.append(corners)
        shaped = polygons_of(polygons)
        script.take_steps(2 * len(shaped))
        self.shape = polyhedron(points, shaped) if shaped else None

    fields: ClassVar[Methods] = {
        **Block.fields,
        "materials": lambda self: self.materials,
        "vertices": lambda self: MeshVertices(self),
        **{name: lambda self, name=name: MeshElements(self, name) for name in _MESH_ELEMENTS},
    }
    setters: ClassVar[Methods] = Block.setters | ignored("use_auto_smooth", "auto_smooth_angle")
    methods: ClassVar[Methods] = {
        **Block.methods,
        "from_pydata": _from_pydata,
        "copy": copy,
        "validate": lambda _, **__: False,
        **dict.fromkeys(("update", "calc_normals", "shade_smooth", "shade_flat"), nothing),
        "transform": _transform,
    }


class Vertex(Record):
    """A vertex of a mesh, or of one that is edited."""

    kind = "a vertex"
    is_key = True

    def __init__(self, place: list[float], number: int = 0) -> None:
        self.place = Vector(place)
        self.number = number

    fields: ClassVar[Methods] = {"co": lambda self: self.place, "index": lambda self: self.number}
    setters: ClassVar[Methods] = {
        "co": lambda self, value: self.place.change(reals(value, 3, "the place of a vertex")),
        **ignored("select", "hide", "tag", "index"),
    }


class MeshVertices(Listed):
    """The vertices of a mesh."""

    kind = "`vertices` of a mesh"

    def __init__(self, mesh: Mesh) -> None:
        self._mesh = mesh

    def held(self) -> list[Vertex]:
        return self._mesh.vertices()

    def length(self) -> int:
        return self._mesh.shape.vertices if self._mesh.shape else 0


class MeshElements(Record):
    """The faces, edges and so on of a mesh: whether there are any, and that they are not changed here."""

    def __init__(self, mesh: Mesh, name: str) -> None:
        self.kind = f"`{name}` of a mesh"
        self._mesh = mesh
        self._name = name

    def attribute(self, name: str) -> Value:
        return super().attribute(name) if self._name == "edges" else Unread(self.kind, self._mesh.script)

    def elements(self) -> list[Value]:
        return super().elements() if self._name == "edges" else Unread(self.kind, self._mesh.script).elements()

    def item(self, key: Value) -> Value:
        return super().item(key) if self._name == "edges" else self.attribute("item")

    def truth(self) -> bool:
        return self._mesh.shape is not None


def scale_of(value: Value) -> tuple[float, ...]:
    """Three factors, or one for all axes."""
    return (float(value),) * 3 if is_number(value) else reals(value, 3, "the scale")
