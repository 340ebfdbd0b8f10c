"""Meshes and materials of `bpy.data`, those of Blender's operators and of lists of vertices, with the layout's shape of
each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import ClassVar

import numpy as np

from lidardraft.drafting.blender.bpy.blocks import Block, Blocks, Listed, Unread, ignored, unread
from lidardraft.drafting.blender.bpy.mathutils import IDENTITY, Matrix, Vector, moved
from lidardraft.drafting.blender.script.limits import RefusalError
from lidardraft.drafting.blender.script.values import (
    Methods,
    Record,
    Value,
    elements,
    is_number,
    nothing,
    of_kind,
    place,
    real,
    reals,
    whole,
)
from lidardraft.scene.mesh import triangles_of

Polygons = list[np.ndarray]  # int64 [F, K] each: F polygons of K corners
# With this many corners, a polyhedron counts as the round body that it approximates within 5 % of its radius.
_ROUND_CIRCLE, _ROUND_RINGS, _ROUND_SUBDIVISIONS = 10, 6, 2
_MOST = {"subdivisions": 8}  # greatest values of arguments, if not 500; then the least
_LEAST = dict.fromkeys(("subdivisions", "x_subdivisions", "y_subdivisions", "x_segments", "y_segments"), 1)  # if not 3
_CELLS = 8  # the cost of a vertex that a script moves
_MESH_ELEMENTS = ("edges", "polygons", "loops", "uv_layers", "vertex_colors", "color_attributes", "attributes")


@dataclass(frozen=True, slots=True)
class MeshShape:
    """A mesh before it is made: its shape in the layout, its full extents [m], and `make`, which returns its vertices
    float64 [V, 3] and its faces.

    `shape` is "mesh" if it is none of the others. It is "any" if the triangles decide that; then `size` has no meaning.
    """

    shape: str
    size: tuple[float, float, float]
    vertices: int
    make: Callable[[], tuple[np.ndarray, Polygons]]

    def triangles(self, tick: Callable[[], object] = lambda: None) -> tuple[np.ndarray, np.ndarray]:
        """Its vertices float64 [V, 3] and its faces as triangles int64 [F, 3]; `tick` is that of `triangles_of`."""
        vertices, polygons = self.make()
        counts = np.concatenate([np.zeros(0, dtype=np.int64), *(np.full(*each.shape) for each in polygons)])
        corners = np.concatenate([counts[:0], *(each.ravel() for each in polygons)])
        return vertices, triangles_of(vertices, corners, counts, tick=tick)


def cube(size: float) -> MeshShape:
    """A cube around the origin."""

    def make() -> tuple[np.ndarray, Polygons]:
        half = abs(size) / 2
        corners = [(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)]
        quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        return np.array(corners), [np.array(quads)]

    return MeshShape("box", (abs(size),) * 3, 8, make)


def grid(size: float, columns: int, rows: int) -> MeshShape:
    """A square in z = 0, cut into `columns` along x and `rows` along y."""

    def make() -> tuple[np.ndarray, Polygons]:
        half = abs(size) / 2
        x, y = np.meshgrid(np.linspace(-half, half, columns + 1), np.linspace(-half, half, rows + 1))
        first = (np.arange(columns) + (columns + 1) * np.arange(rows)[:, None]).reshape(-1)
        return np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3), [
            first[:, None] + [0, 1, columns + 2, columns + 1]
        ]

    return MeshShape("plane", (abs(size), abs(size), 0.0), (columns + 1) * (rows + 1), make)


def disc(radius: float, corners: int, filled: bool = True) -> MeshShape | None:
    """A filled circle in z = 0; None without a face."""
    if not filled:
        return None
    return MeshShape("mesh", (0, 0, 0), corners, lambda: (_ring(radius, corners, 0.0), [np.arange(corners)[None]]))


def cone(radius: float, top_radius: float, depth: float, corners: int, capped: bool = True) -> MeshShape:
    """A cone, a frustum or, with equal radii, a cylinder around the z axis."""

    def make() -> tuple[np.ndarray, Polygons]:
        low, high = _ring(radius, corners, -depth / 2), _ring(top_radius, corners, depth / 2)
        ring = np.arange(corners)
        if (radius == 0) != (top_radius == 0):  # one vertex is the tip
            base, tip = (low, high[:1]) if top_radius == 0 else (high, low[:1])
            around = np.stack([ring, np.roll(ring, -1), np.full(corners, corners)], axis=1)
            sides = [around, ring[None, ::-1]] if capped else [around]
            return np.concatenate([base, tip]), sides if top_radius == 0 else [side[:, ::-1] for side in sides]
        polygons = [_band(ring, ring + corners)]
        if capped:
            polygons.append(np.stack([ring[::-1], ring + corners]))
        return np.concatenate([low, high]), polygons

    is_round = corners >= _ROUND_CIRCLE and radius == top_radius and capped
    across = 2 * abs(radius)
    count = corners + 1 if (radius == 0) != (top_radius == 0) else 2 * corners
    return MeshShape("cylinder" if is_round else "mesh", (across, across, abs(depth)), count, make)


def sphere(radius: float, segments: int, rings: int) -> MeshShape:
    """A sphere of rings and segments with its poles on the z axis."""

    def make() -> tuple[np.ndarray, Polygons]:
        polar = np.pi * np.arange(1, rings) / rings
        circle = _ring(1.0, segments, 0.0)
        body = [circle * math.sin(angle) + [0.0, 0.0, math.cos(angle)] for angle in polar]
        vertices = radius * np.concatenate([*body, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
        ring, last = np.arange(segments), (rings - 2) * segments
        north = np.stack([np.full(segments, len(vertices) - 2), ring, np.roll(ring, -1)], axis=1)
        south = np.stack([np.full(segments, len(vertices) - 1), last + np.roll(ring, -1), last + ring], axis=1)
        bands = [_band(ring + start + segments, ring + start) for start in range(0, last, segments)]
        return vertices, [np.concatenate([north, south]), *bands]

    is_round = segments >= _ROUND_CIRCLE and rings >= _ROUND_RINGS
    across = 2 * abs(radius)
    return MeshShape("ellipsoid" if is_round else "mesh", (across,) * 3, segments * (rings - 1) + 2, make)


def icosphere(radius: float, subdivisions: int) -> MeshShape:
    """An icosahedron, each triangle split in four `subdivisions` - 1 times, with its vertices moved to the sphere."""

    def make() -> tuple[np.ndarray, Polygons]:
        high, wide = 1 / math.sqrt(5), 2 / math.sqrt(5)
        angles = [math.radians(72 * (k % 5) + 36 * (k > 4)) for k in range(10)]
        rings = [(-wide * math.cos(a), -wide * math.sin(a), math.copysign(high, k - 4.5)) for k, a in enumerate(angles)]
        vertices = np.array([(0.0, 0.0, -1.0), *rings, (0.0, 0.0, 1.0)])
        faces = []
        for k in range(5):
            a, b, c, d = 1 + k, 1 + (k + 1) % 5, 6 + k, 6 + (k + 1) % 5
            faces += [(0, b, a), (a, b, c), (c, b, d), (c, d, 11)]
        mesh = vertices, np.array(faces)
        for _ in range(subdivisions - 1):
            mesh = _subdivided(*mesh)
        return radius * mesh[0], [mesh[1]]

    across = 2 * abs(radius)
    count = 10 * 4 ** (subdivisions - 1) + 2
    return MeshShape("ellipsoid" if subdivisions >= _ROUND_SUBDIVISIONS else "mesh", (across,) * 3, count, make)


def torus(major: float, minor: float, major_segments: int, minor_segments: int) -> MeshShape:
    """A ring around the z axis."""

    def make() -> tuple[np.ndarray, Polygons]:
        around = 2 * np.pi * np.arange(major_segments) / major_segments
        across = 2 * np.pi * np.arange(minor_segments) / minor_segments
        out = major + minor * np.cos(across)
        x, y = np.outer(np.cos(around), out), np.outer(np.sin(around), out)
        z = np.broadcast_to(minor * np.sin(across), x.shape)
        number = np.arange(x.size).reshape(x.shape)
        after = np.roll(number, -1, axis=0)
        quads = np.stack([number, after, np.roll(after, -1, axis=1), np.roll(number, -1, axis=1)], axis=-1)
        return np.stack([x, y, z], axis=-1).reshape(-1, 3), [quads.reshape(-1, 4)]

    return MeshShape("mesh", (0, 0, 0), major_segments * minor_segments, make)


# The functions of operators of bpy and bmesh that add a shape, and the operators' arguments with their defaults.
SHAPES: dict[str, tuple[Callable[..., MeshShape | None], dict[str, Value]]] = {
    "cube": (cube, {"size": 2.0}),
    "plane": (lambda size: grid(size, 1, 1), {"size": 2.0}),
    "grid": (grid, {"size": 2.0, "x_subdivisions": 10, "y_subdivisions": 10}),
    "circle": (disc, {"radius": 1.0, "vertices": 32, "fill_type": "NOTHING"}),
    "cylinder": (
        lambda radius, *more: cone(radius, radius, *more),
        {"radius": 1.0, "depth": 2.0, "vertices": 32, "end_fill_type": "NGON"},
    ),
    "cone": (cone, {"radius1": 1.0, "radius2": 0.0, "depth": 2.0, "vertices": 32, "end_fill_type": "NGON"}),
    "uv_sphere": (sphere, {"radius": 1.0, "segments": 32, "ring_count": 16}),
    "ico_sphere": (icosphere, {"radius": 1.0, "subdivisions": 2}),
    "torus": (
        # From the radii of a circle and a tube or, in the mode EXT_INT, of the outside and the hole.
        lambda by_tube, major, minor, outer, inner, *segments: torus(
            *((major, minor) if by_tube else ((outer + inner) / 2, (outer - inner) / 2)), *segments
        ),
        {"mode": "MAJOR_MINOR", "major_radius": 1.0, "minor_radius": 0.25, "abso_major_rad": 1.25}
        | {"abso_minor_rad": 0.75, "major_segments": 48, "minor_segments": 12},
    ),
    "create_cube": (cube, {"size": 1.0}),
    "create_grid": (lambda half, *more: grid(2 * half, *more), {"size": 1.0, "x_segments": 1, "y_segments": 1}),
    "create_circle": (disc, {"radius": 1.0, "segments": 32, "cap_ends": False}),
    "create_cone": (cone, {"radius1": 1.0, "radius2": 0.0, "depth": 2.0, "segments": 32, "cap_ends": False}),
    "create_uvsphere": (sphere, {"radius": 1.0, "u_segments": 32, "v_segments": 16}),
    "create_icosphere": (icosphere, {"radius": 1.0, "subdivisions": 2}),
}


def shape_of(operator: str, given: dict[str, Value]) -> MeshShape | None:
    """The shape that an operator makes of its arguments; None if it has no face."""
    make, defaults = SHAPES[operator]
    if unknown := [name for name in given if name not in defaults]:
        raise RefusalError(f"the argument {unknown[0]!r:.60} is not supported; {', '.join(defaults)} are")
    arguments: list[float | bool] = []
    for name, value in (defaults | given).items():
        if isinstance(defaults[name], bool | str):
            arguments.append(value not in (False, "NOTHING", "EXT_INT"))
        elif isinstance(defaults[name], float):
            arguments.append(real(value, name))
        else:
            arguments.append(whole(value, name, _LEAST.get(name, 3), _MOST.get(name, 500)))
    return make(*arguments)


def polyhedron(vertices: np.ndarray, polygons: Polygons) -> MeshShape:
    """A mesh of vertices [V, 3] and faces as they are."""
    return MeshShape("any", (0, 0, 0), len(vertices), lambda: (vertices, polygons))


def polygons_of(faces: Sequence[Sequence[int]]) -> Polygons:
    """Faces of any number of corners, in order; those of less than three corners are left out."""
    runs = groupby((face for face in faces if len(face) > 2), key=len)
    return [np.array(list(run), dtype=np.int64) for _, run in runs]


def _band(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The quads [N, 4] between two rings of corners [N], one over the other."""
    return np.stack([low, np.roll(low, -1), np.roll(high, -1), high], axis=1)


def _ring(radius: float, corners: int, height: float) -> np.ndarray:
    """Corners on a circle, the first of them on +y as in Blender: float64 [corners, 3]."""
    angle = np.pi / 2 + 2 * np.pi * np.arange(corners) / corners
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(corners, height)], axis=1)


def _subdivided(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each triangle split in four, with the new vertices on the unit sphere."""
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    distinct, place = np.unique(edges, axis=0, return_inverse=True)
    middles = vertices[distinct].mean(axis=1)
    middles /= np.linalg.norm(middles, axis=1, keepdims=True)
    ab, bc, ca = (len(vertices) + place.reshape(-1)).reshape(3, -1)
    a, b, c = faces.T
    corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([vertices, middles]), np.concatenate([np.stack(corner, axis=1) for corner in corners])


class Material(Block):
    """A material; only its name is read."""

    kind = "a material"
    fields: ClassVar[Methods] = Block.fields | unread("materials", "node_tree", "diffuse_color", "use_nodes")

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
        self.materials.append(_material(material))

    def held(self) -> list[Material | None]:
        return self.materials

    def __setitem__(self, key: Value, value: Value) -> None:
        self.materials[place(key, len(self.materials), self.kind)] = _material(value)

    methods: ClassVar[Methods] = Listed.methods | {
        "append": append,
        "clear": lambda self: self.materials.clear(),
        "pop": lambda self, index=-1, **_: self.materials.pop(whole(index, "the index")),
    }


def _material(value: Value) -> Material | None:
    return value if value is None else of_kind(value, Material, "the material")


class Mesh(Block):
    """A mesh: its original shape, the transform of that, and its materials."""

    kind = "a mesh"

    def __init__(self, owner: Blocks, shape: MeshShape | None = None) -> None:
        super().__init__(owner)
        self.shape = shape
        self.matrix = IDENTITY
        self.materials = MaterialList()
        self._vertices: list[Vertex] = []
        self._read: MeshShape | None = None  # the shape of these vertices

    def copy(self) -> Mesh:
        """Another mesh of the same shape and materials."""
        self.script.take_made(self.properties)
        self.script.take_made(self.materials.materials)
        mesh: Mesh = self.owner.new(self.name)
        mesh.shape, mesh.matrix = self.shape, self.matrix
        mesh.materials.materials = list(self.materials.materials)
        mesh.properties = dict(self.properties)
        return mesh

    def made(self) -> tuple[np.ndarray, Polygons]:
        """Its vertices float64 [V, 3] and its faces; empty without a shape."""
        self.script.check_time()
        if self.shape is None:
            return np.zeros((0, 3)), []
        vertices, polygons = self.shape.make()
        return moved(vertices, self.matrix), polygons

    def vertices(self) -> list[Vertex]:
        """Its vertices; moving them changes the mesh."""
        if self.shape is None or (self._vertices and self._read is self.shape):
            return self._vertices if self.shape else []
        self.script.take_cells(_CELLS * self.shape.vertices)
        places, faces = self.made()
        vertices = [Vertex(place, number) for number, place in enumerate(places.tolist())]
        self.shape = replace(
            self.shape, shape="any", make=lambda: (np.array([vertex.place.numbers for vertex in vertices]), faces)
        )
        self.matrix, self._vertices, self._read = IDENTITY, vertices, self.shape
        return vertices

    def _transform(self, matrix: Value) -> None:
        if not isinstance(matrix, Matrix) or matrix.array.shape != (4, 4):
            raise RefusalError("a mesh is transformed by a matrix of 4 rows")
        self.matrix = matrix.array @ self.matrix

    def _from_pydata(self, vertices: Value, _edges: Value, faces: Value, *_: Value) -> None:
        script = self.script
        places, sides = elements(vertices, script), elements(faces, script)
        points = np.array([reals(place, 3, "a vertex") for place in places]).reshape(-1, 3)
        polygons: list[tuple[int, ...]] = []
        for face in sides:
            corners = tuple(elements(face, script))
            if not all(type(corner) is int and 0 <= corner < len(points) for corner in corners):
                raise RefusalError(f"face {len(polygons)} is {corners!r:.60}; the mesh has {len(points)} vertices")
            polygons.append(corners)
        shaped = polygons_of(polygons)
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
    """A vertex of a mesh or an edited mesh."""

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

    def __len__(self) -> int:
        return self._mesh.shape.vertices if self._mesh.shape else 0


class MeshElements(Record):
    """The faces, edges and so on of a mesh: scripts can test for any; other uses are ignored or, of edges, refused."""

    def __init__(self, mesh: Mesh, name: str) -> None:
        self.kind = f"`{name}` of a mesh"
        self._mesh = mesh
        self._name = name

    def attribute(self, name: str) -> Value:
        return super().attribute(name) if self._name == "edges" else Unread(self.kind, self._mesh.script)

    def __iter__(self) -> Iterator[Value]:
        return super().__iter__() if self._name == "edges" else iter(Unread(self.kind, self._mesh.script))

    def __getitem__(self, key: Value) -> Value:
        return super().__getitem__(key) if self._name == "edges" else self.attribute("item")

    def __bool__(self) -> bool:
        return self._mesh.shape is not None


def scale_of(value: Value) -> tuple[float, ...]:
    """Three scale factors, or one for all axes."""
    return (float(value),) * 3 if is_number(value) else reals(value, 3, "the scale")
